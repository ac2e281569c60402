// What happened to the flights: marks under the time line, and stripes in the plots.

import { button, element } from "./elements.js";

const DASHES = { push: [4, 2], gain: [5, 2, 1, 2], surface: [1, 2] };

/** The events of some flights in the order of time, those that they share once. */
export function eventsOf(flights) {
  const known = new Map();
  for (const event of flights.flatMap(({ events }) => events)) {
    const { kind, time, duration, words } = event;
    known.set(JSON.stringify([kind, time, duration, words]), event);
  }
  return [...known.values()].sort((a, b) => a.time - b.time);
}

/** What is said of an event. */
export function wordsOf({ number, kind, time, duration, words }) {
  const lasts = duration > 0 ? `, ${Number(duration.toPrecision(3))} s` : "";
  return `${number}: ${kind} at ${time.toFixed(2)} s${lasts}: ${words}`;
}

export class Marks {
  constructor(clock) {
    this.clock = clock;
    this.element = element("div", { class: "marks", role: "group", "aria-label": "What happened" });
  }

  /** A mark for each event; a click goes to its time. */
  show(events) {
    const { end } = this.clock, part = (time) => `${(100 * Math.min(time, end)) / end}%`;
    this.element.replaceChildren(...events.map((event) => {
      const { kind, time, duration } = event, text = wordsOf(event);
      const width = part(Math.min(duration, end - time));
      return button("", { class: "mark", title: text, "aria-label": text, dataset: { kind }, style: { left: part(time), width } },
        () => this.clock.set(time));
    }));
  }
}

/** A pale stripe in a plot while each event lasts, and a dashed line where it begins. */
export function stripes(plot, events, style) {
  const { ctx, bbox: { left, top, width, height } } = plot;
  ctx.save();
  ctx.beginPath();
  ctx.rect(left, top, width, height);
  ctx.clip();
  ctx.lineWidth = devicePixelRatio;
  for (const { kind, time, duration } of events) {
    const colour = style.getPropertyValue(`--${kind}`).trim() || style.getPropertyValue("--soft").trim() || "#666";
    const [from, to] = [time, time + duration].map((t) => Math.round(plot.valToPos(t, "x", true)));
    ctx.fillStyle = ctx.strokeStyle = colour;
    ctx.globalAlpha = 0.13;
    ctx.fillRect(from, top, to - from, height);
    ctx.globalAlpha = 1;
    ctx.setLineDash((DASHES[kind] ?? [7, 2]).map((length) => length * devicePixelRatio));
    ctx.beginPath();
    ctx.moveTo(from, top);
    ctx.lineTo(from, top + height);
    ctx.stroke();
  }
  ctx.restore();
}

/** A red line at a time that is shown, over a plot's curves. */
export function timeLine(plot, time, width) {
  const { ctx, bbox } = plot, x = Math.round(plot.valToPos(time, "x", true));
  if (x < bbox.left || x > bbox.left + bbox.width) return;
  ctx.save();
  ctx.setLineDash([]); // the last curve may have left its own
  ctx.strokeStyle = "#d62728";
  ctx.lineWidth = width * devicePixelRatio;
  ctx.beginPath();
  ctx.moveTo(x, bbox.top);
  ctx.lineTo(x, bbox.top + bbox.height);
  ctx.stroke();
  ctx.restore();
}
