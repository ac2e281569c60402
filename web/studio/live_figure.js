// One live flight in three dimensions: its figure at the newest frame, the reference line, and what the pen has drawn.

import { Color, Group, Matrix4, Quaternion, Vector3 } from "vendor";
import { columns, mesh } from "../shared/decode.js";
import { Figure, colourOf } from "../shared/figure.js";
import { Lines, segments } from "../shared/lines.js";

const NOMINAL = 0x555555;
const MOST = 12000; // segments of the drawn line
const SPACING = 0.004; // m between its points
const TOUCH = 0.05; // N from which the pen draws
const LIFT = 0.003; // m by which the line stands before the surface

export class LiveFigure extends Figure {
  static async of(scene, layout, alone) {
    const meshes = await Promise.all(scene.meshes.map(mesh));
    const { since, ends } = scene.nominal;
    return new LiveFigure(scene, meshes, layout, [(await columns(since))[0], await columns(ends)], alone);
  }

  constructor(scene, meshes, layout, nominal, alone) {
    super(scene, meshes);
    this.layout = layout;
    this.end = Infinity;
    this.drawn = new Group(); // the surface's axes, where it is now
    this.root.add(this.drawn);
    this.nominal = new Lines(...nominal, NOMINAL, 1.5);
    this.reference = new Group(); // W, as it was when the surface stood where it was at take-off
    this.reference.add(this.nominal.object);
    axesOf(scene.surface).invert().decompose(this.reference.position, this.reference.quaternion, this.reference.scale);
    // Alone its line tells the force by its colour; beside another one, whose line it is.
    this.trace = segments(new Float32Array(6 * MOST), scene.colour, 4, alone ? new Float32Array(6 * MOST) : null);
    this.drawn.add(this.reference, this.trace);
    this.surfaceObjects = this.bodies[scene.body_names.indexOf("surface")]?.children ?? [];
    this.pokeArrow = this.addPush();
    this.shade = new Color();
    this.poke = null; // {body, point, force}
    this.clear();
  }

  /** Forget what the pen has drawn. */
  clear() {
    this.count = 0;
    this.times = [];
    this.last = null;
    this.trace.geometry.instanceCount = 0;
    this.trace.visible = false;
  }

  take(frame) { this.newest = frame; }

  /** Show the newest frame. */
  at() {
    if (!this.newest) return;
    const part = (name) => this.newest.subarray(...this.layout[name]);
    this.show(part("poses"), part("thrusts"), [...part("tip"), ...part("force")]);
    const [x, y, z, qw, qx, qy, qz] = part("surface");
    this.drawn.position.set(x, y, z);
    this.drawn.quaternion.set(qx, qy, qz, qw);
    this.nominal.show(this.ghost ? -1 : Infinity);
    this.#showPoke();
  }

  #showPoke() {
    this.pokeArrow.visible = false;
    if (this.poke) this.showPush(this.pokeArrow, this.poke);
  }

  /** Let the pen draw what a frame says; after a rewind, what came later is wiped off. */
  draw(frame) {
    const time = frame[0], { tip, force: push, surface } = this.layout;
    while (this.times.length && this.times[this.times.length - 1] > time) { this.times.pop(); this.count--; this.last = null; }
    const [x, y, z] = frame.subarray(...tip), [fx, fy, fz] = frame.subarray(...push);
    const force = Math.hypot(fx, fy, fz);
    if (!(force > TOUCH)) {
      this.last = null;
      return;
    }
    const [sx, sy, sz, qw, qx, qy, qz] = frame.subarray(...surface);
    const place = new Vector3(x, y, z).addScaledVector(new Vector3(fx, fy, fz), LIFT / force)
      .sub(new Vector3(sx, sy, sz)).applyQuaternion(new Quaternion(qx, qy, qz, qw).invert());
    if (this.last && place.distanceTo(this.last) < SPACING) return;
    if (this.last && this.count < MOST) this.#segment(this.last, place, time, force);
    this.last = place;
  }

  #segment(from, to, time, force) {
    const { instanceStart, instanceColorStart } = this.trace.geometry.attributes;
    if (instanceColorStart) {
      const { r, g, b } = colourOf(force, this.shade);
      instanceColorStart.data.array.set([r, g, b, r, g, b], 6 * this.count);
      instanceColorStart.data.needsUpdate = true;
    }
    const { data } = instanceStart;
    data.array.set([from.x, from.y, from.z, to.x, to.y, to.z], 6 * this.count);
    data.needsUpdate = true;
    this.times.push(time);
    this.count++;
    this.trace.geometry.instanceCount = this.count;
    this.trace.visible = true;
  }
}

/** The surface's axes: columns into it, along u, along v; and its origin. */
function axesOf({ origin, axis_u: u, axis_v: v, normal }) {
  const axes = new Matrix4().makeBasis(new Vector3(...normal).negate(), new Vector3(...u), new Vector3(...v));
  return axes.setPosition(...origin);
}
