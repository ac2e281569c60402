// The time that is shown, and how it runs.

export class Clock extends EventTarget {
  constructor(end) {
    super();
    this.end = end;
    this.time = 0;
    this.speed = 1;
    this.playing = false;
  }

  set(time) {
    this.time = Math.min(this.end, Math.max(0, time));
    this.dispatchEvent(new Event("time"));
  }

  play(playing = !this.playing) {
    if (playing && this.time >= this.end - 1e-6) this.set(0);
    this.playing = playing;
    this.dispatchEvent(new Event("state"));
  }

  /** Go on by a span of real time, s. */
  pass(seconds) {
    if (!this.playing) return;
    this.set(this.time + this.speed * Math.min(seconds, 0.25));
    if (this.time >= this.end) this.play(false);
  }
}
