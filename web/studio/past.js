// The frames of the last 30 s: for the charts, and to look back.

export const SPAN = 30;

export class Past {
  constructor() { this.frames = []; }

  clear() { this.frames = []; }

  add(frame) {
    while (this.frames.length && this.frames[this.frames.length - 1][0] >= frame[0]) this.frames.pop();
    this.frames.push(frame);
    if (this.frames.length > 64 && this.frames[64][0] < this.end - SPAN) this.frames = this.frames.slice(64);
  }

  get end() { return this.frames.length ? this.frames[this.frames.length - 1][0] : 0; }
  get start() { return this.frames.length ? Math.max(this.frames[0][0], this.end - SPAN) : 0; }

  /** The last frame that is not after a time; the first one where all are. */
  at(time) {
    let low = 0, high = this.frames.length;
    while (low < high) {
      const middle = (low + high) >> 1;
      if (this.frames[middle][0] <= time + 1e-6) low = middle + 1; else high = middle;
    }
    return this.frames[Math.max(0, low - 1)];
  }
}
