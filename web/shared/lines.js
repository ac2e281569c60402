// A line of segments in three dimensions.

import { LineMaterial, LineSegments2, LineSegmentsGeometry } from "vendor";
import { lastNotAbove } from "./decode.js";

/** Segments that are seen from their own time on; `ends` are six columns: both ends of each. */
export class Lines {
  constructor(since, ends, colour, width, colours = null) {
    this.since = since;
    const count = since.length, points = new Float32Array(6 * count);
    for (let i = 0; i < count; i++) for (let c = 0; c < 6; c++) points[6 * i + c] = ends[c][i];
    this.object = segments(points, colour, width, colours);
    this.show(-1);
  }

  show(time) {
    const seen = lastNotAbove(this.since, time + 1e-3) + 1;
    this.object.geometry.instanceCount = seen;
    this.object.visible = seen > 0;
  }
}

/** An object that draws segments, six numbers each; with colours of their own, six numbers each, where there are some. */
export function segments(points, colour, width, colours = null) {
  const geometry = new LineSegmentsGeometry();
  if (points.length) geometry.setPositions(points);
  if (colours) geometry.setColors(colours);
  const object = new LineSegments2(geometry, new LineMaterial({ color: colours ? 0xffffff : colour, linewidth: width, vertexColors: Boolean(colours) }));
  object.frustumCulled = false;
  object.visible = points.length > 0;
  return object;
}
