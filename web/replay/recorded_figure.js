// One flight that can be shown at any time: its figure, and the lines on the surface.

import { Group } from "vendor";
import { columns, lastNotAbove, mesh } from "../shared/decode.js";
import { Figure, colourOf } from "../shared/figure.js";
import { Lines } from "../shared/lines.js";
import { Pushes } from "./pushes.js";

const NOMINAL = 0x555555;

/** The colours of a line's segments, by the contact force at the time from which each is seen. */
function forces(since, { moments, contact }) {
  const [, , , x, y, z] = contact, colours = new Float32Array(6 * since.length);
  since.forEach((time, k) => {
    const at = Math.max(0, lastNotAbove(moments, time)), { r, g, b } = colourOf(Math.hypot(x[at], y[at], z[at]));
    colours.set([r, g, b, r, g, b], 6 * k);
  });
  return colours;
}

export class RecordedFigure extends Figure {
  static async of(flight, alone) {
    const meshes = await Promise.all(flight.meshes.map(mesh));
    const parts = ["moments", "poses", "thrusts", "contact", "cog"].map((name) => (flight[name] ? columns(flight[name]) : []));
    const [[moments], poses, thrusts, contact, cog] = await Promise.all(parts);
    const surface = flight.surface ? await columns(flight.surface) : null;
    const lines = await Promise.all(["nominal", "trace"].map(async (name) => {
      const { since, ends } = flight[name];
      return [(await columns(since))[0], await columns(ends)];
    }));
    const pushes = flight.pushes ? await Pushes.of(flight.pushes) : null;
    return new RecordedFigure(flight, meshes, { moments, poses, thrusts, contact, cog, surface }, lines, pushes, alone);
  }

  constructor(flight, meshes, motion, [nominal, trace], pushes, alone) {
    super(flight, meshes);
    this.flight = flight;
    this.motion = motion;
    this.end = motion.moments[motion.moments.length - 1];
    this.drawn = new Group();
    this.nominal = new Lines(...nominal, NOMINAL, 1.5);
    this.trace = new Lines(...trace, flight.colour, 4, alone ? forces(trace[0], motion) : null);
    this.drawn.add(this.nominal.object, this.trace.object);
    this.root.add(this.drawn);
    this.events = flight.events.filter((event) => event.push).map((event) => ({ ...event, arrow: this.addPush() }));
    this.pushes = pushes;
    if (pushes) this.root.add(pushes.object);
  }

  /** Show how hard the tip could push, or not. */
  showPushes(shown) {
    if (this.pushes) this.pushes.object.visible = shown;
  }

  /** Show the flight at a time, s. */
  at(time) {
    const { moments, poses, thrusts, contact, cog, surface } = this.motion;
    const i = Math.max(0, Math.min(lastNotAbove(moments, time), moments.length - 1));
    const j = Math.min(i + 1, moments.length - 1);
    const part = j > i ? Math.min(1, Math.max(0, (time - moments[i]) / (moments[j] - moments[i]))) : 0;
    const mixed = (column) => column[i] + part * (column[j] - column[i]);
    this.show(poses.map(mixed), thrusts.map(mixed), contact.map(mixed));
    for (const { arrow, push, time: begin, duration } of this.events) {
      arrow.visible = false;
      if (time < begin || time >= begin + duration) continue;
      this.showPush(arrow, push.link ? push : { body: 0, point: cog.map(mixed), force: push.force });
    }
    if (surface) {
      const [x, y, z, w, qx, qy, qz] = surface.map(mixed);
      this.drawn.position.set(x, y, z);
      this.drawn.quaternion.set(qx, qy, qz, w).normalize();
    }
    this.nominal.show(this.ghost ? -1 : Infinity);
    this.trace.show(time);
    this.pushes?.show(time, this.tip);
  }
}
