// Words in the picture that would lie on each other step aside, or where there is no room are left out.

import { Vector3 } from "vendor";

const STEPS = [[0, 0], [0, 1.1], [0, -1.1], [0.55, 0], [-0.55, 0], [0.55, 1.1], [-0.55, 1.1], [0.55, -1.1], [-0.55, -1.1], [0, 2.2], [0, -2.2]]; // of their own size
const AT_HOME = 0.2; // of its height by which a label must be free to come back to its place: none flickers
const NUMBER = [60, 24]; // px, of the contact force's number beside the tip

const apart = (a, b) => a[0] + a[2] <= b[0] || b[0] + b[2] <= a[0] || a[1] + a[3] <= b[1] || b[1] + b[3] <= a[1];

/** Where the number of the contact force stands: left, bottom, width, height in parts of the distance. */
export function numberAt(tip, camera, pixels) {
  const seen = tip.clone().applyMatrix4(camera.matrixWorldInverse), part = (2 * Math.tan((camera.fov * Math.PI) / 360)) / pixels;
  return [-seen.x / seen.z - 1.1 * NUMBER[0] * part, -seen.y / seen.z + 0.3 * NUMBER[1] * part, ...NUMBER.map((size) => size * part)];
}

/** Where a place is seen, in parts of the distance. */
function seenAt(place, camera) {
  const { x, y, z } = place.applyMatrix4(camera.matrixWorldInverse);
  return [-x / z, -y / z];
}

/** How far a label may step aside: one of an axis stays within half of its axis, as it would name another one there. */
function reachOf(label, camera) {
  if (!label.userData.axis) return Infinity;
  const [[a, b], [c, d]] = label.userData.axis.map((end) => seenAt(label.parent.localToWorld(end.clone()), camera));
  return Math.hypot(c - a, d - b) / 2;
}

/** Put labels (the most important first) where they lie neither on each other nor on what is `taken`. */
export function spread(labels, camera, taken) {
  const place = new Vector3();
  for (const label of labels) {
    label.getWorldPosition(place).applyMatrix4(camera.matrixWorldInverse);
    if (place.z >= 0) continue; // behind who looks
    const [x, y] = [-place.x / place.z, -place.y / place.z], { x: w, y: h } = label.scale;
    const box = ([right, up], more = 0) => [x + (right - 0.5) * w - more, y + (up - 0.5) * h - more, w + 2 * more, h + 2 * more];
    const reach = reachOf(label, camera), near = ([right, up]) => Math.hypot(right * w, up * h) <= reach;
    const free = (step, more) => near(step) && taken.every((other) => apart(box(step, more), other));
    const before = label.userData.step ?? STEPS[0];
    const step = free(STEPS[0], before === STEPS[0] ? 0 : AT_HOME * h) ? STEPS[0] : [before, ...STEPS.slice(1)].find((one) => one !== STEPS[0] && free(one));
    label.material.opacity = step ? 1 : 0;
    if (!step) continue;
    label.userData.step = step;
    label.center.set(0.5 - step[0], 0.5 - step[1]);
    taken.push(box(step));
  }
}
