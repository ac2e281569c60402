// What tells where and how large: the floor's grid with its numbers, and frames with named axes.

import { CanvasTexture, GridHelper, Group, SRGBColorSpace, Sprite, SpriteMaterial, Vector3 } from "vendor";
import { aim, makeArrow } from "./arrows.js";
import { segments } from "./lines.js";

export const CELL = 0.5; // m between two lines of the grid
const REACH = 3; // m from its middle to its border
const AXES = ["#c62828", "#2e7d32", "#1565c0"];
const PLAIN = "#4a5058", BELIEVED = "#8e24aa";
const HEIGHT = 0.042; // of a label, at a distance of 1
const PIXELS = 40; // of its texture

/** Words that are as large from near and from far. */
function label(words, colour, place) {
  const canvas = document.createElement("canvas"), font = `600 ${0.72 * PIXELS}px system-ui, sans-serif`;
  const pen = canvas.getContext("2d");
  pen.font = font;
  Object.assign(canvas, { width: Math.ceil(pen.measureText(words).width) + 12, height: PIXELS });
  Object.assign(pen, { font, textBaseline: "middle", lineWidth: 5, lineJoin: "round", strokeStyle: "rgb(255 255 255 / .85)", fillStyle: colour });
  pen.strokeText(words, 6, PIXELS / 2);
  pen.fillText(words, 6, PIXELS / 2);
  const map = Object.assign(new CanvasTexture(canvas), { colorSpace: SRGBColorSpace });
  const sprite = new Sprite(new SpriteMaterial({ map, depthTest: false, sizeAttenuation: false }));
  sprite.scale.set((HEIGHT * canvas.width) / PIXELS, HEIGHT, 1);
  sprite.position.copy(place);
  sprite.renderOrder = 2;
  return sprite;
}

/** The floor: a grid, numbers each metre along x and y, and the axes of the world. */
export function floorGrid() {
  const floor = new Group(), grid = new GridHelper(2 * REACH, (2 * REACH) / CELL, 0x70757d, 0x70757d).rotateX(Math.PI / 2);
  Object.assign(grid.material, { transparent: true, opacity: 0.5 });
  floor.add(grid);
  floor.position.z = 0.01;
  for (let metres = 1 - REACH; metres < REACH; metres++) {
    if (metres === 0) continue;
    const words = `${metres < 0 ? "−" : ""}${Math.abs(metres)} m`;
    floor.add(label(words, PLAIN, new Vector3(metres, 0, 0)), label(words, PLAIN, new Vector3(0, metres, 0)));
  }
  return floor.add(triad(["x", "y", "z"].map((name, i) => ({ name, vector: [+(i === 0), +(i === 1), +(i === 2)] })), 0.3));
}

/** Arrows along named axes; one that is `inward` leads to the origin. */
function triad(axes, length) {
  const group = new Group();
  axes.forEach(({ name, vector, inward }, i) => {
    const arrow = makeArrow(AXES[i], 0.006), along = new Vector3(...vector).multiplyScalar(length), from = inward ? along.clone().negate() : new Vector3();
    aim(arrow, from, along);
    const axis = [from, along.clone().add(from)], place = inward ? from.clone().multiplyScalar(1.2) : along.multiplyScalar(1.2);
    const named = label(name, AXES[i], place);
    named.userData.axis = axis;
    group.add(arrow, named);
  });
  return group;
}

/** The frame in which a flight believes surface and path: axes by their names, and the border of that surface. */
export function believedFrame({ origin, axes, size: [width, height] }) {
  const frame = new Group(), [, u, v] = axes.map(({ vector }) => new Vector3(...vector));
  const corners = [[-1, -1], [1, -1], [1, 1], [-1, 1]].map(([a, b]) => u.clone().multiplyScalar((a * width) / 2).addScaledVector(v, (b * height) / 2));
  const ends = corners.flatMap((corner, k) => [...corner.toArray(), ...corners[(k + 1) % 4].toArray()]);
  frame.add(segments(new Float32Array(ends), BELIEVED, 2.5), label("believed surface", BELIEVED, corners[0].clone().lerp(corners[1], 0.5)), triad(axes, 0.16));
  frame.position.set(...origin);
  return frame;
}
