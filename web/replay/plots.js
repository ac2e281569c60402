// Curves over time: one cursor for all plots, zoomed together.

import { uPlot } from "vendor";
import { MARKERS, curvesOf } from "../shared/curves.js";
import { columns, lastNotAbove } from "../shared/decode.js";
import { eventsOf, stripes, timeLine } from "../shared/events.js";

export class Plots {
  static async of(holder, flights, clock) {
    const signals = await Promise.all(flights.map((flight) => columns(flight.signals)));
    return new Plots(holder, flights, signals, clock);
  }

  constructor(holder, flights, signals, clock) {
    Object.assign(this, { holder, flights, signals, clock, plots: [], range: [0, clock.end] });
    new ResizeObserver(() => this.resize()).observe(holder);
  }

  /** Draw the panels of one flight with all its curves, or of all flights with what compares them. */
  show(chosen) {
    for (const plot of this.plots) plot.destroy();
    this.holder.replaceChildren();
    this.plots = [];
    const alone = chosen !== null || this.flights.length === 1;
    const shown = chosen !== null ? [chosen] : this.flights.map((_, i) => i);
    this.events = eventsOf(shown.map((i) => this.flights[i]));
    const titles = [...new Set(shown.flatMap((i) => this.flights[i].panels.map((panel) => panel.title)))];
    for (const title of titles) {
      const curves = shown.flatMap((i, k) => this.#curves(i, title, alone, k === 0));
      if (curves.length) this.plots.push(this.#plot(title, curves));
    }
    this.resize(); // widths are known once all stand there
    this.zoom(...this.range);
    this.cursor();
  }

  #curves(flight, title, alone, first) {
    return curvesOf(this.flights[flight], title, alone, first).map((curve) => ({
      ...curve,
      times: this.signals[flight][0],
      values: this.signals[flight][curve.column],
    }));
  }

  #plot(title, curves) {
    const style = getComputedStyle(this.holder);
    const textColour = style.getPropertyValue("--soft").trim() || "#666", line = style.getPropertyValue("--line").trim() || "#ddd";
    const longest = curves.reduce((a, b) => (b.times.length > a.times.length ? b : a)).times;
    const filled = (values) => {
      if (values.length === longest.length) return values;
      const all = new Float32Array(longest.length).fill(NaN);
      all.set(values);
      return all;
    };
    const data = [longest, ...curves.map((curve) => Array.from(filled(curve.values), (v) => (Number.isNaN(v) ? null : v)))];
    const element = document.createElement("figure");
    element.className = "panel";
    element.setAttribute("aria-label", `${title}, ${curves[0].unit}`);
    this.holder.append(element);
    const axis = { stroke: textColour, grid: { stroke: line, width: 1 }, ticks: { stroke: line, width: 1 }, font: "11px system-ui" };
    const plot = new uPlot({
      title: `${title} (${curves[0].unit})`,
      width: element.clientWidth || 400,
      height: 190,
      cursor: { sync: { key: "skylimb", setSeries: false }, drag: { x: true, y: false }, points: { size: 5 } },
      legend: { live: true, markers: MARKERS },
      scales: { x: { time: false } },
      axes: [{ ...axis, space: 60 }, { ...axis, size: 52 }],
      series: [
        { label: "t", value: (_, v) => (v == null ? "–" : `${v.toFixed(2)} s`) },
        ...curves.map(({ label, stroke, dash, width }) => ({
          label, stroke, dash, width, points: { show: false }, spanGaps: false,
          value: (_, v) => (v == null ? "–" : v.toPrecision(3)),
        })),
      ],
      hooks: {
        ready: [(u) => { this.#listen(u); this.#read(u); }],
        setSelect: [(u) => this.#zoom(u)],
        drawClear: [(u) => stripes(u, this.events, style)],
        draw: [(u) => timeLine(u, this.clock.time, 1)],
      },
    }, data, element);
    return plot;
  }

  #listen(plot) {
    plot.over.addEventListener("click", () => {
      if (plot.cursor.left >= 0) this.clock.set(plot.posToVal(plot.cursor.left, "x"));
    });
    plot.over.addEventListener("dblclick", () => this.zoom(0, this.clock.end));
  }

  #zoom(plot) {
    if (plot.select.width < 4) return;
    const low = plot.posToVal(plot.select.left, "x"), high = plot.posToVal(plot.select.left + plot.select.width, "x");
    plot.setSelect({ left: 0, width: 0, top: 0, height: 0 }, false);
    this.zoom(low, high);
  }

  zoom(low, high) {
    this.range = [low, high];
    for (const plot of this.plots) plot.setScale("x", { min: low, max: high });
  }

  cursor() {
    for (const plot of this.plots) {
      plot.redraw(false, false);
      this.#read(plot);
    }
  }

  /** The values at the time that is shown, unless a pointer reads others. */
  #read(plot) {
    if (!(plot.cursor.left >= 0)) plot.setLegend({ idx: Math.max(0, lastNotAbove(plot.data[0], this.clock.time)) }, false);
  }

  resize() {
    for (const plot of this.plots) {
      const width = plot.root.parentElement.clientWidth;
      if (width && Math.abs(width - plot.width) > 1) plot.setSize({ width, height: 190 });
    }
  }
}
