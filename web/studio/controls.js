// Every gain and key as a control, with search.

import { button, element } from "../shared/elements.js";
import { seldom } from "./connection.js";

const shown = (value) => (typeof value === "number" ? Number(value.toPrecision(6)) : value);

export class Controls {
  /** `change(control, value, flight)` is called with a value of the control's kind; flight null means all. */
  constructor(holder, change) {
    Object.assign(this, { change, rows: [], open: new Set(["controller.translation"]), flight: null });
    this.search = element("input", { type: "search", placeholder: "Search: stiffness, friction, latency …", "aria-label": "Search gains and keys", autocomplete: "off", spellcheck: "false" });
    this.of = element("select", { "aria-label": "Whose gains" });
    this.of.addEventListener("change", () => { this.flight = this.of.value === "" ? null : Number(this.of.value); this.#values(); });
    this.count = element("span", { class: "soft count", role: "status" });
    this.list = element("div", { class: "keys" });
    this.search.addEventListener("input", () => this.filter());
    holder.append(element("div", { class: "search" }, this.search, this.of, this.count), this.list);
  }

  show(controls, names) {
    const place = this.list.scrollTop;
    this.flight = null;
    this.of.hidden = names.length < 2;
    this.of.replaceChildren(element("option", { value: "" }, "gains of all"), ...names.map((name, i) => element("option", { value: i }, `gains of ${name}`)));
    if (this.#renew(controls)) return;
    const tables = new Map();
    const inOrder = [...controls].sort((a, b) => Boolean(b.flights) - Boolean(a.flights)); // gains first
    for (const control of inOrder) {
      const table = control.key.includes(".") ? control.key.split(".").slice(0, -1).join(".") : "experiment";
      if (!tables.has(table)) tables.set(table, []);
      tables.get(table).push(control);
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
    for (const control of controls) {
      const row = rows.get(shape(control));
      Object.assign(row.control, control);
      row.back.hidden = true;
      row.input.set(control.value);
    }
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
    const input = inputFor(control, id, (value) => { this.change(control, value, control.flights ? this.flight : null); this.#changed(row); });
    const back = button("↺", { class: "back", title: "Back to the value at take-off", "aria-label": `${key}: back to the value at take-off`, hidden: true },
      () => { input.set(control.value); this.change(control, control.value, control.flights ? this.flight : null); back.hidden = true; });
    const holder = element("div", { class: "key" },
      element("label", { for: id }, key.split(".").slice(-1)[0].replaceAll("_", " "), element("span", { class: "unit" }, unit ? ` ${unit}` : "")),
      acts === "restart" ? element("span", { class: "restarts", title: "A change takes off again" }, "restarts") : element("span"),
      back, input.holder, element("p", { class: "meaning" }, meaning));
    const row = { control, holder, input, back, words: `${key} ${meaning} ${unit} ${key.replaceAll("_", " ")}`.toLowerCase() };
    return row;
  }

  #changed(row) {
    row.back.hidden = row.control.acts === "restart";
  }

  /** The values of the chosen flight; a gain that it doesn't have can't be changed. */
  #values() {
    for (const { control, holder, input } of this.rows) {
      if (!control.flights) continue;
      const at = this.flight === null ? 0 : control.flights.indexOf(this.flight);
      for (const field of holder.querySelectorAll("input, select")) field.disabled = at < 0;
      if (at >= 0) input.set(control.values[at]);
    }
  }

  /** A value was changed, here or on another page; also what it is again where a change was refused. */
  set(key, value, flight) {
    for (const row of this.rows) {
      if (row.control.key !== key) continue;
      row.control.values = row.control.values?.map((old, i) => (flight === null || row.control.flights[i] === flight ? value : old));
      if (!row.holder.contains(document.activeElement) && (flight === null || this.flight === null || this.flight === flight)) row.input.set(value);
      this.#changed(row);
    }
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

function inputFor(control, id, change) {
  switch (control.kind) {
    case "switch": return switchFor(control, id, change);
    case "choice": return choiceFor(control, id, change);
    case "number": return numberFor(control, id, change);
    case "vector": return vectorFor(control, id, change);
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

function numberFor(control, id, change) {
  const { value, low, high, acts } = control;
  const whole = control.whole ?? false;
  const field = element("input", { type: "number", id, step: "any", min: low ?? undefined, max: high ?? undefined });
  field.value = value === null ? "" : shown(value);
  const bounds = value === null ? null : rangeOf(control);
  const slider = bounds && element("input", { type: "range", min: bounds[0], max: bounds[1], step: whole ? 1 : (bounds[1] - bounds[0]) / 500, "aria-label": `${control.key}, slider` });
  const set = (next) => {
    field.value = next === null ? "" : shown(next);
    if (slider && next !== null) slider.value = next;
  };
  const often = seldom(60, change);
  field.addEventListener("change", () => {
    if (field.value === "" && value === null) return change(null);
    if (field.value === "" || !field.checkValidity()) return field.reportValidity();
    set(Number(field.value));
    change(Number(field.value));
  });
  if (slider) {
    slider.value = value;
    slider.addEventListener("input", () => {
      field.value = shown(Number(slider.value));
      if (acts === "in flight") often(Number(slider.value));
    });
    if (acts !== "in flight") slider.addEventListener("change", () => change(Number(slider.value)));
  }
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

function vectorFor(control, id, change) {
  const { value, key, acts } = control;
  if (!value?.length || value.some((entry) => typeof entry !== "number")) return listFor(control, id, change);
  const often = seldom(60, change);
  const now = () => entries.map(({ field }) => Number(field.value));
  const entries = value.map((entry, i) => {
    const name = `${key}, entry ${i + 1}`;
    const field = element("input", { type: "number", step: "any", id: i ? `${id}-${i}` : id, min: control.low ?? undefined, max: control.high ?? undefined, "aria-label": name });
    field.value = shown(entry);
    field.addEventListener("change", () => {
      if (field.value === "" || !field.checkValidity()) return field.reportValidity();
      if (slider) slider.value = field.value;
      change(now());
    });
    const range = acts === "in flight" ? rangeOf({ ...control, value: entry }) : null;
    const slider = range && element("input", { type: "range", min: range[0], max: range[1], step: (range[1] - range[0]) / 500, "aria-label": `${name}, slider` });
    if (slider) {
      slider.value = entry;
      slider.addEventListener("input", () => { field.value = shown(Number(slider.value)); often(now()); });
    }
    return { field, slider };
  });
  const set = (next) => next.forEach((entry, i) => {
    entries[i].field.value = shown(entry);
    if (entries[i].slider) entries[i].slider.value = entry;
  });
  return { holder: element("div", { class: "vector" }, ...entries.map(({ field, slider }) => element("div", {}, field, slider ?? ""))), set };
}

/** A list of other length or depth: as JSON. */
function listFor({ value }, id, change) {
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
      field.reportValidity();
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
