import { Problem, readJob, type Job } from '../api.ts';

/** Milliseconds between two looks at a job. */
const WAIT_MS = 250;

const pause = (ms: number) => new Promise((resolve) => setTimeout(resolve, ms));

/** Looks at a job until it is ended; `seen` hears of every look. Undefined if it was given up meanwhile. */
export async function ended(id: string, seen: (job: Job) => void): Promise<Job | undefined> {
  for (;;) {
    let job: Job;
    try {
      job = await readJob(id);
    } catch (error) {
      if (error instanceof Problem && error.status === 404) return undefined;
      if (error instanceof Problem && ![429, 503].includes(error.status)) throw error;
      await pause(8 * WAIT_MS); // the server is busy or away: the job is kept
      continue;
    }
    seen(job);
    if (job.state === 'done' || job.state === 'failed' || job.state === 'stopped') return job;
    await pause(WAIT_MS);
  }
}
