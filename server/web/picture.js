// The film of one frame on a canvas: fetches what changed, keeps it, and shows it at any exposure.
import { fetchTiles } from './api.js';
import { shown } from './tiles.js';

export class Picture {
  constructor(canvas) {
    this.canvas = canvas;
    this.context = canvas.getContext('2d');
    this.stops = 0;
    this.clear();
  }

  /** Shows another frame from nothing. */
  open(job, frame) {
    this.clear();
    this.job = job;
    this.frame = frame;
  }

  clear() {
    this.job = null;
    this.version = 0;
    this.tiles = new Map(); // "x,y" → the tile as it came last
    this.asking = null;
    this.again = false;
    this.canvas.width = 1;
    this.canvas.height = 1;
  }

  /** Something changed: asks for it, once at a time; what changes meanwhile is asked for after. */
  async refresh() {
    if (this.job === null) return;
    if (this.asking) {
      this.again = true;
      return;
    }
    const asking = (this.asking = {});
    try {
      const change = await fetchTiles(this.job, this.frame, this.version);
      if (this.asking === asking && change) this.take(change);
    } finally {
      if (this.asking === asking) {
        this.asking = null;
        if (this.again) {
          this.again = false;
          setTimeout(() => this.refresh().catch(() => {}), 80);
        }
      }
    }
  }

  take(change) {
    if (this.canvas.width !== change.width || this.canvas.height !== change.height) {
      this.canvas.width = change.width;
      this.canvas.height = change.height;
      this.canvas.classList.toggle('pixels', change.width < 300);
    }
    if (change.version < this.version) this.tiles.clear(); // another film: the server was started again
    this.version = change.version;
    for (const tile of change.tiles) {
      this.tiles.set(`${tile.x},${tile.y}`, tile);
      this.draw(tile);
    }
  }

  draw(tile) {
    const image = this.context.createImageData(tile.width, tile.height);
    shown(tile.rgba, this.stops, image.data);
    this.context.putImageData(image, tile.x, tile.y);
  }

  expose(stops) {
    this.stops = stops;
    for (const tile of this.tiles.values()) this.draw(tile);
  }
}
