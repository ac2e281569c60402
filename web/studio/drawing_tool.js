// Draw on the surface with the mouse, or give an SVG file: the robot draws that.

import { button, choice, element } from "../shared/elements.js";
import { segments } from "../shared/lines.js";

const SPACING = 0.005; // m between two points of a stroke
const LIFT = 0.006; // m by which the plan stands before the surface
const FONTS = [["futural", "plain"], ["rowmans", "rounded"], ["scripts", "handwriting"], ["cursive", "cursive"]]; // whose letters are single lines
const DRAWING = ["drawing", "following"], BEST = "drawing"; // contact laws that feel for the surface at each stroke; the controller that draws best
const LARGEST = 500_000; // bytes of an SVG

export class DrawingTool {
  constructor(studio, panel) {
    this.studio = studio;
    this.strokes = [];
    this.fly = button("Draw this", { class: "main", disabled: true }, () => this.#send());
    this.wipe = button("Wipe off", { disabled: true }, () => this.clear());
    this.file = element("input", { type: "file", accept: ".svg,image/svg+xml", id: "svg-file" });
    this.file.addEventListener("change", () => { if (this.file.files[0]) this.take(this.file.files[0]); this.file.value = ""; });
    this.count = element("span", { class: "soft", role: "status" }, "nothing drawn yet");
    this.words = element("input", { type: "text", id: "draw-words", maxlength: 400, placeholder: "hello", autocomplete: "off", spellcheck: "false" });
    this.words.addEventListener("keydown", ({ key }) => { if (key === "Enter") this.#write(); });
    this.font = choice("Font", FONTS, FONTS[0][0], () => {});
    this.best = element("p", { class: "best" });
    panel.append(
      this.best,
      element("p", {}, "Choose mode Draw and draw on the surface with the mouse. The flight takes off again and draws your lines."),
      element("div", { class: "row" }, this.fly, this.wipe, this.count),
      element("div", { class: "row" }, element("label", { for: "draw-words" }, "Or words"), this.words, this.font, button("Write", {}, () => this.#write())),
      element("label", { for: "svg-file" }, "Or an SVG file, which may also be dropped on this page "), this.file);
    document.addEventListener("dragover", (event) => { event.preventDefault(); });
    document.addEventListener("drop", (event) => {
      event.preventDefault();
      const [file] = event.dataTransfer.files;
      if (file) this.take(file);
    });
  }

  /** A new take-off: who cannot draw well is told who can. */
  begin(controls, flights, offered) {
    this.clear();
    const law = controls.find(({ key }) => key === "controller.contact.law");
    const poor = (law?.flights ?? []).filter((_, i) => !DRAWING.includes(law.values[i])).map((flight) => flights[flight].controller);
    this.best.hidden = !poor.length || !offered.includes(BEST);
    const names = offered.length && [...new Set(this.studio.state.controllers?.map((name) => (poor.includes(name) ? BEST : name)))];
    const code = (name) => element("code", {}, name);
    this.best.replaceChildren(...poor.flatMap((name, i) => (i ? [" and ", code(name)] : [code(name)])), " may miss where a stroke begins, as nothing feels for the surface there. ", code(BEST), " does. ",
      button(`Fly ${BEST}`, {}, () => this.studio.say("controllers", { names: names.length ? names : [BEST] })));
  }

  #write() {
    const text = this.words.value.trim();
    if (text) return this.studio.say("draw", { text, font: this.font.value });
    this.studio.note("There are no words to write yet: type some first", "bad");
    this.words.focus();
  }

  async take(file) {
    if (!/\.svg$/i.test(file.name)) return this.studio.note(`${file.name} is no SVG file`, "bad");
    if (file.size > LARGEST) return this.studio.note(`${file.name} is larger than ${LARGEST / 1000} kB`, "bad");
    this.studio.say("draw", { svg: await file.text(), name: file.name.slice(-200) });
  }

  grab(event) {
    const point = this.#pointAt(event, () => this.studio.note("This is the surface's back, and the robot draws on its front: turn the picture first", "bad"));
    if (!point) return false;
    this.stroke = [point];
    this.strokes.push(this.stroke);
    return true;
  }

  move(event) {
    const point = this.stroke && this.#pointAt(event);
    if (!point) return;
    const [u, v] = this.stroke[this.stroke.length - 1];
    if (Math.hypot(point[0] - u, point[1] - v) < SPACING) return;
    this.stroke.push(point);
    this.#show();
  }

  release() {
    if (this.stroke && this.stroke.length < 2) this.strokes.pop();
    this.stroke = null;
    this.#show();
  }

  clear() {
    this.strokes = [];
    this.stroke = null;
    this.#show();
  }

  #send() {
    if (this.studio.say("draw", { strokes: this.strokes })) this.clear();
  }

  /** Where a pointer meets the surface's front: (u, v) in m from its middle; calls who asks where it meets the back. */
  #pointAt(event, behind = () => {}) {
    const ray = this.studio.sceneView.rayAt(event);
    if (!ray) return null;
    const figure = this.studio.figures[ray.flight];
    const [hit] = ray.caster.intersectObjects(figure.surfaceObjects, true);
    if (!hit) return null;
    const { x: depth, y: u, z: v } = figure.drawn.worldToLocal(hit.point.clone());
    const { x: from } = figure.drawn.worldToLocal(ray.caster.ray.origin.clone());
    if (from > depth) return behind();
    return [u, v];
  }

  #show() {
    for (const figure of this.studio.figures) {
      if (figure.plan) { figure.drawn.remove(figure.plan); figure.plan.geometry.dispose(); figure.plan = null; }
      if (!this.strokes.length) continue;
      const place = ([u, v]) => [-LIFT, u, v];
      const points = this.strokes.flatMap((stroke) => stroke.slice(1).flatMap((end, k) => [...place(stroke[k]), ...place(end)]));
      figure.plan = segments(new Float32Array(points), 0xd55e00, 3);
      figure.drawn.add(figure.plan);
    }
    const points = this.strokes.reduce((sum, stroke) => sum + stroke.length, 0);
    this.fly.disabled = this.wipe.disabled = points < 2;
    this.count.textContent = points ? `${this.strokes.length} ${this.strokes.length === 1 ? "stroke" : "strokes"}` : "nothing drawn yet";
    this.studio.stale();
  }
}
