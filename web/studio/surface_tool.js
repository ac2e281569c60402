// The surface: drag it, tilt it, make it slippery or soft, take it away.

import { Plane, Vector3 } from "vendor";
import { button, element } from "../shared/elements.js";
import { seldom } from "./connection.js";

const PERIOD = 150; // ms between two moves that are sent: each takes 0.2 s

const SLIDERS = [
  ["x", "Forward, x", "m", -0.5, 0.5, 0.005], ["y", "Left, y", "m", -0.5, 0.5, 0.005], ["z", "Up, z", "m", -0.5, 0.5, 0.005],
  ["slope", "Turn about v", "rad", -0.5, 0.5, 0.005], ["pitch", "Turn about u", "rad", -0.5, 0.5, 0.005],
];

export class SurfaceTool {
  constructor(studio, panel) {
    this.studio = studio;
    this.inputs = {};
    this.values = { x: 0, y: 0, z: 0, slope: 0, pitch: 0 };
    const row = (name, text, unit, low, high, step, act) => {
      const slider = element("input", { type: "range", min: low, max: high, step, "aria-label": `${text}, slider` });
      const field = element("input", { type: "number", id: `surface-${name}`, min: low, max: high, step: "any" });
      const set = (value) => { slider.value = value; field.value = Number(Number(value).toPrecision(5)); };
      slider.addEventListener("input", () => { set(slider.value); act(Number(slider.value)); });
      field.addEventListener("change", () => {
        if (!field.value || !field.checkValidity()) return field.reportValidity();
        set(field.value);
        act(Number(field.value));
      });
      this.inputs[name] = set;
      set(0);
      return element("div", { class: "key" }, element("label", { for: `surface-${name}` }, text, element("span", { class: "unit" }, ` ${unit}`)),
        element("div", { class: "number" }, slider, field));
    };
    this.sendPlace = seldom(PERIOD, () => this.studio.say("surface", this.#place()));
    this.sendTilt = seldom(PERIOD, () => this.studio.say("surface", this.#tilt()));
    const friction = seldom(PERIOD, (value) => studio.say("surface", { friction: value }));
    const stiffness = seldom(PERIOD, (value) => studio.say("surface", { stiffness: value }));
    this.present = element("input", { type: "checkbox", role: "switch", id: "surface-present" });
    this.present.checked = true;
    this.present.addEventListener("change", () => studio.say("surface", { present: this.present.checked }));
    this.tilting = element("input", { type: "checkbox", role: "switch", id: "surface-tilting" });
    panel.append(
      element("p", {}, "Mode Surface: drag it in the picture; with the right switch a drag tilts it. Every move takes 0.2 s."),
      ...SLIDERS.map(([name, text, unit, low, high, step]) => row(name, text, unit, low, high, step, (value) => {
        this.values[name] = value;
        if (name.length === 1) this.sendPlace(); else this.sendTilt();
      })),
      row("friction", "Friction", "", 0, 1.5, 0.01, friction),
      row("stiffness", "Stiffness", "N/m", 50, 20000, 50, stiffness),
      element("div", { class: "row" },
        element("label", { class: "switch" }, this.present, " The surface is there"),
        element("label", { class: "switch" }, this.tilting, " A drag tilts"),
        button("As at the start", {}, () => this.#home())));
  }

  /** A new take-off; the surface's keys are among the controls. Moves are counted from where it is then. */
  begin(controls) {
    const found = (key, usual) => controls.find((control) => control.key === `surface.${key}`)?.value ?? usual;
    this.first = { friction: found("friction", 0), stiffness: found("stiffness", 5000) };
    this.#show();
  }

  #show() {
    this.values = { x: 0, y: 0, z: 0, slope: 0, pitch: 0 };
    for (const name of Object.keys(this.values)) this.inputs[name](0);
    this.inputs.friction(this.first.friction);
    this.inputs.stiffness(this.first.stiffness);
    this.present.checked = true;
  }

  #home() {
    this.#show();
    const { friction, stiffness } = this.first;
    this.studio.say("surface", { ...this.#place(), ...this.#tilt(), friction, stiffness, present: true });
  }

  #place() {
    return { position: [this.values.x, this.values.y, this.values.z] };
  }

  #tilt() {
    return { tilt: [this.values.slope, this.values.pitch] };
  }

  grab(event) {
    const ray = this.studio.sceneView.rayAt(event);
    const objects = ray && this.studio.figures[ray.flight].surfaceObjects;
    const [hit] = objects ? ray.caster.intersectObjects(objects, true) : [];
    if (!hit) return false;
    const normal = this.studio.sceneView.camera.getWorldDirection(new Vector3());
    this.drag = { x: event.clientX, y: event.clientY, from: hit.point, plane: new Plane().setFromNormalAndCoplanarPoint(normal, hit.point), before: { ...this.values } };
    return true;
  }

  move(event) {
    if (!this.drag) return;
    const { before, plane, from, x, y } = this.drag;
    if (this.tilting.checked) {
      this.#set("slope", before.slope + (event.clientX - x) / 400);
      this.#set("pitch", before.pitch + (event.clientY - y) / 400);
      this.sendTilt();
      return;
    }
    const to = this.studio.sceneView.rayAt(event)?.caster.ray.intersectPlane(plane, new Vector3());
    if (!to) return;
    const moved = to.sub(from);
    for (const name of ["x", "y", "z"]) this.#set(name, before[name] + moved[name]);
    this.sendPlace();
  }

  release() { this.drag = null; }

  #set(name, value) {
    this.values[name] = Math.max(-0.5, Math.min(0.5, value));
    this.inputs[name](this.values[name]);
  }
}
