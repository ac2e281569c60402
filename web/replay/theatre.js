// The canvas: all flights side by side under cameras that move together, or as ghosts in one picture.

import { AmbientLight, Color, DirectionalLight, HemisphereLight, PerspectiveCamera, Scene, Vector3, WebGLRenderer } from "three";
import { OrbitControls } from "three/addons/controls/OrbitControls.js";

export class Theatre {
  constructor(holder, stages) {
    this.stages = stages;
    this.holder = holder;
    this.canvas = holder.querySelector("canvas");
    this.renderer = new WebGLRenderer({ canvas: this.canvas, antialias: true, powerPreference: "low-power" });
    this.scenes = stages.map((stage) => this.#scene(stage));
    this.together = this.#scene();
    this.camera = new PerspectiveCamera(38, 16 / 9, 0.05, 60);
    this.camera.up.set(0, 0, 1);
    const { target, position } = stages[0].flight.camera;
    this.camera.position.set(...position);
    this.controls = new OrbitControls(this.camera, this.canvas);
    this.controls.target.set(...target);
    this.controls.addEventListener("change", () => { this.stale = true; });
    this.controls.update();
    this.home = [this.camera.position.clone(), this.controls.target.clone()];
    this.ghosts = false;
    this.follow = false;
    this.chosen = null;
    this.stale = true;
    new ResizeObserver(() => { this.stale = true; }).observe(this.canvas);
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
    this.camera.position.copy(this.home[0]);
    this.controls.target.copy(this.home[1]);
    this.controls.update();
    this.before = null;
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

  /** Fewer points for a machine that cannot keep up, all of them again when it rests. */
  coarsen(coarse) {
    if (coarse === !!this.coarse) return;
    this.coarse = coarse;
    this.stale = true;
  }

  /** Cells of the canvas: [flight, left, top, width, height] as parts of 1. */
  cells() {
    if (this.ghosts) return [[this.seen[0], 0, 0, 1, 1]];
    const count = this.seen.length, narrow = this.canvas.clientWidth < 620;
    const across = count === 1 ? 1 : narrow && count > 2 ? 1 : Math.min(2, count), rows = Math.ceil(count / across);
    return this.seen.map((i, k) => [i, (k % across) / across, Math.floor(k / across) / rows, 1 / across, 1 / rows]);
  }

  draw() {
    this.controls.update();
    if (!this.stale) return;
    this.stale = false;
    const { clientWidth: width, clientHeight: height } = this.canvas;
    if (!width || !height) return;
    const ratio = this.coarse ? 0.6 : Math.min(window.devicePixelRatio || 1, 2);
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
