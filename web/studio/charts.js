// Strip charts of the last 30 s.

import { uPlot } from "vendor";
import { curvesOf } from "../shared/curves.js";
import { element } from "../shared/elements.js";

const SPAN = 30; // s that are seen

const HEIGHT = 150;
const BESIDE = [undefined, [7, 3], [2, 3], [9, 3, 2, 3]];
const LEAST_RANGE = { N: 1, m: 0.02, rad: 0.05 };

export class Charts {
  constructor(holder, past) {
    Object.assign(this, { holder, past, charts: [] });
    this.looking = null; // time of the past that is looked at
    new ResizeObserver(() => this.#resize()).observe(holder);
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => this.flights && this.begin(this.flights, this.layout));
  }

  begin(flights, layout) {
    Object.assign(this, { flights, layout });
    for (const { plot } of this.charts) plot.destroy();
    this.holder.replaceChildren();
    const alone = flights.length === 1;
    const titles = [...new Set(flights.flatMap(({ panels }) => panels.map((panel) => panel.title)))];
    this.charts = titles.map((title) => {
      const curves = flights.flatMap((flight, i) => this.#curves(flight, title, alone, i));
      return curves.length ? this.#chart(title, curves) : null;
    }).filter(Boolean);
    this.#resize();
  }

  /** Beside another flight the colour says whose curve it is, and its dashes which. */
  #curves(flight, title, alone, i) {
    const { panels, name } = flight, column = this.layout.flights[i].curves[0];
    const labels = new Map(panels.find((panel) => panel.title === title)?.curves.map((curve) => [curve.column, curve]));
    const curves = curvesOf(flight, title, alone, i === 0).filter((curve) => alone || labels.get(curve.column).role !== "command");
    return curves.map((curve, k) => {
      const { label, role } = labels.get(curve.column);
      const beside = alone || role === "reference" || role === "limit" ? {} : { label: `${name} ${label}`, dash: BESIDE[k % BESIDE.length] };
      return { ...curve, ...beside, at: column + curve.column };
    });
  }

  #chart(title, curves) {
    const style = getComputedStyle(this.holder);
    const textColour = style.getPropertyValue("--soft").trim(), line = style.getPropertyValue("--line").trim();
    const unit = curves[0].unit, least = LEAST_RANGE[unit] ?? 0.02;
    const holder = element("figure", { class: "panel", "aria-label": `${title}${unit && `, ${unit}`}, last ${SPAN} s` });
    this.holder.append(holder);
    const axis = { stroke: textColour, grid: { stroke: line, width: 1 }, ticks: { stroke: line, width: 1 }, font: "11px system-ui" };
    const plot = new uPlot({
      title: unit ? `${title} (${unit})` : title,
      width: holder.clientWidth || 300,
      height: HEIGHT,
      cursor: { sync: { key: "studio", setSeries: false }, drag: { x: false, y: false }, points: { size: 5 } },
      legend: { live: false },
      scales: {
        x: { time: false },
        y: { range: (_, low, high) => {
          if (low === null || !Number.isFinite(low)) return [0, least];
          const gap = Math.max(0, least - (high - low)) / 2 + 0.08 * (high - low);
          return [low - gap, high + gap];
        } },
      },
      axes: [{ ...axis, space: 60, size: 28 }, { ...axis, size: 50 }],
      series: [{ label: "t" }, ...curves.map(({ label, stroke, dash, width }) => ({
        label, stroke, dash, width, points: { show: false }, spanGaps: false,
      }))],
      hooks: { draw: [(u) => this.#mark(u)] },
    }, [[], ...curves.map(() => [])], holder);
    return { plot, curves, holder };
  }

  /** Draw what is known now. */
  update() {
    const { frames, start } = this.past;
    if (!frames.length) return;
    // What is looked at is in the middle, where it is too old to be seen beside what flies now.
    const end = Math.min(this.past.end, this.looking === null ? Infinity : Math.max(this.looking + SPAN / 2, start + SPAN));
    const shown = frames.slice(this.past.index(end - SPAN), this.past.index(end) + 1), times = shown.map((frame) => frame[0]);
    const range = { min: Math.max(0, Math.min(start, end - 5), end - SPAN), max: end };
    for (const { plot, curves, holder } of this.charts) {
      if (!this.#seen(holder)) continue;
      const data = curves.map(({ at }) => shown.map((frame) => (Number.isNaN(frame[at]) ? null : frame[at])));
      plot.batch(() => {
        plot.setData([times, ...data], false);
        plot.setScale("x", range);
      });
    }
  }

  #seen(holder) {
    const box = holder.getBoundingClientRect();
    return box.bottom > 0 && box.top < innerHeight;
  }

  #mark(plot) {
    if (this.looking === null) return;
    const x = Math.round(plot.valToPos(this.looking, "x", true)), { top, height } = plot.bbox;
    plot.ctx.save();
    plot.ctx.strokeStyle = "#d62728";
    plot.ctx.lineWidth = 2 * devicePixelRatio;
    plot.ctx.beginPath();
    plot.ctx.moveTo(x, top);
    plot.ctx.lineTo(x, top + height);
    plot.ctx.stroke();
    plot.ctx.restore();
  }

  #resize() {
    for (const { plot, holder } of this.charts) {
      const width = holder.clientWidth;
      if (width && Math.abs(width - plot.width) > 1) plot.setSize({ width, height: HEIGHT });
    }
  }
}
