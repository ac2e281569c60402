// One flight in three dimensions: its shapes on their bodies, the lines on the surface, and the arrows.

import {
  ArrowHelper, BoxGeometry, BufferAttribute, BufferGeometry, CapsuleGeometry, Color, CylinderGeometry,
  DoubleSide, FrontSide, Group, Mesh, MeshLambertMaterial, PlaneGeometry, Quaternion, SphereGeometry, SRGBColorSpace, Vector3,
} from "three";
import { LineMaterial } from "three/addons/lines/LineMaterial.js";
import { LineSegments2 } from "three/addons/lines/LineSegments2.js";
import { LineSegmentsGeometry } from "three/addons/lines/LineSegmentsGeometry.js";
import { columns, lastNotAbove, mesh } from "./decode.js";

const METRES_PER_NEWTON = { thrust: 0.02, contact: 0.12 };
const THRUST = 0x2e7d32, CONTACT = 0xb00020, NOMINAL = 0x555555;

function geometryOf(shape, meshes) {
  const [a, b, c] = shape.size;
  switch (shape.kind) {
    case "sphere": return new SphereGeometry(a, 16, 10);
    case "ellipsoid": return new SphereGeometry(1, 16, 10).scale(a, b, c);
    case "box": return new BoxGeometry(2 * a, 2 * b, 2 * c);
    case "cylinder": return new CylinderGeometry(a, a, 2 * b, 24).rotateX(Math.PI / 2);
    case "capsule": return new CapsuleGeometry(a, 2 * b, 6, 16).rotateX(Math.PI / 2);
    case "plane": return new PlaneGeometry(2 * (a || 10), 2 * (b || 10));
    case "mesh": {
      const geometry = new BufferGeometry();
      geometry.setAttribute("position", new BufferAttribute(meshes[shape.mesh].vertices, 3));
      geometry.setIndex(new BufferAttribute(meshes[shape.mesh].faces, 1));
      geometry.computeVertexNormals();
      return geometry;
    }
  }
  return null;
}

const quaternionOf = ([w, x, y, z]) => new Quaternion(x, y, z, w);

/** A line of segments that are seen from their own time on. */
class Ink {
  constructor(since, ends, colour, width) {
    this.since = since;
    const count = since.length, points = new Float32Array(6 * count);
    for (let i = 0; i < count; i++) for (let c = 0; c < 6; c++) points[6 * i + c] = ends[c][i];
    const geometry = new LineSegmentsGeometry();
    if (count) geometry.setPositions(points);
    this.object = new LineSegments2(geometry, new LineMaterial({ color: colour, linewidth: width }));
    this.object.frustumCulled = false;
    this.show(-1);
  }

  show(time) {
    const seen = lastNotAbove(this.since, time + 1e-3) + 1;
    this.object.geometry.instanceCount = seen;
    this.object.visible = seen > 0;
  }
}

export class Stage {
  static async of(flight) {
    const meshes = await Promise.all(flight.meshes.map(mesh));
    const parts = ["moments", "poses", "thrusts", "contact"].map((name) => (flight[name] ? columns(flight[name]) : []));
    const [[moments], poses, thrusts, contact] = await Promise.all(parts);
    const surface = flight.surface ? await columns(flight.surface) : null;
    const inks = await Promise.all(["nominal", "trace"].map(async (name) => {
      const { since, ends } = flight[name];
      return [(await columns(since))[0], await columns(ends)];
    }));
    return new Stage(flight, meshes, { moments, poses, thrusts, contact, surface }, inks);
  }

  constructor(flight, meshes, motion, [nominal, trace]) {
    this.flight = flight;
    this.motion = motion;
    this.root = new Group();
    this.end = motion.moments[motion.moments.length - 1];
    this.materials = [];
    this.floor = new MeshLambertMaterial(); // replaced by that of the scene's floor, where it has one
    this.still = [];
    this.bodies = Array.from({ length: flight.bodies }, () => new Group());
    this.root.add(...this.bodies);
    for (const shape of flight.shapes) this.#addShape(shape, meshes);
    this.drawn = new Group();
    this.nominal = new Ink(...nominal, NOMINAL, 1.5);
    this.trace = new Ink(...trace, flight.colour, 4);
    this.drawn.add(this.nominal.object, this.trace.object);
    this.root.add(this.drawn);
    this.arrows = new Group();
    this.thrustArrows = flight.rotors.map(() => this.#arrow(THRUST));
    this.contactArrow = this.#arrow(CONTACT);
    this.root.add(this.arrows);
    this.tip = new Vector3();
    this.centre = new Vector3();
  }

  #addShape(shape, meshes) {
    const geometry = geometryOf(shape, meshes);
    if (!geometry) return;
    const [r, g, b, alpha] = shape.colour;
    const material = new MeshLambertMaterial({
      color: new Color().setRGB(r, g, b, SRGBColorSpace), transparent: alpha < 1, opacity: alpha, depthWrite: alpha === 1,
      side: shape.kind === "plane" || shape.kind === "mesh" ? DoubleSide : FrontSide,
    });
    const object = new Mesh(geometry, material);
    object.position.set(...shape.position);
    object.quaternion.copy(quaternionOf(shape.quaternion));
    this.bodies[shape.body].add(object);
    if (shape.kind === "plane" && shape.body === 0) this.floor = material;
    if (shape.body === 0) this.still.push(object); else this.materials.push([material, alpha, material.color.clone()]);
  }

  #arrow(colour) {
    const arrow = new ArrowHelper(new Vector3(0, 0, 1), new Vector3(), 0.1, colour);
    this.arrows.add(arrow);
    return arrow;
  }

  /** As one of several in the same picture: in its controller's colour, the later ones see-through. */
  asGhost(ghost, first) {
    const tint = new Color(this.flight.colour);
    for (const [material, alpha, colour] of this.materials) {
      material.color.copy(colour);
      if (ghost) material.color.lerp(tint, 0.65);
      material.opacity = ghost && !first ? 0.45 * alpha : alpha;
      material.transparent = material.opacity < 1;
    }
    for (const object of this.still) object.visible = !ghost || first;
    this.ghost = ghost && !first;
  }

  /** Show the flight at a time, s. */
  at(time) {
    const { moments, poses, thrusts, contact, surface } = this.motion;
    const i = Math.max(0, Math.min(lastNotAbove(moments, time), moments.length - 1));
    const j = Math.min(i + 1, moments.length - 1);
    const part = j > i ? Math.min(1, Math.max(0, (time - moments[i]) / (moments[j] - moments[i]))) : 0;
    const mixed = (column) => column[i] + part * (column[j] - column[i]);
    this.bodies.forEach((body, b) => {
      if (b === 0) return;
      const [x, y, z, qw, qx, qy, qz] = poses.slice(7 * b, 7 * b + 7).map(mixed);
      body.position.set(x, y, z);
      body.quaternion.set(qx, qy, qz, qw).normalize();
    });
    if (surface) this.drawn.position.set(...surface.map(mixed));
    this.nominal.show(this.ghost ? -1 : Infinity);
    this.trace.show(time);
    this.flight.rotors.forEach((rotor, r) => {
      const body = this.bodies[rotor.body];
      const from = new Vector3(...rotor.position).applyQuaternion(body.quaternion).add(body.position);
      const along = new Vector3(...rotor.direction).applyQuaternion(body.quaternion);
      this.#point(this.thrustArrows[r], from, along.multiplyScalar(mixed(thrusts[r]) * METRES_PER_NEWTON.thrust));
    });
    const [tx, ty, tz, fx, fy, fz] = contact.map(mixed);
    this.tip.set(tx, ty, tz);
    this.#point(this.contactArrow, this.tip, new Vector3(fx, fy, fz).multiplyScalar(METRES_PER_NEWTON.contact));
    this.centre.copy(this.bodies[1]?.position ?? this.tip).lerp(this.tip, 0.5);
  }

  #point(arrow, from, vector) {
    const length = vector.length();
    arrow.visible = length > 0.01;
    if (!arrow.visible) return;
    arrow.position.copy(from);
    arrow.setDirection(vector.normalize());
    arrow.setLength(length, Math.min(0.05, 0.4 * length), Math.min(0.03, 0.25 * length));
  }
}
