// The canvas: all flights side by side under cameras that move together, or as ghosts in one picture.

import { AmbientLight, Color, DirectionalLight, HemisphereLight, PerspectiveCamera, Raycaster, Scene, Spherical, Vector2, Vector3, WebGLRenderer } from "three";
import { OrbitControls } from "three/addons/controls/OrbitControls.js";

/** Whether a processor draws, for which smooth edges cost too much. */
function drawnBySoftware() {
  const context = document.createElement("canvas").getContext("webgl");
  const known = context?.getExtension("WEBGL_debug_renderer_info");
  const name = known ? context.getParameter(known.UNMASKED_RENDERER_WEBGL) : "";
  context?.getExtension("WEBGL_lose_context")?.loseContext();
  return /swiftshader|llvmpipe|software/i.test(name);
}

const X = new Vector3(1, 0, 0);

export class Theatre {
  constructor(holder, stages) {
    this.holder = holder;
    this.canvas = holder.querySelector("canvas");
    this.renderer = new WebGLRenderer({ canvas: this.canvas, antialias: !drawnBySoftware(), powerPreference: "low-power" });
    this.camera = new PerspectiveCamera(38, 16 / 9, 0.05, 60);
    this.camera.up.set(0, 0, 1);
    this.controls = new OrbitControls(this.camera, this.canvas);
    this.controls.addEventListener("change", () => { this.stale = true; });
    this.follow = false;
    this.detail = 1;
    this.perform(stages);
    new ResizeObserver(() => { this.stale = true; }).observe(this.canvas);
  }

  /** Show these flights from now on; the camera stays where it is unless it is to go home. */
  perform(stages, home = true) {
    for (const stage of this.stages ?? []) stage.dispose();
    this.stages = stages;
    this.scenes = stages.map((stage) => this.#scene(stage));
    this.together = this.#scene();
    const { target, position } = stages[0].scene.camera;
    this.home = [new Vector3(...position), new Vector3(...target)];
    this.arrange(false, null);
    if (home) this.reset();
  }

  #scene(stage) {
    const scene = new Scene();
    const sun = new DirectionalLight(0xffffff, 1.4);
    sun.position.set(-3, -4, 6);
    scene.add(new HemisphereLight(0xffffff, 0xb0aca4, 1.6), new AmbientLight(0xffffff, 0.7), sun);
    if (stage) scene.add(stage.root);
    return scene;
  }

  /** The flights that are seen: all, or the chosen one. */
  get seen() {
    return this.chosen === null ? this.stages.map((_, i) => i) : [this.chosen];
  }

  arrange(ghosts, chosen) {
    this.ghosts = ghosts && this.stages.length > 1;
    this.chosen = chosen;
    this.stages.forEach((stage, i) => {
      (this.ghosts ? this.together : this.scenes[i]).add(stage.root);
      stage.root.visible = this.seen.includes(i);
      stage.asGhost(this.ghosts, i === this.seen[0]);
    });
    this.stale = true;
  }

  showArrows(shown) {
    for (const stage of this.stages) stage.arrows.visible = shown;
    this.stale = true;
  }

  reset() {
    const [, , , w, h] = this.cells()[0], aspect = (w * this.canvas.clientWidth) / (h * this.canvas.clientHeight || 1);
    const away = Math.min(1.8, Math.max(1, 1.5 / (aspect || 1.5))); // a narrow cell is seen from farther away
    this.controls.target.copy(this.home[1]);
    this.camera.position.copy(this.home[0]).sub(this.home[1]).multiplyScalar(away).add(this.home[1]);
    this.controls.update();
    this.before = null;
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
    for (const i of this.seen) this.stages[i].at(Math.min(time, this.stages[i].end));
    const centre = this.stages[this.seen[0]].centre;
    if (this.follow && this.before) {
      const moved = new Vector3().subVectors(centre, this.before);
      this.camera.position.add(moved);
      this.controls.target.add(moved);
    }
    this.before = centre.clone();
    this.stale = true;
  }

  /** Fewer points for a machine that cannot keep up: so many of them along each side, of 1. */
  coarsen(detail) {
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
    const caster = new Raycaster();
    caster.setFromCamera(cell.place, this.camera);
    return { flight: cell.flight, caster };
  }

  draw() {
    this.controls.update();
    if (!this.stale) return;
    this.stale = false;
    const { clientWidth: width, clientHeight: height } = this.canvas;
    if (!width || !height) return;
    const ratio = this.detail < 1 ? this.detail : Math.min(window.devicePixelRatio || 1, 2);
    if (this.renderer.getPixelRatio() !== ratio) this.renderer.setPixelRatio(ratio);
    this.renderer.setSize(width, height, false);
    const dark = matchMedia("(prefers-color-scheme: dark)").matches;
    this.renderer.setScissorTest(true);
    for (const [i, left, top, w, h] of this.cells()) {
      const scene = this.ghosts ? this.together : this.scenes[i];
      scene.background = new Color(dark ? 0x1d2024 : 0xeef1f4);
      this.stages[i].floor.color.set(dark ? 0x3a3f46 : 0xd9dce0);
      const box = [left * width, (1 - top - h) * height, w * width - 1, h * height - 1];
      this.renderer.setViewport(...box);
      this.renderer.setScissor(...box);
      this.camera.aspect = box[2] / box[3];
      this.camera.updateProjectionMatrix();
      this.renderer.render(scene, this.camera);
    }
  }
}
