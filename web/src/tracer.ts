// Asks for curves whenever the request changes: coarse ones while something is dragged, stored exact
// ones when it rests. One request is in flight at a time; answers to what is no longer asked are dropped.
import { cancelJob, getCurves, getResult, Problem, startTrace, traceUnstored } from "./api";
import type { ContourRequest, Json } from "./contract";
import { follow } from "./jobs";
import { get, isObject } from "./pointer";
import { receiverOf } from "./scene";
import type { State, Store, Traced } from "./state";

const TYPING_MS = 150; // the next key comes within it
const COARSE_CHORD = 4e-4; // of the larger side of the receiver
const COARSE_IRRADIANCE = 1e-6;
const SLOW_MS = 50; // 20 answers a second are the least
const PATIENCE_MS = 300; // when the service has too much to do

export class Tracer {
  private running: AbortController | null = null;
  private coarseInFlight = false;
  private timer = 0;

  constructor(private readonly store: Store) {
    store.listen((now, before) => {
      if (now.request === before.request && now.dragging === before.dragging) return;
      if (now.dragging) void this.follow();
      else this.settle(before.dragging || now.example !== null);
    });
  }

  /** The present request, exactly and stored; at once, or when typing pauses. */
  settle(now = true): void {
    this.stop();
    this.timer = window.setTimeout(() => void this.trace(), now ? 0 : TYPING_MS);
  }

  stop(): void {
    clearTimeout(this.timer);
    this.running?.abort();
    this.running = null;
    if (this.store.now.work) this.store.set({ work: null });
  }

  private async follow(): Promise<void> {
    if (this.coarseInFlight) return;
    this.stop();
    this.coarseInFlight = true;
    let asked: ContourRequest | null = null;
    let slow = false;
    while (this.store.now.dragging && asked !== this.store.now.request) {
      asked = this.store.now.request;
      const abort = (this.running = new AbortController());
      try {
        const begun = performance.now();
        const traced = await traceUnstored(coarsened(asked, slow), abort.signal, 0);
        slow ||= performance.now() - begun > SLOW_MS;
        if (!abort.signal.aborted) this.show({ ...traced, request: asked, coarse: true });
      } catch (error) {
        if (abort.signal.aborted) break;
        if (error instanceof Problem && error.passing) {
          await new Promise((resolve) => setTimeout(resolve, PATIENCE_MS));
          asked = null;
        } else this.store.set(troubleOf(error));
      }
    }
    this.coarseInFlight = false;
  }

  private async trace(): Promise<void> {
    const abort = (this.running = new AbortController());
    const { request } = this.store.now;
    try {
      const traced = await this.exact(request, abort.signal);
      if (traced && !abort.signal.aborted) this.show({ ...traced, request, coarse: false });
    } catch (error) {
      if (!abort.signal.aborted) this.store.set({ ...troubleOf(error), work: null });
    }
  }

  private async exact(request: ContourRequest, signal: AbortSignal): Promise<Pick<Traced, "answer" | "curves">> {
    const started = await startTrace(request, signal);
    if (started.answer) return { answer: started.answer, curves: await getCurves(started.answer, signal) };
    const { id } = started.job;
    let cancelled = false;
    const cancel = () => {
      cancelled = true;
      void cancelJob(id).catch(() => undefined); // it may have ended by itself
    };
    signal.addEventListener("abort", cancel);
    this.store.set({ work: { progress: 0, cancel } });
    const report = await follow(started.job, signal, (progress) => {
      if (!signal.aborted) this.store.set({ work: { progress, cancel } });
    });
    signal.removeEventListener("abort", cancel);
    if (report.problem) throw new Problem(report.problem.status, report.problem.detail, report.problem.errors ?? []);
    // Somebody else who asked the same may have cancelled it for all.
    if (!report.result && !cancelled) return this.exact(request, signal);
    if (!report.result) throw new Problem(0, "Cancelled.", []);
    return getResult(report.result, signal);
  }

  private show(traced: Traced): void {
    this.store.set({ traced, faults: [], trouble: null, work: null });
  }
}

function troubleOf(error: unknown): Pick<State, "faults" | "trouble"> {
  if (error instanceof Problem) return { faults: error.faults, trouble: error.message };
  return { faults: [], trouble: "The service cannot be reached." };
}

/**
 * The same curves with fewer vertices. Where the total takes long, and was not asked for by name, its sheets: they
 * can follow, and differ from it only where they overlap.
 */
function coarsened(request: ContourRequest, slow: boolean): ContourRequest {
  const given = get(request, "/tolerance");
  const own = isObject(given) ? given : {};
  const size = receiverOf(request)?.size;
  const tolerance: { [key: string]: Json } = { ...own };
  tolerance["irradiance"] = Math.max(Number(own["irradiance"] ?? 0), COARSE_IRRADIANCE);
  if (size) tolerance["chord"] = Math.max(Number(own["chord"] ?? 0), COARSE_CHORD * Math.max(...size));
  const sheets = slow && !("measure" in request) && !request["direct"] && !("include" in request);
  return { ...request, tolerance, certify: false, ...(sheets && { measure: "sheet" }) };
}
