// How hard the tip could push, each way: a skin around the tip, as far away as the push is great.

import { BufferAttribute, BufferGeometry, Color, DoubleSide, Group, LineBasicMaterial, LineSegments, Mesh, MeshLambertMaterial, WireframeGeometry } from "vendor";
import { columns, lastNotAbove } from "../shared/decode.js";

export const METRES_PER_NEWTON = 0.03;
const COLOUR = new Color(0x7a3fb0);

export class Pushes {
  static async of({ moments, pushes, directions, faces }) {
    const [[times], sizes] = await Promise.all([columns(moments), columns(pushes)]);
    return new Pushes(times, sizes, directions, faces);
  }

  /** `sizes` has the push (N) along each direction over the times; `directions` has three numbers each. */
  constructor(times, sizes, directions, faces) {
    Object.assign(this, { times, sizes, directions });
    this.skin = new BufferGeometry();
    this.skin.setAttribute("position", new BufferAttribute(new Float32Array(directions.length), 3));
    this.skin.setIndex(faces);
    this.object = new Group();
    this.object.visible = false;
    this.mesh = new Mesh(this.skin, new MeshLambertMaterial({
      color: COLOUR, transparent: true, opacity: 0.22, side: DoubleSide, depthWrite: false, flatShading: true,
    }));
    this.edges = new LineSegments(new BufferGeometry(), new LineBasicMaterial({ color: COLOUR, transparent: true, opacity: 0.5 }));
    this.object.add(this.mesh, this.edges);
  }

  /** The pushes at a time, N. */
  at(time) {
    const { times, sizes } = this;
    const i = Math.max(0, Math.min(lastNotAbove(times, time), times.length - 1)), j = Math.min(i + 1, times.length - 1);
    const part = j > i ? Math.min(1, Math.max(0, (time - times[i]) / (times[j] - times[i]))) : 0;
    return sizes.map((column) => column[i] + part * (column[j] - column[i]));
  }

  /** Put it around the tip at a time; nothing is done while it is not seen. */
  show(time, tip) {
    if (!this.object.visible) return;
    this.object.position.copy(tip);
    const places = this.skin.attributes.position;
    this.at(time).forEach((push, k) => {
      const [x, y, z] = this.directions.slice(3 * k, 3 * k + 3).map((part) => part * push * METRES_PER_NEWTON);
      places.setXYZ(k, x, y, z);
    });
    places.needsUpdate = true;
    this.skin.computeBoundingSphere();
    this.edges.geometry.dispose();
    this.edges.geometry = new WireframeGeometry(this.skin);
  }
}
