// Charts of the flight: those of the task, and any signal of the log by its name.

import { uPlot } from "vendor";
import { MARKERS, curvesOf, hueOf } from "../shared/curves.js";
import { button, element } from "../shared/elements.js";
import { eventsOf, stripes, timeLine } from "../shared/events.js";

const SPAN = 30; // s that are seen
const HEIGHT = 104;
const BESIDE = [undefined, [7, 3], [2, 3], [9, 3, 2, 3]];
const LEAST_RANGE = { N: 1, m: 0.02, mm: 4, rad: 0.05, deg: 1 };
const MOST = 30; // matches that are listed
const KEPT = "skylimb-charts"; // what was chosen, over a reload

const plain = (unit) => unit.replace(/\^2/g, "²").replace(/\^3/g, "³");
const shown = (value, unit) => (value == null ? "–" : `${Number(value.toPrecision(3))}${unit && ` ${unit}`}`);

/** Let the browser save what an address holds. */
function save(href, name) {
  element("a", { href, download: name }).click();
}

export class Charts {
  constructor(holder, past) {
    Object.assign(this, { holder, past, charts: [], zoomed: null, whole: false, looking: null });
    this.chosen = JSON.parse(sessionStorage.getItem(KEPT) ?? "[]"); // charts that were added: {signals, pinned}, or {title, pinned, gone} of others
    this.search = element("input", { type: "search", placeholder: "Add a chart: force, attitude, thrusts …", "aria-label": "Add a signal's chart", autocomplete: "off", spellcheck: "false" });
    this.into = element("select", { "aria-label": "Into which chart" });
    this.found = element("div", { class: "found", hidden: true });
    this.follow = button("Follow the flight", { hidden: true, title: "Double-click in a chart does it, too" }, () => this.zoom(null));
    this.all = button("Whole flight", { title: "From take-off to now" }, () => this.zoom(null, true));
    this.grid = element("div", { class: "grid" });
    this.search.addEventListener("input", () => this.#list());
    this.search.addEventListener("keydown", ({ key }) => { if (key === "Escape") { this.search.value = ""; this.#list(); } });
    holder.append(element("div", { class: "choose" }, this.search, this.into, this.follow, this.all, this.found), this.grid);
    new ResizeObserver(() => this.#resize()).observe(holder);
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => this.flights && this.begin(this.flights, this.layout, this.period));
  }

  /** The flights of a scene; a number is of the moment at which the last tick began, as in the log. */
  begin(flights, layout, period) {
    Object.assign(this, { flights, layout, period });
    for (const { plot } of this.charts) plot.destroy();
    this.grid.replaceChildren();
    const titles = [...new Set(flights.flatMap(({ panels }) => panels.map((panel) => panel.title)))];
    const own = this.chosen.filter(({ signals }) => signals);
    const all = [
      ...titles.map((title) => ({ title, ...this.chosen.find((one) => one.title === title) })).filter(({ gone }) => !gone),
      ...own.map((one) => ({ ...one, title: one.signals.map((name) => name.replaceAll("_", " ")).join(", "), own: one })),
    ].sort((a, b) => Boolean(b.pinned) - Boolean(a.pinned));
    this.charts = all.map((chart) => {
      const curves = flights.flatMap((flight, i) => (chart.own ? this.#signals(flight, chart.own.signals, i) : this.#curves(flight, chart.title, i)));
      return curves.length ? this.#chart(chart, curves) : null;
    }).filter(Boolean);
    this.into.replaceChildren(element("option", { value: "" }, "a new chart"), ...own.map(({ signals }, k) => element("option", { value: k }, `with ${signals.join(", ")}`)));
    this.into.hidden = !own.length;
    this.#resize();
    this.update();
  }

  /** What happens to the flights, to be marked in every chart. */
  apply({ events }) {
    this.events = eventsOf([{ events }]);
  }

  /** Beside another flight the colour says whose curve it is, and its dashes which. */
  #curves(flight, title, i) {
    const alone = this.flights.length === 1, { panels, name } = flight, column = this.layout.flights[i].curves[0];
    const panel = panels.find((one) => one.title === title);
    const labels = new Map(panel?.curves.map((curve) => [curve.column, curve]));
    const curves = curvesOf(flight, title, alone, i === 0).filter((curve) => alone || labels.get(curve.column).role !== "command");
    return curves.map((curve, k) => {
      const { label, role } = labels.get(curve.column);
      const beside = alone || role === "reference" || role === "limit" ? {} : { label: `${name} ${label}`, dash: BESIDE[k % BESIDE.length] };
      return { ...curve, ...beside, role, names: panel.names, at: column + curve.column };
    });
  }

  /** Curves of signals by their names in the log; a second unit gets an axis of its own. */
  #signals(flight, names, i) {
    const alone = this.flights.length === 1, first = this.layout.flights[i].signals[0];
    let hue = 0;
    return names.flatMap((name) => {
      const signal = flight.signals.find((one) => one.name === name);
      if (!signal) return [];
      return signal.labels.map((label, k) => ({
        label: `${alone ? "" : `${flight.name} `}${names.length > 1 || !label ? name : ""} ${label}`.trim(),
        unit: plain(signal.unit), stroke: alone ? hueOf(hue++) : flight.colour, dash: alone ? undefined : BESIDE[k % BESIDE.length],
        width: 1.6, at: first + signal.column + k,
      }));
    });
  }

  #remember() {
    sessionStorage.setItem(KEPT, JSON.stringify(this.chosen));
    this.begin(this.flights, this.layout, this.period);
  }

  /** Change what was chosen of a chart. */
  #choose(chart, change) {
    let one = chart.own ?? this.chosen.find(({ title }) => title === chart.title);
    if (!one) this.chosen.push(one = { title: chart.title });
    Object.assign(one, change);
    this.chosen = this.chosen.filter(({ signals, gone }) => !(signals && gone));
    this.#remember();
  }

  /** The signals that fit what was typed. */
  #list() {
    const words = this.search.value.toLowerCase().split(/\s+/).filter(Boolean);
    const known = this.flights?.[0].signals ?? [];
    const fits = ({ name, meaning }) => words.every((word) => `${name} ${meaning}`.toLowerCase().replaceAll("_", " ").includes(word.replaceAll("_", " ")));
    const hidden = this.chosen.filter(({ gone }) => gone);
    this.found.hidden = !words.length;
    this.found.replaceChildren(
      ...hidden.filter(({ title }) => words.every((word) => title.toLowerCase().includes(word))).map((one) => button(one.title, {}, () => { this.search.value = ""; this.found.hidden = true; one.gone = false; this.#remember(); })),
      ...known.filter(fits).slice(0, MOST).map(({ name, meaning, unit }) => button(`${name} ${unit && `(${plain(unit)})`}`, { title: meaning }, () => this.#add(name))));
  }

  #add(name) {
    const into = this.into.value === "" ? null : this.chosen.filter(({ signals }) => signals)[Number(this.into.value)];
    this.search.value = "";
    this.found.hidden = true;
    if (into) into.signals = [...new Set([...into.signals, name])]; else this.chosen.push({ signals: [name] });
    this.#remember();
    this.grid.lastChild?.scrollIntoView({ block: "nearest" });
  }

  #chart(chart, curves) {
    const style = getComputedStyle(this.holder);
    const textColour = style.getPropertyValue("--soft").trim(), line = style.getPropertyValue("--line").trim();
    const units = [...new Set(curves.map(({ unit }) => unit))], names = curves[0].names ?? [];
    const title = units.length === 1 && units[0] ? `${chart.title} (${units[0]})` : chart.title;
    const tools = element("div", { class: "tools" },
      button(chart.pinned ? "★" : "☆", { "aria-label": `${chart.title}: keep in front`, "aria-pressed": Boolean(chart.pinned), title: "Keep in front" }, () => this.#choose(chart, { pinned: !chart.pinned })),
      button("PNG", { "aria-label": `${chart.title} as a picture`, title: "The time that is shown" }, () => this.#picture(made)),
      button("CSV", { "aria-label": `${chart.title} as a table`, title: "The time that is shown, as often as the page was told of it; Keep writes every tick" }, () => this.#table(made)),
      button("×", { "aria-label": `${chart.title}: close`, title: "Close; the search brings it back" }, () => this.#choose(chart, { gone: true })));
    const holder = element("figure", { class: "panel", "aria-label": title }, tools);
    this.grid.append(holder);
    const axis = { stroke: textColour, grid: { stroke: line, width: 1 }, ticks: { stroke: line, width: 1 }, font: "11px system-ui" };
    const scaleOf = (unit) => (units.indexOf(unit) ? `y${units.indexOf(unit)}` : "y");
    const scales = Object.fromEntries(units.map((unit) => [scaleOf(unit), { range: (_, low, high) => rangeOf(low, high, unit, names) }]));
    const plot = new uPlot({
      title,
      width: holder.clientWidth || 300,
      height: HEIGHT,
      // The others show the cursor, but none of them is dragged: each would zoom into what the one before has left.
      cursor: { sync: { key: "studio", setSeries: false, filters: { pub: (type) => type === "mousemove" || type === "mouseleave" } }, drag: { x: true, y: false, setScale: false }, points: { size: 5 } },
      legend: { live: true, markers: MARKERS },
      scales: { x: { time: false }, ...scales },
      axes: [{ ...axis, space: 60, size: 26 },
        ...units.map((unit, k) => ({ ...axis, scale: scaleOf(unit), side: k ? 1 : 3, size: names.length ? 78 : 50, space: 15, grid: k ? { show: false } : axis.grid, label: units.length > 1 ? unit : undefined, labelSize: 14, labelFont: "11px system-ui",
          ...(names.length ? { splits: () => names.map((_, i) => i), values: (_, splits) => splits.map((value) => names[value].replaceAll("_", " ")) } : {}) }))],
      series: [{ label: "t", value: (_, t) => (t == null ? "–" : `${t.toFixed(2)} s`) }, ...curves.map(({ label, stroke, dash, width, unit }) => ({
        label, stroke, dash, width, scale: scaleOf(unit), points: { show: false }, spanGaps: false,
        value: (_, value) => (names.length && value != null ? names[Math.round(value)] ?? "–" : shown(value, unit)),
      }))],
      hooks: {
        ready: [(u) => u.over.addEventListener("dblclick", () => this.zoom(null))],
        setSelect: [(u) => this.#select(u)],
        drawClear: [(u) => { stripes(u, this.events ?? [], style); this.#saturated(u, curves); }],
        draw: [(u) => { if (this.looking !== null) timeLine(u, this.looking, 2); }],
      },
    }, [[], ...curves.map(() => [])], holder);
    // A legend that grows and shrinks with its numbers would move what is below it under the pointer.
    holder.style.setProperty("--value", `${Math.max(...units.map((unit) => 8 + unit.length), ...names.map((name) => name.length))}ch`);
    const made = { plot, curves, holder, title };
    return made;
  }

  #select(plot) {
    const { left, width } = plot.select;
    if (width < 4) return;
    plot.setSelect({ left: 0, width: 0, top: 0, height: 0 }, false);
    this.zoom([plot.posToVal(left, "x"), plot.posToVal(left + width, "x")]);
  }

  /** Show a span of time in all charts, or the whole flight; null to follow the flight. */
  zoom(span, whole = false) {
    Object.assign(this, { zoomed: span, whole });
    this.follow.hidden = !span && !whole;
    this.all.hidden = whole;
    this.update();
  }

  /** Draw what is known now. */
  update() {
    const { frames, start } = this.past;
    if (!frames.length) return;
    // What is looked at is in the middle, where it is too old to be seen beside what flies now.
    const latest = Math.min(this.past.end, this.looking === null ? Infinity : Math.max(this.looking + SPAN / 2, start + SPAN));
    const [begin, end] = this.zoomed ?? (this.whole ? [start < 1 ? 0 : start, this.past.end] : [Math.max(0, Math.min(start, latest - 5), latest - SPAN), latest]);
    const rows = frames.slice(this.past.index(begin), this.past.index(end) + 1), times = rows.map((frame) => Number((frame[0] - this.period).toFixed(4)));
    for (const { plot, curves, holder } of this.charts) {
      if (!this.#seen(holder)) continue;
      const data = curves.map(({ at }) => rows.map((frame) => (Number.isFinite(frame[at]) ? frame[at] : null)));
      plot.batch(() => {
        plot.setData([times, ...data], false);
        plot.setScale("x", { min: begin, max: end });
      });
      if (!(plot.cursor.left >= 0)) plot.setLegend({ idx: this.looking === null ? times.length - 1 : Math.max(0, times.findLastIndex((time) => time <= this.looking)) }, false);
    }
  }

  #seen(holder) {
    const box = holder.getBoundingClientRect();
    return box.bottom > 0 && box.top < innerHeight;
  }

  /** Where a curve is at one of the limits of its chart. */
  #saturated(plot, curves) {
    const limits = curves.flatMap(({ role }, k) => (role === "limit" ? [plot.data[k + 1]?.[0]] : [])).filter((value) => value != null);
    if (limits.length < 2) return;
    const [low, high] = [Math.min(...limits), Math.max(...limits)], near = 0.005 * (high - low);
    const { ctx, bbox: { top, height } } = plot, times = plot.data[0];
    ctx.save();
    ctx.fillStyle = "rgba(214, 39, 40, .3)";
    for (let i = 1; i < times.length; i++) {
      if (!curves.some(({ role }, k) => role !== "limit" && plot.data[k + 1][i] != null && (plot.data[k + 1][i] >= high - near || plot.data[k + 1][i] <= low + near))) continue;
      const [from, to] = [times[i - 1], times[i]].map((time) => plot.valToPos(time, "x", true));
      ctx.fillRect(from, top, Math.max(1, to - from), height);
    }
    ctx.restore();
  }

  /** The chart with its title and legend, as a picture. */
  #picture({ plot, curves, title }) {
    this.update(); // it may just have come into view
    const from = plot.ctx.canvas, ratio = devicePixelRatio, line = 18 * ratio, sample = 28 * ratio;
    const font = `${11 * ratio}px system-ui`, canvas = element("canvas"), ctx = canvas.getContext("2d"), style = getComputedStyle(this.holder);
    ctx.font = font;
    const left = 8 * ratio;
    let at = left, row = 1;
    const places = curves.map(({ label }) => { // a legend that is too long for a line takes another
      const width = sample + ctx.measureText(`${label}   `).width;
      if (at > left && at + width > from.width) { at = left; row++; }
      at += width;
      return [at - width, row];
    });
    Object.assign(canvas, { width: from.width, height: from.height + (1 + row) * line });
    ctx.fillStyle = style.getPropertyValue("--paper");
    ctx.fillRect(0, 0, canvas.width, canvas.height);
    ctx.font = `600 ${13 * ratio}px system-ui`;
    ctx.fillStyle = style.getPropertyValue("--ink");
    ctx.fillText(title, left, 14 * ratio);
    ctx.drawImage(from, 0, line);
    ctx.font = font;
    for (const [i, { label, stroke, dash = [] }] of curves.entries()) {
      const [x, below] = places[i], y = from.height + (1 + below) * line - 5 * ratio;
      Object.assign(ctx, { fillStyle: stroke, strokeStyle: stroke, lineWidth: 2 * ratio });
      ctx.setLineDash(dash.map((length) => length * ratio));
      ctx.beginPath();
      ctx.moveTo(x, y - 4 * ratio);
      ctx.lineTo(x + sample - 4 * ratio, y - 4 * ratio);
      ctx.stroke();
      ctx.fillText(label, x + sample, y);
    }
    save(canvas.toDataURL("image/png"), `${title}.png`);
  }

  /** What the chart shows, as a table with names and units. */
  #table({ plot, curves, title }) {
    this.update();
    const quoted = (text) => `"${text.replaceAll('"', '""')}"`;
    const head = ["t (s)", ...curves.map(({ label, unit }) => `${label}${unit && ` (${unit})`}`)].map(quoted).join();
    const rows = plot.data[0].map((_, i) => plot.data.map((column) => column[i] ?? "").join());
    const href = URL.createObjectURL(new Blob([`${[head, ...rows].join("\n")}\n`], { type: "text/csv" }));
    save(href, `${title}.csv`);
    setTimeout(() => URL.revokeObjectURL(href), 10000);
  }

  #resize() {
    for (const { plot, holder } of this.charts) {
      const width = holder.clientWidth;
      if (width && Math.abs(width - plot.width) > 1) plot.setSize({ width, height: HEIGHT });
    }
  }
}

/** The range of an axis: as large as the unit needs it, with some room. */
function rangeOf(low, high, unit, names) {
  if (names.length) return [-0.3, names.length - 0.7];
  const least = LEAST_RANGE[unit] ?? 0.02;
  if (low === null || !Number.isFinite(low)) return [0, least];
  const gap = Math.max(0, least - (high - low)) / 2 + 0.08 * (high - low);
  return [low - gap, high + gap];
}
