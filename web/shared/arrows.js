// Arrows with a body, so that they are seen from afar and on every screen.

import { CylinderGeometry, Group, Mesh, MeshLambertMaterial, Vector3 } from "vendor";

const Y = new Vector3(0, 1, 0);
const LEAST = 0.01; // m below which nothing is seen

/** An arrow, unseen until it is pointed somewhere; its head is some radii large, m. */
export function makeArrow(colour, radius) {
  const material = new MeshLambertMaterial({ color: colour }), arrow = new Group();
  arrow.add(new Mesh(new CylinderGeometry(radius, radius, 1, 10).translate(0, 0.5, 0), material), new Mesh(new CylinderGeometry(0, 2.7 * radius, 1, 14), material));
  return Object.assign(arrow, { material, radius, reach: 0, visible: false });
}

/** Let an arrow lead from a place along a vector, m. */
export function aim(arrow, from, vector) {
  const { children: [shaft, head], radius } = arrow, length = vector.length(), tip = Math.min(6.5 * radius, 0.5 * length);
  arrow.reach = length;
  arrow.visible = length > LEAST;
  if (!arrow.visible) return;
  arrow.position.copy(from);
  arrow.quaternion.setFromUnitVectors(Y, vector.clone().normalize());
  shaft.scale.y = length - tip;
  head.scale.y = tip;
  head.position.y = length - tip / 2;
}

