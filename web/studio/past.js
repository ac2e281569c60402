// The frames of the flight so far: for the charts, and to look back.

const MOST = 9000; // frames that are kept; of a flight that is longer, older ones are fewer

export class Past {
  constructor() { this.frames = []; }

  clear() { this.frames = []; }

  add(frame) {
    while (this.frames.length && this.frames[this.frames.length - 1][0] >= frame[0]) this.frames.pop();
    this.frames.push(frame);
    if (this.frames.length > MOST) this.frames = this.frames.filter((_, i) => i >= MOST / 2 || i % 2 === 0);
  }

  get end() { return this.frames.length ? this.frames[this.frames.length - 1][0] : 0; }
  get start() { return this.frames.length ? this.frames[0][0] : 0; }

  /** Number of the last frame that is not after a time; the first one where all are. */
  index(time) {
    let low = 0, high = this.frames.length;
    while (low < high) {
      const middle = (low + high) >> 1;
      if (this.frames[middle][0] <= time + 1e-6) low = middle + 1; else high = middle;
    }
    return Math.max(0, low - 1);
  }

  at(time) { return this.frames[this.index(time)]; }
}
