// The pure modules of server/web: what they read and what they show.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import test from 'node:test';

const load = (name) => {
  const source = readFileSync(new URL(`../../server/web/${name}`, import.meta.url), 'utf8');
  return import(`data:text/javascript,${encodeURIComponent(source)}`);
};
const { parseTiles, shown, toByte } = await load('tiles.js');
const { count, jobLine, percent, samplesOf, span } = await load('format.js');

/** Bytes as server/film/README.md describes them. */
function tilesBytes(header, halves) {
  const text = new TextEncoder().encode(JSON.stringify(header));
  const padded = Math.ceil(text.length / 8) * 8;
  const buffer = new ArrayBuffer(8 + padded + 2 * halves.length);
  const view = new DataView(buffer);
  new Uint8Array(buffer).fill(32, 8, 8 + padded);
  new Uint8Array(buffer).set(new TextEncoder().encode('TSRT'));
  view.setUint32(4, padded, true);
  new Uint8Array(buffer).set(text, 8);
  halves.forEach((half, i) => view.setUint16(8 + padded + 2 * i, half, true));
  return buffer;
}

const header = { version: 9, width: 3, height: 1, tiles: [{ x: 0, y: 0, width: 2, height: 1 }, { x: 2, y: 0, width: 1, height: 1 }] };
const one = 0x3c00, half = 0x3800, two = 0x4000;
const halves = [one, half, 0, one, 0, 0, 0, 0, two, 0x8000, 0x7c00, one];

test('tiles are read one after another', () => {
  const change = parseTiles(tilesBytes(header, halves));
  assert.equal(change.version, 9);
  assert.deepEqual([...change.tiles[0].rgba], halves.slice(0, 8));
  assert.deepEqual([...change.tiles[1].rgba], halves.slice(8));
  assert.equal(change.tiles[1].x, 2);
});

test('what is cut off or something else is refused', () => {
  const good = tilesBytes(header, halves);
  assert.throws(() => parseTiles(good.slice(0, good.byteLength - 2)), /cut off/);
  assert.throws(() => parseTiles(good.slice(0, 20)), /cut off/);
  assert.throws(() => parseTiles(new TextEncoder().encode('<!doctype html>').buffer), /no tiles/);
  assert.throws(() => parseTiles(new ArrayBuffer(3)), /no tiles/);
});

test('half floats are exposed, encoded as sRGB and taken apart from alpha', () => {
  const bytes = shown(Uint16Array.from(halves), 0, new Uint8ClampedArray(12));
  assert.deepEqual([...bytes], [255, 188, 0, 255, 0, 0, 0, 0, 255, 0, 255, 255]);
  assert.equal(shown(Uint16Array.from([half, 0, 0, half]), 0, new Uint8ClampedArray(4))[0], 255, 'premultiplied');
  assert.equal(shown(Uint16Array.from([two, 0, 0, one]), -2, new Uint8ClampedArray(4))[0], 188, 'two stops down');
});

test('every sRGB byte is what the formula gives', () => {
  for (let i = 0; i <= 4000; ++i) {
    const linear = i / 4000;
    const exact = 255 * (linear <= 0.0031308 ? 12.92 * linear : 1.055 * linear ** (1 / 2.4) - 0.055);
    assert.ok(Math.abs(toByte(linear) - exact) <= 0.52, `${linear}: ${toByte(linear)} for ${exact}`);
  }
  assert.equal(toByte(NaN), 0);
  assert.equal(toByte(-1), 0);
});

test('numbers and times are shown as people read them', () => {
  assert.equal(count(999), '999');
  assert.equal(count(12345), '12.3 k');
  assert.equal(count(1234567), '1.23 M');
  assert.equal(span(3.25), '3.3 s');
  assert.equal(span(200), '3 min 20 s');
  assert.equal(span(7500), '2 h 05 min');
  assert.equal(percent(0.9999), '99.9 %');
  assert.equal(percent(1), '100 %');
  const job = { state: 'rendering', progress: 0.42, samples_per_second: 2e6, eta_seconds: 61, render_seconds: 5 };
  assert.equal(jobLine(job), '42 % · 2.00 M samples/s · 1 min 01 s to go');
  const frames = { ...job, frames_shortened: 2, frames: { count: 5 } };
  assert.equal(jobLine(frames), '42 % · 2.00 M samples/s · 2 of 5 frames ended by their noise · 1 min 01 s to go');
});

test('a frame that ended by its noise says its own samples', () => {
  const job = { samples: 512, pictures: [{ frame: 3, version: 9, samples: 64 }, { frame: 4, version: 2, samples: 512 }] };
  assert.equal(samplesOf(job, 3), '64 (of 512 at most)');
  assert.equal(samplesOf(job, 4), '512');
  assert.equal(samplesOf(job, 5), '512', 'one that has no picture yet');
  assert.equal(samplesOf({ samples: 512 }, 3), '512', 'an older server');
  assert.equal(samplesOf({ ...job, frames_shortened: 1 }, 5), '512 at most', 'one beyond those that the job names');
});
