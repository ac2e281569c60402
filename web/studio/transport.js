// Pause, restart, speed, and a look back from which one can go on.

import { button, element } from "../shared/elements.js";
import { seldom } from "./connection.js";
import { SPAN } from "./past.js";

const SLOWEST = 0.1, FASTEST = 20;

/** The speed slider is logarithmic: 0 .. 1 for 0.1 .. 20. */
const toSpeed = (part) => SLOWEST * (FASTEST / SLOWEST) ** part;
const toPart = (speed) => Math.log(speed / SLOWEST) / Math.log(FASTEST / SLOWEST);
const round = (speed) => (Math.abs(speed - 1) < 0.06 ? 1 : Number(speed.toPrecision(2)));

export class Transport {
  constructor(studio, holder) {
    this.studio = studio;
    this.pause = button("❚❚", { class: "play", "aria-label": "Pause", title: "Pause or go on (Space)" }, () => this.toggle());
    this.restart = button("⟲", { "aria-label": "Take off again", title: "Take off again (R)" }, () => studio.say("restart"));
    this.time = element("output", { class: "time", "aria-label": "Time since take-off" }, "0.0 s");
    const say = seldom(60, (speed) => studio.say("speed", { times: speed }));
    this.speed = element("input", { type: "range", min: 0, max: 1, step: 0.005, value: toPart(1), id: "speed", "aria-label": "Speed, 0.1 to 20 times" });
    this.speed.addEventListener("input", () => {
      const speed = round(toSpeed(Number(this.speed.value)));
      this.#say(speed);
      say(speed);
    });
    this.speed.addEventListener("dblclick", () => { this.#say(1); say(1); });
    this.wished = element("output", { for: "speed" }, "1×");
    this.reached = element("span", { class: "soft reached", title: "The speed really reached" }, "");
    this.back = element("input", { type: "range", min: -SPAN, max: 0, step: 0.05, value: 0, id: "rewind", "aria-label": "Look back, seconds" });
    this.back.addEventListener("input", () => this.look(Number(this.back.value)));
    this.ago = element("output", { for: "rewind" }, "now");
    this.branch = button("Go on from here", { class: "main", hidden: true, title: "Fly on from the time that is looked at" }, () => this.#branch());
    this.now = button("Back to now", { hidden: true }, () => this.look(0));
    holder.append(
      element("div", { class: "group" }, this.pause, this.restart, this.time),
      element("div", { class: "group" }, element("label", { for: "speed" }, "Speed"), this.speed, this.wished, this.reached),
      element("div", { class: "group wide" }, element("label", { for: "rewind" }, "Look back"), this.back, this.ago, this.branch, this.now));
  }

  toggle() {
    if (this.studio.looking !== null) this.look(0);
    this.studio.say("pause", { paused: !this.studio.state.paused });
  }

  #say(speed) {
    this.speed.value = toPart(speed);
    this.wished.textContent = `${speed}×`;
    this.speed.setAttribute("aria-valuetext", `${speed} times`);
  }

  /** Look at a time in the past, s before now (0: now); the flight waits meanwhile. */
  look(seconds) {
    const { studio } = this, { past } = studio;
    const before = Math.max(seconds, past.start - past.end);
    if (before < 0 && studio.looking === null) {
      this.wasPaused = studio.state.paused;
      if (!this.wasPaused) studio.say("pause", { paused: true });
    }
    if (before >= 0 && studio.looking !== null && !this.wasPaused) studio.say("pause", { paused: false });
    studio.look(before < 0 ? past.end + before : null);
    this.back.value = before;
    this.ago.textContent = before < 0 ? `−${(-before).toFixed(1)} s` : "now";
    this.branch.hidden = this.now.hidden = before >= 0;
  }

  #branch() {
    const { studio } = this;
    studio.say("rewind", { seconds: Math.max(0, Math.min(SPAN, studio.past.end - studio.looking)) });
    if (!this.wasPaused) studio.say("pause", { paused: false });
    this.wasPaused = true; // it is on its way already
    this.look(0);
  }

  show({ paused, over, speed }) {
    this.pause.textContent = paused ? "▶" : "❚❚";
    this.pause.setAttribute("aria-label", paused ? "Go on" : "Pause");
    this.pause.disabled = over;
    if (document.activeElement !== this.speed) this.#say(round(speed));
  }

  /** How many ticks were late, of all that were flown. */
  pace({ late, flown }) {
    this.reached.title = `The speed really reached; ${late} of ${flown} ticks were late by more than 5 ms`;
  }

  frame(time, reached, flying) {
    this.time.textContent = `${time.toFixed(1)} s`;
    this.reached.textContent = flying ? `reached ${reached.toFixed(reached < 9.95 ? 2 : 1)}×` : "";
  }
}
