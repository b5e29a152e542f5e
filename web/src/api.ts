// Requests to the service, and what it says when it cannot answer.
import type { ContourAnswer, ContourRequest, CurveCollection, Fault, Json, JobReport, Reading, Vec2 } from "./contract";
import { askForToken, token } from "./token";

export class Problem extends Error {
  constructor(
    readonly status: number,
    detail: string,
    readonly faults: Fault[],
  ) {
    super(detail);
  }
  /** It may well be answered a little later. */
  get passing(): boolean {
    return this.status === 429 || this.status === 503;
  }
}

export interface Call {
  method?: string;
  body?: Json;
  signal?: AbortSignal;
  headers?: Record<string, string>;
  /** How often to ask again while the service has too much to do. */
  retries?: number;
}

const RETRIES = 5;
const PATIENCE_MS = 400;

export async function ask(path: string, call: Call = {}): Promise<Response> {
  const headers: Record<string, string> = { ...call.headers };
  if (call.body !== undefined) headers["Content-Type"] = "application/json";
  if (token()) headers["Authorization"] = `Bearer ${token()}`;
  const response = await fetch(path, {
    method: call.method ?? (call.body === undefined ? "GET" : "POST"),
    headers,
    body: call.body === undefined ? null : JSON.stringify(call.body),
    signal: call.signal ?? null,
  });
  if (response.status === 401) {
    await askForToken();
    return ask(path, call);
  }
  if (response.ok) return response;
  const problem = await problemOf(response);
  const retries = call.retries ?? RETRIES;
  if (!problem.passing || retries === 0) throw problem;
  await new Promise((resolve) => setTimeout(resolve, PATIENCE_MS));
  call.signal?.throwIfAborted();
  return ask(path, { ...call, retries: retries - 1 });
}

async function problemOf(response: Response): Promise<Problem> {
  try {
    const { detail, errors } = (await response.json()) as { detail: string; errors?: Fault[] };
    return new Problem(response.status, detail, errors ?? []);
  } catch {
    return new Problem(response.status, `the service answered ${response.status}`, []);
  }
}

async function json<T>(path: string, call?: Call): Promise<T> {
  return (await (await ask(path, call)).json()) as T;
}

export const listExamples = async () =>
  (await json<{ examples: { name: string; title: string }[] }>("/v1/examples")).examples;

export const getExample = (name: string) =>
  json<ContourRequest>(`/v1/examples/${encodeURIComponent(name)}`);

/** Traced at once; nothing is stored, the curves come with the answer. */
export async function traceUnstored(request: ContourRequest, signal?: AbortSignal, retries?: number) {
  const answer = await json<ContourAnswer>("/v1/contours", {
    body: { ...request, store: false },
    ...(signal && { signal }),
    ...(retries !== undefined && { retries }),
  });
  return { answer, curves: answer.geojson! };
}

export async function getResult(path: string, signal: AbortSignal) {
  const answer = await json<ContourAnswer>(path, { signal });
  return { answer, curves: await getCurves(answer, signal) };
}

export const getCurves = (answer: ContourAnswer, signal: AbortSignal) =>
  json<CurveCollection>(answer.files["geojson"]!, { signal });

/** The stored answer, or the job that computes it. */
export async function startTrace(request: ContourRequest, signal: AbortSignal) {
  const response = await ask("/v1/contours", {
    body: { ...request, store: true },
    headers: { Prefer: "respond-async" },
    signal,
  });
  if (response.status === 202) return { job: (await response.json()) as JobReport };
  return { answer: (await response.json()) as ContourAnswer };
}

export const cancelJob = (id: string) => ask(`/v1/jobs/${id}`, { method: "DELETE" });

export const getJob = (id: string, signal: AbortSignal) => json<JobReport>(`/v1/jobs/${id}`, { signal });

/** What a light meter reads at these points. */
export async function read(request: ContourRequest, points: Vec2[]): Promise<Reading[]> {
  const body: { [key: string]: Json } = { scene: request["scene"] ?? null, points };
  for (const key of ["families", "direct"]) if (key in request) body[key] = request[key]!;
  return (await json<{ points: Reading[] }>("/v1/irradiance", { body })).points;
}
