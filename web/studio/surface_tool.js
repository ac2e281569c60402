// The surface: drag it, tilt it, make it slippery or soft, take it away.

import { Plane, Vector3 } from "vendor";
import { button, element } from "../shared/elements.js";
import { seldom } from "./connection.js";

const PERIOD = 150; // ms between two moves that are sent: each takes 0.2 s
const OWN = 400; // ms after a hand's own change for which the state may be older than it
const PLACE = ["x", "y", "z"], TILT = ["slope", "pitch"];

const SLIDERS = [
  ["x", "Forward, x", "m", -0.5, 0.5, 0.005], ["y", "Left, y", "m", -0.5, 0.5, 0.005], ["z", "Up, z", "m", -0.5, 0.5, 0.005],
  ["slope", "Slope", "rad", -0.5, 0.5, 0.005], ["pitch", "Pitch", "rad", -0.5, 0.5, 0.005],
];

export class SurfaceTool {
  constructor(studio, panel) {
    this.studio = studio;
    this.inputs = {};
    this.along = {}; // where a name says along which axis of the picture
    this.values = { x: 0, y: 0, z: 0, slope: 0, pitch: 0 };
    this.touched = {}; // what a hand has changed and not said yet
    this.held = 0;
    const row = (name, text, unit, low, high, step) => {
      const slider = element("input", { type: "range", min: low, max: high, step, "aria-label": `${text}, slider` });
      const field = element("input", { type: "number", id: `surface-${name}`, min: low, max: high, step: "any" });
      this.inputs[name] = (value) => { slider.value = value; field.value = Number(Number(value).toPrecision(5)); };
      slider.addEventListener("input", () => this.#touch(name, Number(slider.value)));
      field.addEventListener("input", () => { this.held = Infinity; });
      field.addEventListener("blur", () => { if (this.held === Infinity) { this.held = 0; this.#show(); } });
      field.addEventListener("change", () => {
        if (!field.checkValidity()) return studio.refuse(text, field);
        if (!field.value) return;
        this.#touch(name, Number(field.value));
      });
      this.inputs[name](0);
      return element("div", { class: "key" }, element("label", { for: `surface-${name}` }, text, this.along[name] = element("span"), element("span", { class: "unit" }, ` ${unit}`)),
        element("div", { class: "number" }, slider, field));
    };
    this.send = seldom(PERIOD, () => this.#say());
    this.present = element("input", { type: "checkbox", role: "switch", id: "surface-present" });
    this.present.checked = true;
    this.present.addEventListener("change", () => this.#touch("present", this.present.checked));
    this.tilting = element("input", { type: "checkbox", role: "switch", id: "surface-tilting" });
    this.why = element("p", { class: "why", role: "status" });
    this.parts = element("fieldset", {},
      ...SLIDERS.map((slider) => row(...slider)),
      row("friction", "Friction", "", 0, 1.5, 0.01),
      row("stiffness", "Stiffness", "N/m", 50, 20000, 50),
      element("div", { class: "row" },
        element("label", { class: "switch" }, this.present, " The surface is there"),
        element("label", { class: "switch" }, this.tilting, " A drag tilts"),
        button("As at the start", {}, () => this.#home())));
    panel.append(
      element("p", {}, "Mode Surface: drag it in the picture; with the switch A drag tilts, a drag tilts it. Every move takes 0.2 s."),
      this.why, this.parts);
  }

  /** A new take-off; the surface's keys are among the controls, the axes are those of contact and path. Moves are counted from where it is then. */
  begin(controls, [, u, v]) {
    this.along.slope.textContent = `: recedes along ${u.name}`;
    this.along.pitch.textContent = `: recedes along ${v.name}`;
    const found = (key, usual) => controls.find((control) => control.key === `surface.${key}`)?.value ?? usual;
    this.first = { position: found("position", [0, 0, 0]), slope: found("slope", 0), pitch: found("pitch", 0), friction: found("friction", 0), stiffness: found("stiffness", 5000) };
  }

  /** Show the surface that is there. */
  apply({ surface }) {
    this.state = surface;
    this.#show();
  }

  #show() {
    const { state, first } = this;
    if (!state || this.drag || performance.now() < this.held) return;
    PLACE.forEach((name, i) => { this.values[name] = state.position[i] - first.position[i]; });
    for (const name of TILT) this.values[name] = state[name] - first[name];
    Object.assign(this.values, { friction: state.friction, stiffness: state.stiffness });
    for (const [name, set] of Object.entries(this.inputs)) set(Math.abs(this.values[name]) < 1e-9 ? 0 : this.values[name]);
    this.present.checked = state.present;
  }

  /** Let it be changed, or say why not. */
  allow(why) {
    this.why.textContent = why;
    this.parts.disabled = Boolean(why);
  }

  /** A hand changes one number. */
  #touch(name, value) {
    this.values[name] = this.touched[name] = value;
    this.inputs[name]?.(value);
    this.held = performance.now() + OWN;
    setTimeout(() => this.#show(), OWN + 1);
    this.send();
  }

  /** Say what was changed, and nothing else. */
  #say() {
    const { touched } = this, { friction = null, stiffness = null, present = null } = touched;
    const entries = (names) => (names.some((name) => name in touched) ? names.map((name) => touched[name] ?? null) : null);
    this.touched = {};
    this.held = performance.now() + OWN;
    this.studio.say("surface", { position: entries(PLACE), tilt: entries(TILT), friction, stiffness, present });
    setTimeout(() => this.#show(), OWN + 1);
  }

  #home() {
    for (const name of [...PLACE, ...TILT]) this.#touch(name, 0);
    for (const name of ["friction", "stiffness"]) this.#touch(name, this.first[name]);
    this.present.checked = true;
    this.#touch("present", true);
  }

  grab(event) {
    const ray = this.studio.sceneView.rayAt(event);
    const objects = ray && this.studio.figures[ray.flight].surfaceObjects;
    const [hit] = objects ? ray.caster.intersectObjects(objects, true) : [];
    if (!hit || !this.studio.may("surface")) return false;
    const normal = this.studio.sceneView.camera.getWorldDirection(new Vector3());
    this.drag = { x: event.clientX, y: event.clientY, from: hit.point, plane: new Plane().setFromNormalAndCoplanarPoint(normal, hit.point), before: { ...this.values } };
    return true;
  }

  move(event) {
    if (!this.drag) return;
    const { before, plane, from, x, y } = this.drag;
    if (this.tilting.checked) {
      this.#drag("slope", before.slope + (event.clientX - x) / 400);
      this.#drag("pitch", before.pitch + (event.clientY - y) / 400);
      return;
    }
    const to = this.studio.sceneView.rayAt(event)?.caster.ray.intersectPlane(plane, new Vector3());
    if (!to) return;
    const moved = to.sub(from);
    for (const name of PLACE) this.#drag(name, before[name] + moved[name]);
  }

  release() { this.drag = null; }

  #drag(name, value) {
    const next = Math.max(-0.5, Math.min(0.5, value));
    if (next !== this.values[name]) this.#touch(name, next);
  }
}
