// The time of the flight over the full width: looking back, what happened, contact, and the branches.

import { button, element, ofThePage } from "../shared/elements.js";
import { Marks } from "../shared/events.js";

const STEP = 0.1, LONG = 1, PAGE = 5; // s by which a key moves
const PERIOD = 250; // ms between two looks at where the pen touched
const ROWS = 4, ROW = 8; // of branches that are shown at first, the newest; px of one
const LATE = 0.5, ROOM = 5; // s beyond its time after which a flight counts as longer, and that it gets then

export class Timeline {
  constructor(studio, holder) {
    Object.assign(this, { studio, end: 1, looked: 0 });
    this.track = element("div", { class: "track", role: "slider", tabindex: 0, id: "track", "aria-label": "Time of the flight", "aria-valuemin": 0,
      title: "Drag, arrow keys or wheel look back; Enter goes on from there, Escape or End come back to now" });
    this.bands = element("div", { class: "bands", "aria-hidden": "true" });
    this.hand = element("div", { class: "hand", "aria-hidden": "true" });
    this.flown = element("div", { class: "flown", "aria-hidden": "true" });
    this.scale = element("div", { class: "scale", "aria-hidden": "true" });
    this.marks = new Marks({ set: (time) => this.look(time), get end() { return Infinity; } });
    this.tree = element("div", { class: "tree", role: "group", "aria-label": "Branches" });
    this.more = button("", { class: "more", hidden: true }, () => { this.all = !this.all; this.#draw(); });
    this.track.append(this.flown, this.bands, this.hand);
    holder.append(this.scale, this.track, this.marks.element, this.tree, this.more);
    this.#listen();
  }

  #listen() {
    const { track } = this;
    const there = (event) => {
      const box = track.getBoundingClientRect();
      this.look((this.end * (event.clientX - box.left)) / box.width);
    };
    track.addEventListener("pointerdown", (event) => {
      if (event.button !== 0) return;
      track.setPointerCapture(event.pointerId);
      track.focus();
      event.preventDefault();
      there(event);
    });
    track.addEventListener("pointermove", (event) => { if (track.hasPointerCapture(event.pointerId)) there(event); });
    track.addEventListener("wheel", (event) => {
      event.preventDefault();
      this.#step(Math.sign(event.deltaY || event.deltaX) * (event.shiftKey ? LONG : STEP));
    }, { passive: false });
    track.addEventListener("keydown", (event) => {
      if (!ofThePage(event)) return;
      const far = event.shiftKey ? LONG : STEP;
      const act = {
        ArrowLeft: () => this.#step(-far), ArrowDown: () => this.#step(-far), ArrowRight: () => this.#step(far), ArrowUp: () => this.#step(far),
        PageDown: () => this.#step(-PAGE), PageUp: () => this.#step(PAGE), Home: () => this.look(0), End: () => this.look(null), Escape: () => this.look(null),
        Enter: () => this.studio.transport.branch(),
      }[event.key];
      if (act) { event.preventDefault(); act(); }
    });
  }

  #step(seconds) {
    this.look((this.studio.looking ?? this.studio.past.end) + seconds);
  }

  /** Look at a time; null for now, as are all that have not come yet. The flight goes on meanwhile. */
  look(time) {
    const { past } = this.studio;
    this.studio.look(time === null || time >= past.end ? null : Math.max(past.start, time));
    this.show(past.end);
  }

  /** A new take-off, which lasts so long at the least, s. */
  begin(lasts, touching) {
    Object.assign(this, { lasts, touching, contact: [] });
    this.#fit(lasts);
  }

  /** What happened, and the ways that the flights went. */
  apply({ events, branches, here }) {
    this.events = events.map((event, i) => ({ number: i + 1, ...event }));
    Object.assign(this, { branches, here });
    this.#fit(this.studio.past.end);
    this.#draw();
  }

  /** The branches that have a line: the newest, or all. */
  get seen() {
    const { branches = [] } = this;
    return this.all ? branches : branches.slice(-ROWS);
  }

  /** As long as what is shown; a flight that goes on beyond its time gets some more at a time. */
  #fit(now) {
    const end = Math.max(this.lasts, now, ...this.seen.map(({ until }) => until ?? 0));
    const room = this.studio.state.over || end < this.lasts + LATE ? 0 : ROOM;
    if (this.end >= end && this.end <= end + room) return;
    this.end = end + room;
    this.#draw();
  }

  #part(time) { return `${(100 * Math.max(0, Math.min(time, this.end))) / this.end}%`; }

  #draw() {
    const { end, branches = [], here } = this;
    const step = [1, 2, 5, 10, 20, 50, 100, 200].find((seconds) => end / seconds <= 12) ?? 500;
    this.scale.replaceChildren(...Array.from({ length: Math.floor(end / step + 1e-9) + 1 }, (_, i) => element("span", { style: { left: this.#part(i * step) } }, `${i * step}${i ? "" : " s"}`)));
    this.marks.clock = { end, set: (time) => this.look(time) };
    this.marks.show(this.events ?? []);
    const newest = this.seen, rows = new Map(newest.map(({ number }, row) => [number, row]));
    const hidden = branches.length - newest.length;
    this.more.hidden = branches.length <= ROWS;
    this.more.textContent = hidden ? `Earlier branches: ${hidden}` : "The newest branches only";
    this.tree.style.height = `${ROW * Math.max(ROWS, newest.length)}px`;
    this.tree.replaceChildren(...newest.flatMap(({ number, parent, since, until, words }, row) => {
      const own = number === here, to = own ? this.studio.past.end : until;
      const name = `${own ? "Flown now" : "Go to"}: branch ${number + 1}, ${words}, ${since.toFixed(1)} to ${to.toFixed(1)} s`;
      const line = button("", { class: "branch", title: name, "aria-label": name, "aria-current": own ? "true" : undefined, style: { left: this.#part(since), width: `max(6px, ${this.#part(to - since)})`, top: `${ROW * row}px` } },
        () => { if (!own) this.studio.say("jump", { branch: number }); });
      if (own) this.current = { line, since };
      const above = rows.get(parent);
      return above === undefined || above === row ? [line]
        : [element("i", { style: { left: this.#part(since), top: `${ROW * (above + 0.5)}px`, height: `${ROW * (row - above)}px` } }), line];
    }));
  }

  /** Where the pen touched, from the frames that are known. */
  #touched() {
    const { frames } = this.studio.past, bands = [];
    for (const frame of frames) {
      const last = bands[bands.length - 1];
      if (!(frame[this.touching] > 0.5)) { if (last) last.open = false; continue; }
      if (last?.open) last.to = frame[0]; else bands.push({ from: frame[0], to: frame[0], open: true });
    }
    this.bands.replaceChildren(...bands.map(({ from, to }) => element("i", { style: { left: this.#part(from), width: `max(1px, ${this.#part(to - from)})` } })));
  }

  /** The time that is shown, of all that was flown. */
  show(now) {
    this.#fit(now);
    const { looking } = this.studio, time = looking ?? now;
    this.flown.style.width = this.#part(now);
    this.hand.style.left = this.#part(time);
    this.hand.classList.toggle("looking", looking !== null);
    if (this.current) this.current.line.style.width = `max(6px, ${this.#part(now - this.current.since)})`;
    this.track.setAttribute("aria-valuemax", now.toFixed(1));
    this.track.setAttribute("aria-valuenow", time.toFixed(1));
    this.track.setAttribute("aria-valuetext", looking === null ? `now, ${now.toFixed(1)} s` : `${time.toFixed(1)} s, ${(now - time).toFixed(1)} s ago`);
    if (performance.now() - this.looked > PERIOD) {
      this.looked = performance.now();
      this.#touched();
    }
  }
}
