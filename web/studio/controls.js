// Every gain and key as a control, with search. What a control shows is what flies: the server's state.

import { button, element } from "../shared/elements.js";
import { seldom } from "./connection.js";

const OWN = 400; // ms after a hand's own change for which the state may be older than it
const shown = (value) => (typeof value === "number" ? Number(value.toPrecision(6)) : value);
const same = (one, other) => JSON.stringify(one) === JSON.stringify(other);
const inWords = (value) => (Array.isArray(value) ? `[${value.map(inWords).join(", ")}]` : value === null ? "none" : value === "" ? "empty" : String(shown(value)));

/** What a key is called in its group: its last words, and those of a table inside of the group. */
const nameOf = ({ key }) => key.split(".").slice(key.startsWith("controller.") ? 2 : 1).join(": ").replaceAll("_", " ") || key.replaceAll("_", " ");
const plainUnit = (unit) => unit.replace(/\^-1/g, "⁻¹").replace(/\^2/g, "²").replace(/\^3/g, "³");

/** What a key means, without formulas' names and with letters below the line. */
function plain(text) {
  const parts = plainUnit(text.replace(/ ?(of |by )?eq:[a-z ]+/i, "")).split(/(\b[A-Za-z]_[A-Za-z]+)/);
  return parts.map((part) => (/^[A-Za-z]_/.test(part) ? element("span", {}, part[0], element("sub", {}, part.slice(2))) : part));
}

export class Controls {
  /** `studio.say` is called with what a hand changes. */
  constructor(studio, holder) {
    Object.assign(this, { studio, rows: [], open: new Set(["Motion in space"]), flight: null });
    this.search = element("input", { type: "search", placeholder: "Search: stiffness, friction, latency …", "aria-label": "Search gains and keys", autocomplete: "off", spellcheck: "false" });
    this.of = element("select", { "aria-label": "Whose gains" });
    this.of.addEventListener("change", () => { this.flight = this.of.value === "" ? null : Number(this.of.value); this.apply(this.state); });
    this.count = element("span", { class: "soft count", role: "status" });
    this.list = element("div", { class: "keys" });
    this.changed = element("section", { class: "changed", "aria-label": "What was changed", hidden: true });
    this.search.addEventListener("input", () => this.filter());
    holder.append(element("div", { class: "search" }, this.search, this.of, this.count), this.changed, this.list);
  }

  /** The controls of a new take-off, with their values then and in the preset. */
  show(controls, names) {
    const place = this.list.scrollTop;
    this.flight = null;
    this.names = names;
    this.of.hidden = names.length < 2;
    this.of.replaceChildren(element("option", { value: "" }, "gains of all"), ...names.map((name, i) => element("option", { value: i }, `gains of ${name}`)));
    if (this.#renew(controls)) return;
    const tables = new Map();
    for (const control of controls) {
      if (!tables.has(control.group)) tables.set(control.group, []);
      tables.get(control.group).push(control);
    }
    this.rows = [];
    this.list.replaceChildren(...[...tables].map(([table, members]) => this.#table(table, members)));
    this.filter();
    this.list.scrollTop = place;
  }

  /** New values of the same controls: what has the focus keeps it. Whether they were the same. */
  #renew(controls) {
    const shape = ({ key, kind, acts, low, high, choices, value }) => JSON.stringify([key, kind, acts, low, high, choices, value?.length]);
    const rows = new Map(this.rows.map((row) => [shape(row.control), row]));
    if (rows.size !== controls.length || !controls.every((control) => rows.has(shape(control)))) return false;
    for (const control of controls) Object.assign(rows.get(shape(control)).control, control);
    return true;
  }

  #table(table, members) {
    const rows = members.map((control) => this.#row(control));
    const details = element("details", { class: "table" },
      element("summary", {}, table, element("span", { class: "soft" }, ` ${members.length}`)), ...rows.map((row) => row.holder));
    details.open = this.open.has(table);
    details.addEventListener("toggle", () => {
      if (this.search.value) return;
      if (details.open) this.open.add(table); else this.open.delete(table);
    });
    for (const row of rows) row.details = details;
    this.rows.push(...rows);
    return details;
  }

  #row(control) {
    const { key, unit, meaning, acts } = control;
    const id = `key-${key}`;
    const row = { control, held: 0 };
    row.input = inputFor(control, id, (value, entry, moving) => {
      if (moving && this.state.over && this.studio.looking === null) { // it takes off: once, where it is dropped
        row.held = Infinity;
        return false;
      }
      row.held = performance.now() + OWN;
      setTimeout(() => this.#set(row), OWN);
      this.studio.change({ key, value, flight: control.flights ? this.flight : null, entry }, acts);
      return true;
    }, (field) => this.studio.refuse(nameOf(control), field));
    row.holder = element("div", { class: "key" },
      element("label", { for: id, title: key }, nameOf(control), element("span", { class: "unit" }, unit ? ` ${plainUnit(unit)}` : "")),
      acts === "restart" ? element("span", { class: "restarts", title: "A change takes off again" }, "restarts") : element("span"),
      row.input.holder, element("p", { class: "meaning" }, ...plain(meaning)));
    // What is being typed or dragged is not taken away before it is said, or left.
    row.holder.addEventListener("input", ({ target }) => { if (target.type !== "range" || acts === "restart") row.held = Infinity; });
    // What is refused stays to be seen until it is left.
    for (const kind of ["change", "focusout"]) row.holder.addEventListener(kind, ({ target }) => {
      if (row.held !== Infinity || (kind === "change" && !target.validity.valid)) return;
      row.held = 0;
      setTimeout(() => this.#set(row), OWN);
    });
    row.words = `${key} ${control.group} ${meaning} ${unit} ${key.replaceAll("_", " ")}`.toLowerCase();
    return row;
  }

  /** What a control is now, or will be on the branch to come: of the flight with a number where it is a gain. */
  now(control, flight = this.flight ?? control.flights?.[0]) {
    const own = this.studio.pending.filter((one) => one.key === control.key && (!control.flights || one.flight === null || one.flight === flight));
    return own.reduce((now, { value, entry }) => (entry === undefined ? value : now.map((one, i) => (i === entry ? value : one))), this.#flown(control, flight));
  }

  #flown({ key, value, values, flights }, flight) {
    const { gains, surface } = this.state;
    if (flights) return gains[flight]?.[key.replace(/^controller\./, "")] ?? values[flights.indexOf(flight)];
    const name = key.replace(/^surface\./, "");
    return name !== key && name in surface ? surface[name] : value;
  }

  /** Show what flies. */
  apply(state) {
    this.state = state;
    for (const row of this.rows) this.#set(row);
    this.#list();
  }

  #set(row) {
    const { control, holder, input } = row;
    if (performance.now() < row.held || !this.state) return;
    row.held = 0;
    const missing = control.flights && this.flight !== null && !control.flights.includes(this.flight);
    for (const field of holder.querySelectorAll("input, select")) field.disabled = missing;
    if (!missing) input.set(this.now(control));
  }

  /** Everything that is not what it was at take-off, or in the preset. */
  #list() {
    const told = [], wanted = { "take-off": false, preset: false };
    for (const { control } of this.rows) {
      const { key, acts, flights, preset, value, values } = control;
      const all = flights ? flights.map((flight, i) => [this.now(control, flight), values[i], preset[i]]) : [[this.now(control), value, preset]];
      const differs = { "take-off": all.some(([now, first]) => !same(now, first)), preset: all.some(([now, , own]) => !same(now, own)) };
      if (!differs["take-off"] && !differs.preset) continue;
      const of = (at) => [...new Set(all.map((one) => inWords(one[at])))].join("; ");
      const buttons = [["take-off", 1], ["preset", 2]].filter(([to]) => differs[to])
        .map(([to, at]) => button(`${to}: ${of(at)}`, { class: "back", "aria-label": `${key}: back to ${to}`, title: acts === "restart" ? "Takes off again" : "" }, () => this.studio.say("back", { to, key })));
      for (const to of Object.keys(wanted)) wanted[to] ||= differs[to];
      told.push(element("li", {}, element("span", { title: key }, `${control.group}: ${nameOf(control)}`), element("strong", {}, of(0)), ...buttons));
    }
    const what = JSON.stringify(told.map(({ textContent }) => textContent));
    if (what === this.listed) return; // a button that is pressed just now stays
    this.listed = what;
    this.changed.hidden = !told.length;
    this.changed.replaceChildren(
      element("div", { class: "row" }, element("h2", {}, `Changed: ${told.length}`),
        ...Object.keys(wanted).filter((to) => wanted[to]).map((to) => button(`All back to ${to}`, { class: "back" }, () => this.studio.say("back", { to })))),
      element("ul", {}, ...told));
  }

  filter() {
    const words = this.search.value.toLowerCase().split(/\s+/).filter(Boolean);
    let found = 0;
    const tables = new Map();
    for (const { holder, details, words: text } of this.rows) {
      const fits = words.every((word) => text.includes(word));
      holder.hidden = !fits;
      found += fits;
      tables.set(details, (tables.get(details) ?? false) || fits);
    }
    for (const [details, any] of tables) {
      details.hidden = !any;
      details.open = words.length ? any : this.open.has(details.querySelector("summary").firstChild.textContent);
    }
    this.count.textContent = words.length ? `${found} of ${this.rows.length}` : `${this.rows.length} keys`;
  }
}

/** The input of a control; `change` takes values (and whether a hand still moves) and returns whether it did, `refuse` a field that has none. */
function inputFor(control, id, change, refuse) {
  switch (control.kind) {
    case "switch": return switchFor(control, id, change);
    case "choice": return choiceFor(control, id, change);
    case "number": return numberFor(control, id, change, refuse);
    case "vector": return vectorFor(control, id, change, refuse);
    default: return textFor(control, id, change);
  }
}

function switchFor({ value }, id, change) {
  const input = element("input", { type: "checkbox", id, role: "switch" });
  input.checked = value;
  input.addEventListener("change", () => change(input.checked));
  return { holder: input, set: (next) => { input.checked = next; } };
}

function choiceFor({ value, choices }, id, change) {
  const select = element("select", { id }, ...choices.map((one) => element("option", { value: String(one) }, String(one))));
  select.value = String(value);
  select.addEventListener("change", () => change(choices.find((one) => String(one) === select.value)));
  return { holder: select, set: (next) => { select.value = String(next); } };
}

/** A number's field and, where it has a range, its slider. */
function entryFor(control, value, id, name, change, refuse) {
  const { low, high, acts, whole } = control;
  const field = element("input", { type: "number", id, step: "any", min: low ?? undefined, max: high ?? undefined, "aria-label": name });
  const bounds = value === null || (control.kind === "vector" && acts === "restart") ? null : rangeOf({ value, low, high });
  const slider = bounds && element("input", { type: "range", min: bounds[0], max: bounds[1], step: whole ? 1 : (bounds[1] - bounds[0]) / 500, "aria-label": `${name ?? control.key}, slider` });
  const set = (next) => {
    field.value = next === null ? "" : shown(next);
    if (slider && next !== null) slider.value = next;
  };
  let said = null; // the last value that was taken while a hand moves
  const often = seldom(60, (next) => { said = change(next, true) ? next : null; });
  field.addEventListener("change", () => {
    if (field.value === "" && value === null) return change(null);
    if (!field.checkValidity()) return refuse(field);
    if (field.value === "") return;
    set(Number(field.value));
    change(Number(field.value));
  });
  slider?.addEventListener("input", () => {
    field.value = shown(Number(slider.value));
    if (acts === "in flight") often(Number(slider.value));
  });
  slider?.addEventListener("change", () => {
    often.cancel();
    if (said !== Number(slider.value)) change(Number(slider.value));
    said = null;
  });
  set(value);
  return { field, slider, set };
}

function numberFor(control, id, change, refuse) {
  const { field, slider, set } = entryFor(control, control.value, id, undefined, (next, moving) => change(next, undefined, moving), refuse);
  return { holder: element("div", { class: "number" }, ...(slider ? [slider] : []), field), set };
}

/** Where a slider goes: over the whole range, or around the value where that is a small part of the range. */
function rangeOf({ value, low, high }) {
  const bounded = low !== null && high !== null, size = Math.abs(value ?? 0);
  if (bounded && high - low <= 8 * size) return [low, high];
  if (!size) return bounded && high - low <= 10 ? [low, high] : null;
  const [least, most] = value > 0 ? [0, 4 * size] : [-4 * size, 0];
  return [Math.max(low ?? -Infinity, least), Math.min(high ?? Infinity, most)];
}

function vectorFor(control, id, change, refuse) {
  const { value, key } = control;
  if (!value?.length || value.some((entry) => typeof entry !== "number")) return listFor(control, id, change, refuse);
  const entries = value.map((entry, i) => entryFor(control, entry, i ? `${id}-${i}` : id, `${key}, entry ${i + 1}`, (next, moving) => change(next, i, moving), refuse));
  return {
    holder: element("div", { class: "vector" }, ...entries.map(({ field, slider }) => element("div", {}, field, slider ?? ""))),
    set: (next) => next.forEach((entry, i) => entries[i].set(entry)),
  };
}

/** A list of other length or depth: as JSON. */
function listFor({ value }, id, change, refuse) {
  const field = element("input", { type: "text", id, placeholder: "[[0, 0], [0.1, 0]]" });
  const set = (next) => { field.value = next ? JSON.stringify(next) : ""; };
  field.addEventListener("change", () => {
    field.setCustomValidity("");
    try {
      const next = field.value.trim() ? JSON.parse(field.value) : value === null ? null : [];
      if (next !== null && !Array.isArray(next)) throw new Error();
      change(next);
    } catch {
      field.setCustomValidity("a list of numbers in brackets, such as [1, 0, 0]");
      refuse(field);
    }
  });
  set(value);
  return { holder: field, set };
}

function textFor({ value }, id, change) {
  const field = element("input", { type: "text", id, maxlength: 400 });
  field.value = value ?? "";
  field.addEventListener("change", () => change(field.value));
  return { holder: field, set: (next) => { field.value = next ?? ""; } };
}
