// The studio's page: a live flight to see and to touch.

import { button, choice, element, ofThePage, toggle, withArrows } from "../shared/elements.js";
import { SceneView } from "../shared/scene_view.js";
import { LiveFigure } from "./live_figure.js";
import { SurfaceTool } from "./surface_tool.js";
import { Charts } from "./charts.js";
import { Connection } from "./connection.js";
import { Controls } from "./controls.js";
import { Past } from "./past.js";
import { DrawingTool } from "./drawing_tool.js";
import { Hints } from "./hints.js";
import { Poke } from "./poke.js";
import { Shell } from "./shell.js";
import { Timeline } from "./timeline.js";
import { Transport } from "./transport.js";

const CHART_PERIOD = 100; // ms between two drawings of the charts; longer where they take long
const PAGE_PERIOD = 45; // ms between two changes of the page where a processor draws it
const MODES = [
  ["look", "Look", "Drag to turn, wheel to zoom, right button to move"],
  ["poke", "Poke", "Drag on a link to push it, or hold an arrow key; Shift-drag does it in every mode"],
  ["surface", "Surface", "Drag the surface"],
  ["draw", "Draw", "Draw on the surface"],
];
const OF_A_FLIGHT = ["poke", "surface", "step"]; // what is done to a flight that goes on
const OF_NOW = ["poke", "surface", "back", "step"]; // what is done to the flight at its latest moment, which must be seen
const LASTING = 60000; // ms for which a note is seen that tells of a loss
const find = (id) => document.getElementById(id);

/** What can be pushed: every body of the robot, and where the middle of its shapes is. */
function linksOf({ body_names: names, shapes }) {
  return names.map((name, body) => ({ name, body })).filter(({ name, body }) => body > 0 && name !== "surface")
    .map((link) => {
      const places = shapes.filter(({ body }) => body === link.body).map(({ position }) => position);
      const middle = [0, 1, 2].map((c) => places.reduce((sum, place) => sum + place[c] / places.length, 0));
      return { ...link, middle: places.length ? middle : [0, 0, 0] };
    });
}

class Studio {
  constructor() {
    this.figures = [];
    this.number = -1;
    this.state = { paused: false, over: false, speed: 1, scene: null, version: 0, verdict: [], undo: null, redo: null };
    this.looking = null; // time of the past that is looked at
    this.pending = []; // changes that go along with the branch that begins there
    this.mode = "look";
    this.past = new Past();
    this.shell = new Shell(this);
    this.hints = new Hints(find("hints"));
    this.transport = new Transport(this, find("transport"));
    this.timeline = new Timeline(this, find("timeline"));
    this.charts = new Charts(find("charts"), this.past);
    this.controls = new Controls(this, find("panel-gains"));
    this.poke = new Poke(this, find("panel-poke"));
    this.surfaceTool = new SurfaceTool(this, find("panel-surface"));
    this.drawingTool = new DrawingTool(this, find("panel-draw"));
    this.tools = { poke: this.poke, surface: this.surfaceTool, draw: this.drawingTool };
    find("stage").addEventListener("scroll", () => { this.chartsDue = true; }, { passive: true });
    addEventListener("scroll", () => { this.chartsDue = true; }, { passive: true });
    this.#buildPictureBar();
    this.#listenToPicture();
    this.line = new Connection();
    this.#listenToLine();
    this.#run();
  }

  /** Why something cannot be done now; empty where it can. */
  hindrance(what) {
    if (!this.shell.seats.drives && what !== "take over") return "You watch. Take over to change something.";
    if (!this.line.open) return "No connection: nothing is done until it is back.";
    if (this.state.over && OF_A_FLIGHT.includes(what)) return "The flight is over; take off again (R).";
    if (this.looking !== null && OF_NOW.includes(what)) return "You look back. First go on from there (Enter) or come back to now (Escape).";
    return "";
  }

  /** Whether something can be done; says why not. */
  may(what) {
    const why = this.hindrance(what);
    if (why) this.note(why, "bad");
    return !why;
  }

  /** Have something done to the flight that this page shows; only who drives may. */
  say(what, content) {
    if (what === "release" ? this.hindrance(what) : !this.may(what)) return false;
    this.hints.done(what);
    return this.line.say(what, { seen: this.state.version, ...content });
  }

  /** Change a key: in flight, or where the past is looked at from the beginning of the branch that goes on there. */
  change(one, acts) {
    if (this.looking === null || acts !== "in flight") return this.say("set", one);
    const same = (other) => ["key", "flight", "entry"].every((part) => other[part] === one[part]);
    this.pending = [...this.pending.filter((other) => !same(other)), one];
    this.#apply();
  }

  /** Show what flies, once the scene is there that it is told of. */
  #apply() {
    const { state } = this;
    this.transport.apply(state);
    if (state.scene !== this.number) return this.shell.status();
    for (const part of [this.controls, this.surfaceTool, this.timeline, this.charts, this.shell]) part.apply(state);
    this.#allow();
    this.#judge();
  }

  /** Disable what acts on a flight that is not seen, or goes on no more. */
  #allow() {
    this.poke.allow(this.hindrance("poke"));
    this.surfaceTool.allow(this.hindrance("surface"));
  }

  /** Have a flight that is over scored, once: the verdict belongs to its end. */
  #judge() {
    const { over, here } = this.state;
    if (!over) this.judged = null;
    else if (this.shell.seats.drives && this.line.open && this.judged !== here) {
      this.judged = here;
      this.say("scores");
    }
  }

  note(text, kind, lasting) {
    this.shell.note(text, kind, lasting);
  }

  /** Say what is wrong with a field, also where it is not seen. */
  refuse(name, field) {
    field.reportValidity();
    this.note(`${name} = ${field.value || "?"}: ${field.validationMessage}`, "bad");
  }

  readForce(text) {
    find("force").textContent = text;
    find("force").hidden = !text;
  }

  stale() {
    if (this.sceneView) this.sceneView.stale = true;
  }

  #listenToLine() {
    const { line, shell } = this;
    line.on("line", ({ open }) => { shell.online = open; if (open) shell.ended = undefined; shell.status(); this.#allow(); });
    line.on("hello", (hello) => {
      if (this.answers && this.answers !== hello.studio) this.note("Another studio answers: the flight that was here is gone.", "bad", LASTING);
      this.answers = hello.studio;
      this.past.clear();
      this.early = null;
      this.awaited = hello.number;
      this.number = -1; // until it can be shown, also where it is the scene that was here before
      this.#begin(hello).catch((error) => { this.note(`The flight cannot be shown: ${error.message}`, "bad"); console.error(error); });
    });
    line.on("state", (state) => { this.state = state; this.#apply(); });
    line.on("seats", (seats) => { shell.seats = seats; this.hints.begin(seats.drives); this.#apply(); });
    line.on("frame", ({ scene, frames }) => {
      this.#busy(false);
      if (scene !== this.number) { // it cannot be shown yet
        if (this.early?.scene === scene) this.early.frames.push(...frames);
        return;
      }
      for (const frame of frames) this.#remember(frame);
      this.fresh = true;
    });
    line.on("history", (history) => { this.early = history; this.#recall(); });
    line.on("refused", ({ text }) => this.note(text, "bad"));
    line.on("alive", ({ busy }) => this.#busy(busy));
    line.on("trouble", ({ text }) => this.note(text, "bad", LASTING));
    line.on("error", (error) => shell.controllerError(error));
    line.on("report", ({ folder }) => this.note(`The report in ${folder} is drawn`));
    line.on("restarted", ({ why }) => { shell.controllerError(null); this.note(why ? `Took off again: ${why}` : "Took off again"); });
    line.on("kept", (kept) => { shell.kept(kept); });
    line.on("pace", (pace) => this.transport.pace(pace));
    line.on("farewell", (last) => shell.farewell(last));
    line.on("scores", (scores) => shell.showScores(scores));
  }

  /** Whether the flight does something that takes long, and says nothing meanwhile. */
  #busy(busy) {
    if (busy === this.shell.busy) return;
    this.shell.busy = busy;
    this.shell.status();
  }

  async #begin({ scene, controls, controllers, number }) {
    const { flights, layout } = scene, names = flights.map(({ name }) => name).join();
    const figures = await Promise.all(flights.map((flight, i) => LiveFigure.of(flight, layout.flights[i], flights.length === 1)));
    if (number !== this.awaited) return; // the flight has taken off again meanwhile
    this.#show(figures, names !== this.names);
    this.look(null);
    Object.assign(this, { figures, number, names, judged: null });
    this.past.clear();
    this.charts.begin(flights, layout, scene.period);
    this.controls.show(controls, flights.map(({ name }) => name));
    this.poke.begin(linksOf(flights[0]));
    this.surfaceTool.begin(controls, flights[0].frame.axes);
    this.drawingTool.begin(controls, flights, controllers);
    this.shell.offer(controllers);
    this.shell.forgetScores();
    this.timeline.begin(scene.lasts, layout.flights[0].touching[0]);
    find("experiment").textContent = scene.experiment;
    find("ghosts").hidden = flights.length < 2;
    this.#apply();
    this.#recall();
    document.body.dataset.ready = "true";
  }

  #show(figures, home) {
    try {
      if (this.sceneView) this.sceneView.show(figures, home); else this.sceneView = new SceneView(find("picture"), figures);
    } catch (error) {
      this.note(`No three-dimensional picture here: ${error.message}`, "bad");
      return;
    }
    this.#arrange();
  }

  #arrange() {
    this.sceneView.arrange(find("ghosts").getAttribute("aria-pressed") === "true", null);
    for (const [id, show] of [["arrows", "showArrows"], ["axes", "showAxes"]]) this.sceneView[show](find(id).getAttribute("aria-pressed") === "true");
    const legend = ({ scene: { name, colour } }) => [element("span", { class: "dot", style: { background: colour } }), name];
    find("names").replaceChildren(...this.sceneView.cells().map(([i, left, top]) => element("div", { class: "name", style: { left: `${100 * left}%`, top: `${100 * top}%` } },
      ...(this.sceneView.ghosts ? this.sceneView.figures.flatMap((figure) => [...legend(figure), " "]) : legend(this.sceneView.figures[i])))));
  }

  /** The past that the server has sent, once there is somebody to show it. */
  #recall() {
    if (this.early?.scene !== this.number) return;
    this.past.clear();
    for (const figure of this.figures) figure.clear();
    for (const frame of this.early.frames) this.#remember(frame);
    for (const figure of this.figures) figure.last = null;
    this.early = null;
    this.fresh = true;
  }

  #remember(frame) {
    if (this.past.end > frame[0]) for (const figure of this.figures) figure.last = null; // the flight has gone back
    this.past.add(frame);
    for (const figure of this.figures) figure.draw(frame);
  }

  /** The contact force as a number, beside its arrow. */
  #readForces() {
    while (find("felt").children.length < this.figures.length) find("felt").append(element("span"));
    [...find("felt").children].forEach((label, i) => {
      const figure = this.figures[i], place = figure?.force > 0.05 && this.sceneView?.placeOf(i, figure.tip);
      label.hidden = !place;
      if (!place) return;
      label.textContent = `${figure.force.toFixed(1)} N`;
      Object.assign(label.style, { left: `${100 * place[0]}%`, top: `${100 * place[1]}%` });
    });
  }

  /** Look at a time of the past; null for now. */
  look(time) {
    if (time === null && this.pending.length) {
      this.note(`Not taken along: ${this.pending.map(({ key }) => key).join(", ")}. Go on from here would have.`, "bad");
      this.pending = [];
      this.#apply();
    }
    this.looking = this.charts.looking = time;
    this.#allow();
    if (time !== null) this.hints.done("look");
    this.fresh = this.chartsDue = true;
    this.shell.status();
  }

  #buildPictureBar() {
    const modes = MODES.map(([name, text, title], i) => button(text, { role: "radio", "aria-checked": name === this.mode, tabindex: name === this.mode ? 0 : -1, title: `${title} (${i + 1})`, dataset: { mode: name } }, () => this.setMode(name)));
    find("modes").append(...modes);
    withArrows(modes, ({ dataset }) => this.setMode(dataset.mode));
    find("views").append(
      toggle("Follow", "The camera goes along", false, (on) => { if (this.sceneView) this.sceneView.follow = on; }),
      Object.assign(toggle("Arrows", "Thrusts (green, 2 cm/N); contact force (12 cm/N) and the pen's line, from blue (0 N) to red (5 N)", true, () => this.#arrange()), { id: "arrows" }),
      Object.assign(toggle("Axes", "Numbers on the floor, whose cells are 0.5 m; axes x, y, z of the world; those of path and contact, where the flight believes its surface", true, () => this.#arrange()), { id: "axes" }),
      Object.assign(toggle("Ghosts", "Both flights in one picture", false, () => this.#arrange()), { id: "ghosts" }),
      choice("View", [["", "View"], ["home", "whole robot"], ["front", "front"], ["side", "side"], ["top", "top"], ["pen", "pen"]], "", (name) => {
        this.sceneView?.view(name);
        find("views").lastChild.value = "";
      }));
    find("ghosts").hidden = true;
  }

  setMode(mode) {
    this.mode = mode;
    for (const one of find("modes").children) {
      one.setAttribute("aria-checked", String(one.dataset.mode === mode));
      one.tabIndex = one.dataset.mode === mode ? 0 : -1;
    }
    find("picture").dataset.mode = mode;
    if (mode !== "look") this.shell.open(mode);
  }

  #listenToPicture() {
    const canvas = find("picture").querySelector("canvas");
    let tool = null;
    canvas.addEventListener("pointerdown", (event) => {
      if (event.button !== 0 || !this.sceneView || this.looking !== null || !this.shell.seats.drives) return;
      const wanted = event.shiftKey ? this.poke : this.tools[this.mode];
      if (!wanted?.grab(event)) return;
      tool = wanted;
      this.sceneView.controls.enabled = false;
      canvas.setPointerCapture(event.pointerId);
      event.stopImmediatePropagation();
    }, { capture: true });
    canvas.addEventListener("pointermove", (event) => tool?.move(event));
    const end = () => {
      tool?.release();
      tool = null;
      if (this.sceneView) this.sceneView.controls.enabled = true;
    };
    for (const kind of ["pointerup", "pointercancel", "lostpointercapture"]) canvas.addEventListener(kind, end);
    canvas.addEventListener("keydown", (event) => {
      if (!ofThePage(event)) return;
      if (this.mode === "poke" && this.poke.key(event)) return event.preventDefault();
      const act = {
        " ": () => this.transport.toggle(), ".": () => this.say("step"), r: () => this.say("restart"), u: () => this.say("undo"),
        1: () => this.setMode("look"), 2: () => this.setMode("poke"), 3: () => this.setMode("surface"), 4: () => this.setMode("draw"),
        ArrowLeft: () => this.sceneView?.turn(-0.1, 0), ArrowRight: () => this.sceneView?.turn(0.1, 0),
        ArrowUp: () => this.sceneView?.turn(0, 0.1), ArrowDown: () => this.sceneView?.turn(0, -0.1),
        "+": () => this.sceneView?.zoom(0.9), "-": () => this.sceneView?.zoom(1.1),
      }[event.key.length === 1 ? event.key.toLowerCase() : event.key]; // Caps Lock makes no other key of it
      if (act) { event.preventDefault(); act(); }
    });
    // A browser drops what is no part of a number without a word: 2,5 would become 25, 1/2 12, and be flown.
    addEventListener("beforeinput", (event) => {
      if (event.target.type !== "number") return;
      const [foreign] = event.data?.trim().match(/[^-+.0-9eE]/u) ?? [];
      if (!foreign || (foreign === "," && (0.5).toLocaleString().includes(","))) return;
      event.preventDefault();
      if (event.data === ",") document.execCommand("insertText", false, "."); // what is pasted stays out as a whole
      this.note(foreign === "," ? "A number has a point, not a comma: 2.5" : `A number has no ${foreign}: 2.5 or 1e-3`, "bad");
    });
    let typing = null; // a field with words that were not taken yet: undo is its own there
    addEventListener("input", ({ target }) => { typing = target.matches("input:not([type=range])") ? target : null; });
    addEventListener("change", () => { typing = null; });
    addEventListener("keydown", (event) => {
      if (event.key === "Enter") typing = null; // also where the field is as it was, and nothing changes
      if (event.key.toLowerCase() !== "z" || !(event.ctrlKey || event.metaKey) || (typing && event.target === typing)) return;
      event.preventDefault();
      this.say(event.shiftKey ? "redo" : "undo");
    });
    canvas.addEventListener("keyup", (event) => this.poke.keyUp(event));
    canvas.addEventListener("blur", () => this.poke.release());
    new ResizeObserver(() => { if (this.sceneView) this.#arrange(); }).observe(canvas);
  }

  #run() {
    let frames = 0, since = performance.now(), drawn = 0, taken = 0, before = 0, shown = 0;
    const tick = (now) => {
      requestAnimationFrame(tick); // first: a mistake in one picture does not end them all
      const frame = this.looking !== null ? this.past.at(this.looking) : this.past.frames[this.past.frames.length - 1];
      if (frame && this.fresh && (!this.sceneView?.bySoftware || now - shown > PAGE_PERIOD)) {
        this.fresh = false;
        shown = now;
        for (const figure of this.figures) figure.take(frame);
        this.sceneView?.at(frame[0]);
        this.poke.follow();
        this.timeline.show(this.past.end);
        this.#readForces();
        this.transport.frame(frame[0], frame[1], !this.state.paused && !this.state.over);
        this.chartsDue = true;
      }
      this.sceneView?.draw();
      if (this.chartsDue && now - drawn > Math.max(CHART_PERIOD, 5 * taken)) {
        this.chartsDue = false;
        drawn = now;
        this.charts.update();
        taken = performance.now() - now;
      }
      frames++;
      if (now - since > 1000) {
        const rate = (1000 * frames) / (now - since);
        document.body.dataset.framesPerSecond = ((1000 * ((this.sceneView?.drawn ?? 0) - before)) / (now - since)).toFixed(1);
        before = this.sceneView?.drawn ?? 0;
        if (!document.hidden) this.sceneView?.adapt(rate, !this.state.paused && !this.state.over);
        [frames, since] = [0, now];
      }
    };
    requestAnimationFrame(tick);
  }
}

window.skylimbStudio = new Studio();
