// The canvas: all flights side by side under cameras that move together, or as ghosts in one picture.

import { AmbientLight, Color, DirectionalLight, HemisphereLight, OrbitControls, PerspectiveCamera, Raycaster, Scene, Spherical, Vector2, Vector3, WebGLRenderer } from "vendor";
import { numberAt, spread } from "./labels.js";
import { floorGrid } from "./landmarks.js";

/** Whether a processor draws, for which smooth edges cost too much. */
function drawnBySoftware() {
  const context = document.createElement("canvas").getContext("webgl");
  const known = context?.getExtension("WEBGL_debug_renderer_info");
  const name = known ? context.getParameter(known.UNMASKED_RENDERER_WEBGL) : "";
  context?.getExtension("WEBGL_lose_context")?.loseContext();
  return /swiftshader|llvmpipe|software/i.test(name);
}

const X = new Vector3(1, 0, 0), UP = new Vector3(0, 0, 1);
const MARGIN = 0.22; // m around the middle of a link that has to be seen
const SUN = new Vector3(-1.5, -2, 4); // where its light comes from
const SHADED = 1.8; // m around the flight in which there are shadows
const SHARE = 0.8; // of the time that pictures drawn by a processor may take: the flight needs it, too
const LONGEST_REST = 50; // ms
const DETAILS = [1, 0.65, 0.45]; // points along each side, of 1

export class SceneView {
  constructor(holder, figures) {
    this.holder = holder;
    this.canvas = holder.querySelector("canvas");
    this.bySoftware = drawnBySoftware();
    this.renderer = new WebGLRenderer({ canvas: this.canvas, antialias: !this.bySoftware, powerPreference: "low-power" });
    this.renderer.shadowMap.enabled = true;
    this.fence = null; // tells when the picture that was begun last is drawn
    this.begun = this.resting = this.cost = 0; // ms: when it was begun; until when no other is; how long it took
    this.camera = new PerspectiveCamera(38, 16 / 9, 0.05, 60);
    this.camera.up.set(0, 0, 1);
    this.controls = new OrbitControls(this.camera, this.canvas);
    this.controls.addEventListener("change", () => { this.stale = true; });
    this.follow = false;
    this.detail = 1;
    this.drawn = 0;
    this.show(figures);
    new ResizeObserver(() => { this.stale = true; }).observe(this.canvas);
  }

  /** Show these flights from now on; the camera stays where it is unless it is to go home. */
  show(figures, home = true) {
    for (const figure of this.figures ?? []) figure.dispose();
    this.figures = figures;
    this.scenes = figures.map((figure) => this.#scene(figure));
    this.together = this.#scene();
    const { target, position } = figures[0].scene.camera;
    this.home = [new Vector3(...position), new Vector3(...target)];
    this.arrange(false, null);
    if (home) this.reset();
  }

  #scene(figure) {
    const scene = new Scene();
    const sun = new DirectionalLight(0xffffff, 1.8), grid = floorGrid();
    sun.castShadow = true;
    sun.shadow.mapSize.set(1024, 1024);
    sun.shadow.normalBias = 0.01;
    Object.assign(sun.shadow.camera, { left: -SHADED, right: SHADED, bottom: -SHADED, top: SHADED, near: 0.5, far: 9 });
    scene.add(new HemisphereLight(0xffffff, 0xb0aca4, 1.4), new AmbientLight(0xffffff, 0.5), grid, sun, sun.target);
    if (figure) scene.add(figure.root);
    return Object.assign(scene, { sun, grid });
  }

  /** The flights that are seen: all, or the chosen one. */
  get seen() {
    return this.chosen === null ? this.figures.map((_, i) => i) : [this.chosen];
  }

  arrange(ghosts, chosen) {
    this.ghosts = ghosts && this.figures.length > 1;
    this.chosen = chosen;
    this.figures.forEach((figure, i) => {
      (this.ghosts ? this.together : this.scenes[i]).add(figure.root);
      figure.root.visible = this.seen.includes(i);
      figure.asOneOf(this.figures.length > 1, this.ghosts, i === this.seen[0]);
    });
    this.stale = true;
  }

  showArrows(shown) {
    for (const figure of this.figures) figure.arrows.visible = shown;
    this.stale = true;
  }

  /** Show the grid's numbers, and the axes of the world and of the path, or not. */
  showAxes(shown) {
    for (const scene of [...this.scenes, this.together]) for (const one of scene.grid.children.slice(1)) one.visible = shown;
    for (const figure of this.figures) figure.frame.visible = shown && !figure.ghost;
    this.stale = true;
  }

  /** The first view, with the whole robot in it. */
  reset() {
    this.#home();
    this.unfitted = true;
    if (this.figures[0].centre.lengthSq()) this.#fit();
  }

  #home() {
    const [, , , w, h] = this.cells()[0], aspect = (w * this.canvas.clientWidth) / (h * this.canvas.clientHeight || 1);
    const away = Math.min(1.8, Math.max(1, 1.5 / (aspect || 1.5))); // a narrow cell is seen from farther away
    this.controls.target.copy(this.home[1]);
    this.camera.position.copy(this.home[0]).sub(this.home[1]).multiplyScalar(away).add(this.home[1]);
    this.controls.update();
    this.before = null;
  }

  /** Go away until every link is seen. */
  #fit() {
    this.unfitted = false;
    const { camera, controls } = this, figure = this.figures[this.seen[0]];
    camera.updateMatrixWorld();
    const inverse = camera.matrixWorld.clone().invert(), up = Math.tan((camera.fov * Math.PI) / 360);
    const [, , , w, h] = this.cells()[0], aspect = (w * this.canvas.clientWidth) / (h * this.canvas.clientHeight || 1);
    let farther = 0;
    for (const body of figure.bodies.slice(1)) {
      if (!body.children.length || body.position.z < -10 || figure.surfaceObjects?.includes(body.children[0])) continue;
      const { x, y, z } = body.position.clone().applyMatrix4(inverse);
      farther = Math.max(farther, (Math.abs(y) + MARGIN) / up + z, (Math.abs(x) + MARGIN) / (up * aspect) + z);
    }
    const arm = new Vector3().subVectors(camera.position, controls.target);
    camera.position.addScaledVector(arm.normalize(), farther);
    controls.update();
    this.stale = true;
  }

  /** Look from a side: "home", "front" (along the normal), "side", "top", or "pen" from near by. */
  view(name) {
    if (name === "home") return this.reset();
    const figure = this.figures[this.seen[0]], { normal } = figure.scene.surface ?? { normal: [-1, 0, 0] };
    const out = new Vector3(...normal), side = new Vector3().crossVectors(UP, out).normalize();
    const [target, arm] = {
      front: [figure.centre, out.clone().addScaledVector(UP, 0.15)],
      side: [figure.centre, side.clone().addScaledVector(UP, 0.1)],
      top: [figure.centre, UP.clone().addScaledVector(out, 0.02)],
      pen: [figure.tip, out.clone().multiplyScalar(0.5).add(side).addScaledVector(UP, 0.35)],
    }[name];
    this.controls.target.copy(target);
    this.camera.position.copy(target).addScaledVector(arm.normalize(), name === "pen" ? 0.7 : 1.5);
    this.controls.update();
    if (name !== "pen") this.#fit();
    this.stale = true;
  }

  /** Where a place is seen in the cell of a flight: left and top as parts of the canvas; null where it is not. */
  placeOf(flight, place) {
    const cell = this.cells().find(([i]) => i === flight);
    if (!cell) return null;
    const [, left, top, w, h] = cell;
    this.camera.aspect = (w * this.canvas.clientWidth) / (h * this.canvas.clientHeight || 1);
    this.camera.updateProjectionMatrix();
    this.camera.updateMatrixWorld();
    const { x, y, z } = place.clone().project(this.camera);
    return z < 1 && Math.abs(x) < 1 && Math.abs(y) < 1 ? [left + (w * (x + 1)) / 2, top + (h * (1 - y)) / 2] : null;
  }

  /** Turn the view about its centre, rad. */
  turn(sideways, upward) {
    const arm = new Spherical().setFromVector3(new Vector3().subVectors(this.camera.position, this.controls.target).applyAxisAngle(X, -Math.PI / 2));
    arm.theta += sideways;
    arm.phi = Math.min(Math.PI - 0.05, Math.max(0.05, arm.phi - upward));
    this.camera.position.setFromSpherical(arm).applyAxisAngle(X, Math.PI / 2).add(this.controls.target);
    this.stale = true;
  }

  /** Come nearer (below 1) or go away. */
  zoom(factor) {
    this.camera.position.sub(this.controls.target).multiplyScalar(factor).add(this.controls.target);
    this.stale = true;
  }

  at(time) {
    for (const i of this.seen) this.figures[i].at(Math.min(time, this.figures[i].end));
    const centre = this.figures[this.seen[0]].centre;
    if (this.follow && this.before) {
      const moved = new Vector3().subVectors(centre, this.before);
      this.camera.position.add(moved);
      this.controls.target.add(moved);
    }
    this.before = centre.clone();
    if (this.unfitted && this.before.lengthSq()) this.#fit();
    this.stale = true;
  }

  /** Draw as finely as the machine can.
   *
   * rate: times a second that the page gets its turn; moving: whether there is anything to keep up with. */
  adapt(rate, moving) {
    const now = DETAILS.indexOf(this.detail);
    const [slow, quick] = this.bySoftware ? [this.cost > 40, this.cost < 12] : [rate < 24, rate > 50];
    const step = !moving ? 0 : slow ? now + 1 : quick ? now - 1 : now;
    const detail = DETAILS[Math.max(0, Math.min(DETAILS.length - 1, step))];
    if (detail === this.detail) return;
    this.detail = detail;
    this.stale = true;
  }

  /** Cells of the canvas: [flight, left, top, width, height] as parts of 1. */
  cells() {
    if (this.ghosts) return [[this.seen[0], 0, 0, 1, 1]];
    const count = this.seen.length, narrow = this.canvas.clientWidth < 620;
    const across = count === 1 ? 1 : narrow && count > 2 ? 1 : Math.min(2, count), rows = Math.ceil(count / across);
    return this.seen.map((i, k) => [i, (k % across) / across, Math.floor(k / across) / rows, 1 / across, 1 / rows]);
  }

  /** The flight and the place in its cell (-1 .. 1) under a pointer. */
  cellAt(event) {
    const box = this.canvas.getBoundingClientRect();
    const x = (event.clientX - box.left) / box.width, y = (event.clientY - box.top) / box.height;
    const cell = this.cells().find(([, left, top, w, h]) => x >= left && x <= left + w && y >= top && y <= top + h);
    if (!cell) return null;
    const [flight, left, top, w, h] = cell;
    const aspect = (w * box.width) / (h * box.height);
    return { flight, aspect, place: new Vector2((2 * (x - left)) / w - 1, 1 - (2 * (y - top)) / h) };
  }

  /** A ray into the cell under a pointer. */
  rayAt(event) {
    const cell = this.cellAt(event);
    if (!cell) return null;
    this.camera.aspect = cell.aspect;
    this.camera.updateProjectionMatrix();
    this.camera.updateMatrixWorld();
    this.figures[cell.flight].root.updateMatrixWorld(); // the last picture may be an older one
    const caster = new Raycaster();
    caster.setFromCamera(cell.place, this.camera);
    return { flight: cell.flight, caster };
  }

  /** Whether another picture may be begun: where a processor draws, it rests in between. */
  #rested() {
    if (!this.bySoftware) return true;
    const now = performance.now(), gl = this.renderer.getContext();
    if (this.fence) {
      if (gl.clientWaitSync(this.fence, 0, 0) === gl.TIMEOUT_EXPIRED) return false;
      gl.deleteSync(this.fence);
      this.fence = null;
      this.cost = now - this.begun;
      this.resting = now + Math.min(LONGEST_REST, this.cost * (1 / SHARE - 1));
    }
    return now >= this.resting;
  }

  /** Draw where something has changed and a picture is due. */
  draw() {
    this.controls.update();
    if (this.stale && this.#rested()) this.render();
  }

  /** Keep the words of a cell apart: those of the contact first, those of the floor last. */
  #spreadLabels(scene, flights, pixels) {
    const figures = flights.map((i) => this.figures[i]), groups = [...figures.map(({ frame }) => frame), ...scene.grid.children.slice(1).reverse()];
    const labels = groups.filter(({ visible }) => visible).flatMap((group) => (group.isSprite ? group : group.getObjectsByProperty("isSprite", true)));
    spread(labels, this.camera, figures.filter(({ force }) => force > 0.05).map(({ tip }) => numberAt(tip, this.camera, pixels)));
  }

  /** Draw now. */
  render() {
    this.stale = false;
    const { clientWidth: width, clientHeight: height } = this.canvas;
    if (!width || !height) return;
    const ratio = this.detail < 1 ? this.detail : Math.min(window.devicePixelRatio || 1, 2);
    if (this.renderer.getPixelRatio() !== ratio) this.renderer.setPixelRatio(ratio);
    this.renderer.setSize(width, height, false);
    const dark = matchMedia("(prefers-color-scheme: dark)").matches;
    this.renderer.setScissorTest(true);
    for (const [i, left, top, w, h] of this.cells()) {
      const scene = this.ghosts ? this.together : this.scenes[i], { sun } = scene;
      sun.target.position.copy(this.figures[i].centre);
      sun.position.copy(SUN).add(sun.target.position);
      scene.background = new Color(dark ? 0x1d2024 : 0xeef1f4);
      this.figures[i].floor.color.set(dark ? 0x3a3f46 : 0xd9dce0);
      const box = [left * width, (1 - top - h) * height, w * width - 1, h * height - 1];
      this.renderer.setViewport(...box);
      this.renderer.setScissor(...box);
      this.camera.aspect = box[2] / box[3];
      this.camera.updateProjectionMatrix();
      this.camera.updateMatrixWorld();
      this.#spreadLabels(scene, this.ghosts ? this.seen : [i], box[3]);
      this.renderer.render(scene, this.camera);
    }
    this.drawn++;
    if (this.bySoftware) {
      const gl = this.renderer.getContext();
      this.begun = performance.now();
      this.fence = gl.fenceSync(gl.SYNC_GPU_COMMANDS_COMPLETE, 0);
      gl.flush();
    }
  }
}
