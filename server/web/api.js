// What the page asks of the server.
import { parseTiles } from './tiles.js';

async function get(path) {
  const response = await fetch(path);
  if (response.ok) return response;
  const problem = await response.json().catch(() => ({}));
  throw new Error(problem.detail ?? `${path}: ${response.status}`);
}

export const fetchJobs = async () => (await (await get('/v1/jobs')).json()).jobs;
export const fetchJob = async (id) => (await get(`/v1/jobs/${id}`)).json();
export const fetchWorkers = async () => (await (await get('/v1/workers')).json()).workers;

export async function fetchTiles(job, frame, since) {
  return parseTiles(await (await get(`/v1/jobs/${job}/frames/${frame}/tiles?since=${since}`)).arrayBuffer());
}

/** Listens to all events; `heard` is given {type, data} of each, `state` true or false as the stream opens and breaks. */
export function listen(heard, state) {
  const source = new EventSource('/v1/events');
  source.onopen = () => state(true);
  source.onerror = () => state(false);
  for (const type of ['job', 'frame', 'removed', 'worker', 'lost']) {
    source.addEventListener(type, (event) => heard({ type, data: JSON.parse(event.data || '{}') }));
  }
}
