// A computation that takes its time: followed by its events, or by asking where those are refused.
import { ask, getJob, Problem } from "./api";
import type { JobReport } from "./contract";

const POLL_MS = 250;

const ended = (job: JobReport) => !["accepted", "running"].includes(job.status);

/** Waits for the end of a job; `tell` hears how far it is. */
export async function follow(job: JobReport, signal: AbortSignal, tell: (progress: number) => void) {
  let last = job;
  try {
    for await (const report of events(job.id, signal)) {
      last = report;
      tell(report.progress);
      if (ended(report)) return report;
    }
  } catch (error) {
    if (signal.aborted) throw error;
  }
  while (!ended(last)) {
    last = await getJob(job.id, signal);
    tell(last.progress);
    if (!ended(last)) await new Promise((resolve) => setTimeout(resolve, POLL_MS));
  }
  return last;
}

/** Server-sent events, read by hand: an EventSource cannot send the token. */
async function* events(id: string, signal: AbortSignal): AsyncGenerator<JobReport> {
  const response = await ask(`/v1/jobs/${id}/events`, { signal, retries: 0 });
  if (!response.body) throw new Problem(response.status, "no events", []);
  const reader = response.body.pipeThrough(new TextDecoderStream()).getReader();
  let text = "";
  for (;;) {
    const { done, value } = await reader.read();
    if (done) return;
    text += value;
    const parts = text.split("\n\n");
    text = parts.pop()!;
    for (const part of parts) {
      const data = part.split("\n").find((line) => line.startsWith("data: "));
      if (data) yield JSON.parse(data.slice(6)) as JobReport;
    }
  }
}
