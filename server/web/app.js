// The page: jobs, workers and the picture of the job that is chosen. The address's hash names it: #job=3&frame=1.
import { fetchJob, fetchJobs, fetchWorkers, listen } from './api.js';
import { count, jobLine, percent, samplesOf, span } from './format.js';
import { Picture } from './picture.js';

const element = (id) => document.getElementById(id);
const picture = new Picture(element('picture'));
let chosen = null; // {job, frame}

function make(tag, text, className) {
  const node = document.createElement(tag);
  if (text !== undefined) node.textContent = text;
  if (className) node.className = className;
  return node;
}

function showProgress(bar, job) {
  bar.value = job.progress;
  bar.className = job.state;
  bar.setAttribute('aria-label', percent(job.progress));
}

/** The list keeps its nodes, so that focus and clicks survive an update. */
function showJobs(jobs) {
  const list = element('jobs');
  const kept = new Map([...list.children].map((item) => [item.dataset.id, item]));
  for (const job of [...jobs].sort((a, b) => b.id - a.id)) {
    let item = kept.get(String(job.id));
    if (!item) {
      item = make('li');
      item.dataset.id = job.id;
      const button = make('button');
      const title = make('span', undefined, 'title');
      title.append(make('b', job.name), make('span', undefined, 'state'));
      button.append(title, make('progress'), make('span', undefined, 'small'));
      button.addEventListener('click', () => choose(job.id));
      item.append(button);
    }
    kept.delete(String(job.id));
    const state = item.querySelector('.state');
    state.textContent = job.state;
    state.className = `state ${job.state}`;
    showProgress(item.querySelector('progress'), job);
    item.querySelector('.small').textContent = jobLine(job);
    item.firstChild.setAttribute('aria-pressed', String(chosen?.job === job.id));
    list.append(item);
  }
  for (const item of kept.values()) item.remove();
  element('no-jobs').hidden = jobs.length > 0;
}

function showWorkers(workers) {
  element('workers').replaceChildren(
    ...workers.map((worker) => {
      const row = make('tr');
      row.append(make('td', worker.name), make('td', worker.state), make('td', worker.threads, 'number'),
        make('td', count(worker.tasks_done), 'number'), make('td', count(worker.samples_per_second), 'number'));
      return row;
    }),
  );
  element('no-workers').hidden = workers.length > 0;
}

function showFacts(job) {
  const facts = [
    ['Job', job.id],
    ['Film', `${job.width} × ${job.height}`],
    ['Samples a pixel', samplesOf(job, chosen.frame)],
    ['Tasks', `${count(job.tasks_done)} of ${count(job.tasks)}`],
    ['Rendering', job.render_seconds > 0 ? span(job.render_seconds) : 'not yet'],
    ['Rays', count(job.rays)],
    ['Integrator', job.spec.render.integrator],
    ['Sampler', `${job.spec.render.sampler}, seed ${job.spec.render.seed}`],
    ['Filter', job.spec.render.filter],
  ];
  if (job.rejected_samples > 0) facts.push(['Samples NaN or Inf', count(job.rejected_samples)]);
  if (job.failures > 0) {
    const link = make('a', count(job.failures));
    link.href = `/v1/jobs/${job.id}/failures`;
    facts.push(['Failed attempts', link]);
  }
  for (const share of job.shares.slice(0, 6)) facts.push([`By ${share.worker}`, `${count(share.samples)} samples`]);
  element('facts').replaceChildren(
    ...facts.map(([name, value]) => {
      const group = make('div');
      const fact = make('dd');
      fact.append(value);
      group.append(make('dt', name), fact);
      return group;
    }),
  );
}

function showFrames(job) {
  element('frame-choice').hidden = job.frames.count < 2;
  const select = element('frame');
  const frames = Math.min(job.frames.count, 1000);
  if (select.options.length !== frames) {
    select.replaceChildren();
    for (const { first, last, step } of job.frames.ranges)
      for (let number = first; number <= last && select.options.length < frames; number += step)
        select.append(new Option(number));
  }
  select.value = chosen.frame;
}

function showJob(job) {
  element('job').hidden = false;
  element('job-name').textContent = job.name;
  element('job-state').textContent = job.state;
  element('job-state').className = `state ${job.state}`;
  showProgress(element('job-progress'), job);
  element('job-line').textContent = jobLine(job);
  element('job-error').hidden = !job.error;
  element('job-error').textContent = job.error ?? '';
  showFrames(job);
  showFacts(job);
  showLinks();
}

function showLinks() {
  const base = `/v1/jobs/${chosen.job}/frames/${chosen.frame}/`;
  element('link-exr').href = `${base}image.exr`;
  element('link-png').href = `${base}image.png?exposure=${picture.stops}`;
}

async function choose(id, frame) {
  const job = await fetchJob(id);
  chosen = { job: id, frame: frame ?? job.frames.first };
  history.replaceState(null, '', `#job=${id}&frame=${chosen.frame}`);
  for (const item of element('jobs').children) item.firstChild.setAttribute('aria-pressed', String(item.dataset.id === String(id)));
  picture.open(id, chosen.frame);
  showJob(job);
  await picture.refresh();
}

/** One update at a time; what is asked for meanwhile is done once, after. */
function gathered(work, pause) {
  let busy = false;
  let again = false;
  return async function run() {
    if (busy) {
      again = true;
      return;
    }
    busy = true;
    try {
      await work();
    } catch (error) {
      showConnection(false, error.message);
    }
    setTimeout(() => {
      busy = false;
      if (again) {
        again = false;
        run();
      }
    }, pause);
  };
}

const updateJobs = gathered(async () => {
  const jobs = await fetchJobs();
  showJobs(jobs);
  if (chosen === null) {
    const wanted = new URLSearchParams(location.hash.slice(1));
    const first = jobs.find((job) => job.id === Number(wanted.get('job'))) ?? jobs.findLast((job) => job.state === 'rendering') ?? jobs.at(-1);
    if (first) await choose(first.id, wanted.has('frame') && first.id === Number(wanted.get('job')) ? Number(wanted.get('frame')) : undefined);
  } else {
    showJob(await fetchJob(chosen.job));
    await picture.refresh();
  }
}, 250);
const updateWorkers = gathered(async () => showWorkers(await fetchWorkers()), 500);

function showConnection(good, why) {
  const line = element('connection');
  line.textContent = good ? 'live' : why ? `not up to date: ${why}` : 'the server is away; trying again…';
  line.className = good ? '' : 'lost';
}

element('exposure').addEventListener('input', (event) => {
  element('stops').textContent = Number(event.target.value).toFixed(1);
  picture.expose(Number(event.target.value));
  if (chosen) showLinks();
});
element('frame').addEventListener('change', (event) => choose(chosen.job, Number(event.target.value)).catch((error) => showConnection(false, error.message)));

listen(
  ({ type, data }) => {
    if (type === 'frame' && chosen && (data.job === undefined || data.job === chosen.job)) picture.refresh().catch(() => {});
    if (type !== 'frame') updateWorkers();
    updateJobs();
  },
  (good) => {
    showConnection(good);
    if (good) {
      updateJobs();
      updateWorkers();
    }
  },
);
setInterval(updateJobs, 2000);
setInterval(updateWorkers, 2000);
updateJobs();
updateWorkers();
