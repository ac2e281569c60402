// What one flight looks like at a moment: its shapes on their bodies, and the arrows of thrusts and forces.

import {
  BoxGeometry, BufferAttribute, BufferGeometry, CapsuleGeometry, Color, CylinderGeometry,
  DoubleSide, FrontSide, Group, Mesh, MeshLambertMaterial, PlaneGeometry, Quaternion, SphereGeometry, SRGBColorSpace, Vector3,
} from "vendor";
import { aim, makeArrow } from "./arrows.js";
import { believedFrame } from "./landmarks.js";

export const METRES_PER_NEWTON = { thrust: 0.02, contact: 0.12 };
const THRUST = 0x2e7d32, PUSH = 0x1f6fd6;
const HARD = 5; // N from which the colour of a force changes no more

/** The colour of a contact force: blue for none, over green and yellow, to red. */
export const colourOf = (newtons, colour = new Color()) => colour.setHSL(0.62 * (1 - Math.min(1, newtons / HARD)), 0.85, 0.45);

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

export const quaternionOf = ([w, x, y, z]) => new Quaternion(x, y, z, w);

export class Figure {
  /** `scene` has shapes, the number of bodies, and rotors; `meshes` are decoded. */
  constructor(scene, meshes) {
    this.scene = scene;
    this.root = new Group();
    this.materials = []; // of what moves: [material, its opacity, its colour]
    this.still = [];
    this.floor = new MeshLambertMaterial(); // replaced by that of the scene's floor, where it has one
    this.bodies = Array.from({ length: scene.bodies }, () => new Group());
    this.root.add(...this.bodies);
    for (const shape of scene.shapes) this.#addShape(shape, meshes);
    this.ghost = false;
    this.arrows = new Group();
    this.thrustArrows = scene.rotors.map(() => this.#addArrow(THRUST, 0.004));
    this.contactArrow = this.#addArrow(PUSH, 0.009);
    this.frame = scene.frame ? believedFrame(scene.frame) : new Group();
    this.still.push(this.frame);
    this.root.add(this.arrows, this.frame);
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
    object.userData.body = shape.body;
    object.castShadow = alpha === 1 && shape.kind !== "plane";
    object.receiveShadow = true;
    this.bodies[shape.body].add(object);
    if (shape.kind === "plane" && shape.body === 0) this.floor = material;
    if (shape.body === 0) this.still.push(object); else this.materials.push([material, alpha, material.color.clone()]);
  }

  /** An arrow for a push on the robot. */
  addPush() { return this.#addArrow(PUSH, 0.009); }

  #addArrow(colour, radius) {
    const arrow = makeArrow(colour, radius);
    this.arrows.add(arrow);
    return arrow;
  }

  /** Let an arrow show a force (N, W) at a point of a body, in its axes; the body 0 is the world. */
  showPush(arrow, { body, point, force }) {
    const { position, quaternion } = this.bodies[body];
    const from = new Vector3(...point).applyQuaternion(quaternion).add(position);
    aim(arrow, from, new Vector3(...force).multiplyScalar(METRES_PER_NEWTON.contact));
  }

  /** As one of several: in its controller's colour; in the same picture the later ones are see-through. */
  asOneOf(several, ghost, first) {
    const tint = new Color(this.scene.colour);
    for (const [material, alpha, colour] of this.materials) {
      material.color.copy(colour);
      if (several) material.color.lerp(tint, 0.65);
      material.opacity = ghost && !first ? 0.45 * alpha : alpha;
      material.transparent = material.opacity < 1;
    }
    for (const object of this.still) object.visible = !ghost || first;
    this.ghost = ghost && !first;
  }

  /** Free what the graphics card holds. */
  dispose() {
    this.root.traverse((object) => {
      object.geometry?.dispose();
      object.material?.dispose();
    });
  }

  /** Put the bodies where they are (7 numbers each: x y z, qw qx qy qz) and the arrows on them. */
  show(poses, thrusts, contact) {
    this.bodies.forEach((body, b) => {
      if (b === 0) return;
      const at = 7 * b;
      body.position.set(poses[at], poses[at + 1], poses[at + 2]);
      body.quaternion.set(poses[at + 4], poses[at + 5], poses[at + 6], poses[at + 3]).normalize();
    });
    this.scene.rotors.forEach((rotor, r) => {
      const body = this.bodies[rotor.body];
      const from = new Vector3(...rotor.position).applyQuaternion(body.quaternion).add(body.position);
      const along = new Vector3(...rotor.direction).applyQuaternion(body.quaternion);
      aim(this.thrustArrows[r], from, along.multiplyScalar(thrusts[r] * METRES_PER_NEWTON.thrust));
    });
    const [tx, ty, tz, fx, fy, fz] = contact;
    this.tip.set(tx, ty, tz);
    this.force = Math.hypot(fx, fy, fz);
    aim(this.contactArrow, this.tip, new Vector3(fx, fy, fz).multiplyScalar(METRES_PER_NEWTON.contact));
    colourOf(this.force, this.contactArrow.material.color);
    this.centre.copy(this.bodies[1]?.position ?? this.tip).lerp(this.tip, 0.5);
  }
}
