// Pause, take-off, undo, speed, and going on from a time that is looked at.

import { button, element } from "../shared/elements.js";
import { seldom } from "./connection.js";

const SLOWEST = 0.1, FASTEST = 20;

/** The speed slider is logarithmic: 0 .. 1 for 0.1 .. 20. */
const toSpeed = (part) => SLOWEST * (FASTEST / SLOWEST) ** part;
const toPart = (speed) => Math.log(speed / SLOWEST) / Math.log(FASTEST / SLOWEST);
const round = (speed) => (Math.abs(speed - 1) < 0.06 ? 1 : Number(speed.toPrecision(2)));

export class Transport {
  constructor(studio, holder) {
    this.studio = studio;
    this.pause = button("❚❚", { class: "play", "aria-label": "Pause", title: "Pause or go on (Space)" }, () => this.toggle());
    this.step = button("❙▶", { "aria-label": "One tick", title: "Fly one tick of a paused flight (.)", disabled: true }, () => studio.say("step"));
    this.restart = button("⟲", { "aria-label": "Take off again", title: "Take off again (R)" }, () => studio.say("restart"));
    this.undo = button("↶", { "aria-label": "Undo" }, () => studio.say("undo"));
    this.redo = button("↷", { "aria-label": "Redo" }, () => studio.say("redo"));
    this.time = element("output", { class: "time", "aria-label": "Time since take-off" }, "0.0 s");
    const say = seldom(60, (speed) => studio.say("speed", { times: speed }));
    this.speed = element("input", { type: "range", min: 0, max: 1, step: 0.005, value: toPart(1), id: "speed", "aria-label": "Speed, 0.1 to 20 times" });
    this.speed.addEventListener("input", () => {
      const speed = round(toSpeed(Number(this.speed.value)));
      this.#tell(speed); // the slider stays where the hand is: a key's step is smaller than the rounding
      say(speed);
    });
    this.speed.addEventListener("dblclick", () => { this.#say(1); say(1); });
    this.wished = element("output", { for: "speed" }, "1×");
    this.reached = element("span", { class: "soft reached", title: "The speed really reached" }, "");
    // These two keep their place, so that nothing moves under the pointer.
    this.go = button("Go on from here", { class: "main", disabled: true, title: "Fly on from the time that is looked at (Enter)" }, () => this.branch());
    this.now = button("Back to now", { disabled: true, title: "Escape" }, () => studio.timeline.look(null));
    holder.append(
      element("div", { class: "group drives" }, this.pause, this.step, this.restart, this.undo, this.redo), this.time,
      element("div", { class: "group drives" }, element("label", { for: "speed" }, "Speed"), this.speed, this.wished), this.reached,
      element("div", { class: "group last" }, this.now, element("span", { class: "drives" }, this.go)));
  }

  toggle() {
    this.studio.say("pause", { paused: !this.studio.state.paused });
  }

  #say(speed) {
    this.speed.value = toPart(speed);
    this.#tell(speed);
  }

  #tell(speed) {
    this.wished.textContent = `${speed}×`;
    this.speed.setAttribute("aria-valuetext", `${speed} times`);
  }

  /** Go on from the time that is looked at. */
  branch() {
    const { studio } = this;
    if (studio.looking === null) return;
    if (!studio.say("rewind", { time: studio.looking, changes: studio.pending })) return;
    studio.say("pause", { paused: false });
    studio.pending = [];
    studio.look(null);
  }

  apply({ paused, over, speed, undo, redo }) {
    this.pause.textContent = paused ? "▶" : "❚❚";
    this.pause.setAttribute("aria-label", paused ? "Go on" : "Pause");
    this.pause.disabled = over;
    this.step.disabled = over || !paused;
    for (const [one, words, key] of [[this.undo, undo, "Ctrl-Z"], [this.redo, redo, "Ctrl-Shift-Z"]]) {
      one.disabled = words === null;
      one.title = words === null ? "Nothing to bring back" : `${one.getAttribute("aria-label")}: ${words} (${key})`;
    }
    if (document.activeElement !== this.speed) this.#say(round(speed));
  }

  /** How many ticks were late, of all that were flown. */
  pace({ late, flown }) {
    this.reached.title = `The speed really reached; ${late} of ${flown} ticks were late by more than 5 ms`;
  }

  frame(time, reached, flying) {
    this.time.textContent = `${time.toFixed(this.studio.state.paused ? 3 : 1)} s`; // a tick is some milliseconds
    this.reached.textContent = flying ? `reached ${reached.toFixed(reached < 9.95 ? 2 : 1)}×` : "";
    this.go.disabled = this.now.disabled = this.studio.looking === null;
  }
}
