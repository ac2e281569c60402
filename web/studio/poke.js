// Pokes: drag on a link, or hold a button, or hold an arrow key. The arrow leads from the link to the pointer.

import { Plane, Vector3 } from "vendor";
import { METRES_PER_NEWTON } from "../shared/figure.js";
import { choice, element } from "../shared/elements.js";
import { seldom } from "./connection.js";

const STRONGEST = 20; // N
const PERIOD = 80; // ms between two forces that are sent

const DIRECTIONS = [
  ["toward", "toward the surface (+x)", [1, 0, 0]], ["away", "away from it (−x)", [-1, 0, 0]],
  ["left", "left (+y)", [0, 1, 0]], ["right", "right (−y)", [0, -1, 0]],
  ["up", "up (+z)", [0, 0, 1]], ["down", "down (−z)", [0, 0, -1]],
];
const KEYS = { ArrowLeft: [-1, 0, 0], ArrowRight: [1, 0, 0], ArrowUp: [0, 1, 0], ArrowDown: [0, -1, 0], PageUp: [0, 0, -1], PageDown: [0, 0, 1] };

export class Poke {
  constructor(studio, panel) {
    this.studio = studio;
    this.held = null;
    this.send = seldom(PERIOD, () => this.#say());
    this.force = element("input", { type: "number", id: "poke-force", min: 0.1, max: STRONGEST, step: 0.1, value: 2, required: true });
    this.link = choice("Link that is poked", [], "", () => {});
    this.direction = choice("Direction of the poke", DIRECTIONS.map(([name, text]) => [name, text]), "left", () => {});
    this.hold = element("button", { type: "button", class: "main hold" }, "Hold to poke");
    panel.append(
      element("p", {}, "Drag on a link in the picture (mode Poke, or with Shift). Or choose here and hold the button; Space or Enter hold it too."),
      element("div", { class: "fields" },
        element("label", {}, "Link ", this.link),
        element("label", { for: "poke-force" }, "Force, N ", this.force),
        element("label", {}, "Direction ", this.direction)),
      this.hold, this.why = element("p", { class: "why", role: "status" }));
    const begin = (event) => { event.preventDefault(); this.hold.setPointerCapture?.(event.pointerId); this.#press(this.#chosenDirection()); };
    this.hold.addEventListener("pointerdown", begin);
    for (const end of ["pointerup", "pointercancel", "lostpointercapture", "blur"]) this.hold.addEventListener(end, () => this.release());
    this.hold.addEventListener("keydown", (event) => {
      if ((event.key === " " || event.key === "Enter") && !event.repeat) { event.preventDefault(); this.#press(this.#chosenDirection()); }
    });
    this.hold.addEventListener("keyup", () => this.release());
  }

  /** Let the button be pressed, or say why not; what is held is let go then. */
  allow(why) {
    if (why) this.release();
    this.why.textContent = why;
    this.hold.disabled = Boolean(why);
  }

  /** A new take-off: what was held belongs to the flight before. */
  begin(links) {
    this.release();
    const before = this.link.value;
    this.link.replaceChildren(...links.map(({ name }) => element("option", { value: name }, name)));
    this.link.value = links.some(({ name }) => name === before) ? before : links[Math.floor(links.length / 2)]?.name ?? ""; // near the centre of gravity
    this.links = links;
  }

  #chosenDirection() {
    return new Vector3(...DIRECTIONS.find(([name]) => name === this.direction.value)[2]);
  }

  /** A poke of so many newtons at the middle of the chosen link. */
  #press(direction) {
    if (!this.force.checkValidity()) return this.studio.refuse("Force", this.force);
    const link = this.links.find(({ name }) => name === this.link.value);
    if (!link || !this.studio.may("poke")) return;
    this.held = { link, point: link.middle ?? [0, 0, 0], force: direction.multiplyScalar(Number(this.force.value)) };
    this.#show();
    this.#say();
  }

  /** A key on the picture in mode Poke; whether it meant a poke. */
  key(event) {
    const way = KEYS[event.key];
    if (!way) return false;
    if (event.repeat) return true;
    this.pressed = event.key;
    this.#press(new Vector3(...way).transformDirection(this.studio.sceneView.camera.matrixWorld));
    return true;
  }

  /** A key on the picture went up: one that pokes no more, or one that was held for something else. */
  keyUp({ key }) {
    if (key === this.pressed) this.release();
  }

  /** The link under a pointer, and where it is met. */
  linkAt(event) {
    const ray = this.studio.sceneView.rayAt(event);
    if (!ray) return null;
    const figure = this.studio.figures[ray.flight];
    const [hit] = ray.caster.intersectObjects(figure.bodies, true)
      .filter(({ object }) => !object.material.transparent); // a rotor's disc is only air
    const link = hit && this.links.find(({ body }) => body === hit.object.userData.body);
    return link ? { flight: ray.flight, link, point: figure.bodies[link.body].worldToLocal(hit.point.clone()).toArray() } : null;
  }

  /** The pointer went down on the picture; whether a link is under it. */
  grab(event) {
    const found = this.linkAt(event);
    if (!found || !this.studio.may("poke")) return false;
    const { flight, link, point } = found;
    this.link.value = link.name;
    this.held = { link, point, force: new Vector3() };
    this.drag = { flight, event };
    this.follow();
    return true;
  }

  move(event) {
    if (!this.drag) return;
    this.drag.event = event;
    this.follow();
  }

  /** The force goes from the point on the link, which moves, to the pointer. */
  follow() {
    if (!this.drag || !this.held) return;
    const { sceneView, figures } = this.studio, figure = figures[this.drag.flight];
    const ray = sceneView.rayAt(this.drag.event);
    if (!ray || ray.flight !== this.drag.flight) return;
    const from = figure.bodies[this.held.link.body].localToWorld(new Vector3(...this.held.point));
    const plane = new Plane().setFromNormalAndCoplanarPoint(sceneView.camera.getWorldDirection(new Vector3()), from);
    const to = ray.caster.ray.intersectPlane(plane, new Vector3());
    if (!to) return;
    const force = to.sub(from).divideScalar(METRES_PER_NEWTON.contact).clampLength(0, STRONGEST);
    const changed = force.distanceTo(this.held.force) > 0.05;
    this.held.force.copy(force);
    this.#show();
    if (changed) this.send();
  }

  release() {
    if (!this.held) return;
    this.send.cancel();
    this.held = this.drag = this.pressed = null;
    this.#show();
    this.studio.say("release");
  }

  #say() {
    if (!this.held) return;
    const { link, point, force } = this.held;
    this.studio.say("poke", { link: link.name, point, force: force.toArray() });
  }

  #show() {
    const { held, studio } = this;
    for (const figure of studio.figures) {
      figure.poke = held && { body: held.link.body, point: held.point, force: held.force.toArray() };
    }
    studio.readForce(held ? `${held.force.length().toFixed(1)} N on ${held.link.name}` : "");
    this.hold.classList.toggle("held", Boolean(held));
  }
}
