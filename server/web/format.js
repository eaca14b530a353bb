// How numbers and times are shown. Pure.

/** 1234567 → "1.23 M". */
export function count(value) {
  for (const [limit, sign] of [[1e12, 'T'], [1e9, 'G'], [1e6, 'M'], [1e4, 'k']]) {
    if (value >= limit) return `${(value / (sign === 'k' ? 1e3 : limit)).toPrecision(3)} ${sign}`;
  }
  return String(Math.round(value));
}

/** Seconds as "8 s", "3 min 20 s", "2 h 05 min". */
export function span(seconds) {
  const whole = Math.round(seconds);
  if (seconds < 10) return `${seconds.toFixed(1)} s`;
  if (whole < 60) return `${whole} s`;
  if (whole < 3600) return `${Math.floor(whole / 60)} min ${String(whole % 60).padStart(2, '0')} s`;
  return `${Math.floor(whole / 3600)} h ${String(Math.floor((whole % 3600) / 60)).padStart(2, '0')} min`;
}

/** 0…1 as "42 %"; never 100 before it is. */
export function percent(fraction) {
  if (fraction >= 1) return '100 %';
  const fine = fraction < 0.1 || fraction > 0.99;
  return `${Math.min(99.9, fraction * 100).toFixed(fine ? 1 : 0)} %`;
}

/** "8 min 00 s (7 min 10 s – 9 min 30 s)": the time to finish and its 80 % interval. */
export function timeToGo(job) {
  const [low, high] = [job.eta_low_seconds ?? job.eta_seconds, job.eta_high_seconds ?? job.eta_seconds].map(span);
  return low === high ? span(job.eta_seconds) : `${span(job.eta_seconds)} (${low} – ${high})`;
}

/** "64 (of 4,096 at most)": of each pixel of the frame that is looked at, as far as the job says: it names a thousand. */
export function samplesOf(job, frame) {
  const samples = job.pictures?.find((picture) => picture.frame === frame)?.samples;
  if (samples === undefined) return job.frames_shortened > 0 ? `${count(job.samples)} at most` : count(job.samples);
  return samples < job.samples ? `${count(samples)} (of ${count(job.samples)} at most)` : count(samples);
}

/** One line about a job's progress. */
export function jobLine(job) {
  const parts = [percent(job.progress)];
  if (job.state === 'rendering' && job.samples_per_second > 0) parts.push(`${count(job.samples_per_second)} samples/s`);
  if (job.frames_shortened > 0) parts.push(`${job.frames_shortened} of ${job.frames.count} frames ended by their noise`);
  if (job.state === 'rendering' && job.eta_seconds !== null) parts.push(`${timeToGo(job)} to go`);
  if (job.render_seconds > 0 && job.state !== 'rendering') parts.push(`rendered in ${span(job.render_seconds)}`);
  return parts.join(' · ');
}
