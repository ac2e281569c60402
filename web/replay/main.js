// Shows the flights of a page again.

import { choice, element, ofThePage, toggle } from "../shared/elements.js";
import { SceneView } from "../shared/scene_view.js";
import { Clock } from "./clock.js";
import { eventsOf, Marks } from "../shared/events.js";
import { Plots } from "./plots.js";
import { RecordedFigure } from "./recorded_figure.js";

const SPEEDS = [0.25, 0.5, 1, 2, 4, 8];
const CURSOR_PERIOD = 0.06; // s between two moves of the plots' cursor: they cost more than the scene

async function start(root, { flights, speed = 1 }) {
  const many = flights.length > 1;
  const figures = await Promise.all(flights.map((flight) => RecordedFigure.of(flight, !many)));
  const clock = new Clock(Math.max(...figures.map((figure) => figure.end)));
  clock.speed = speed;
  const picture = element("div", { class: "picture", "data-count": flights.length }, element("canvas", {
    tabindex: "0", role: "img",
    "aria-label": "The flight in three dimensions. Drag to turn, wheel to zoom, right button to move.",
  }));
  const names = element("div", { class: "names" });
  picture.append(names);
  const bar = element("div", { class: "bar", role: "group", "aria-label": "Replay" });
  const plotting = element("div", { class: "plots" });
  root.append(picture, bar, plotting);

  let sceneView = null;
  try {
    sceneView = new SceneView(picture, figures);
  } catch (error) {
    picture.replaceChildren(element("p", { class: "sorry" }, `No three-dimensional picture here: ${error.message}`));
  }
  const plots = await Plots.of(plotting, flights, clock);

  const marks = new Marks(clock);
  const state = { ghosts: false, chosen: null, axes: true };
  const arrange = () => {
    sceneView?.arrange(state.ghosts, state.chosen);
    sceneView?.showAxes(state.axes);
    sceneView?.at(clock.time);
    const seen = state.chosen === null ? flights : [flights[state.chosen]];
    marks.show(eventsOf(seen));
    plots.show(state.chosen);
    label();
  };
  const label = () => {
    const cells = sceneView?.cells() ?? [];
    const legend = (i) => {
      const { name, colour, mark } = flights[i];
      const dot = element("span", { class: "dot", style: { background: colour } });
      return [dot, mark ? `${name} (${mark})` : name];
    };
    names.replaceChildren(...(state.ghosts && sceneView
      ? [element("div", { class: "name", style: { left: "0", top: "0" } }, ...sceneView.seen.flatMap((i) => [...legend(i), " "]))]
      : cells.map(([i, left, top]) =>
        element("div", { class: "name", style: { left: `${100 * left}%`, top: `${100 * top}%` } }, ...legend(i)))));
  };

  const play = element("button", { type: "button", class: "play", "aria-label": "Play" }, "▶");
  play.addEventListener("click", () => clock.play());
  const slider = element("input", { type: "range", min: 0, max: clock.end, step: 0.01, value: 0, "aria-label": "Time" });
  slider.addEventListener("input", () => clock.set(Number(slider.value)));
  const readout = element("output", { class: "time" }, "0.00 s");
  bar.append(play, element("div", { class: "timeline" }, slider, marks.element), readout,
    choice("Speed", [...new Set([...SPEEDS, speed])].sort((a, b) => a - b).map((times) => [times, `${times}×`]), speed, (value) => { clock.speed = Number(value); }));
  if (many) {
    bar.append(
      choice("Flights", [["all", "all flights"], ...flights.map(({ name }, i) => [i, name])], "all", (value) => {
        state.chosen = value === "all" ? null : Number(value);
        arrange();
      }),
      toggle("ghosts", "All flights in one picture", false, (on) => { state.ghosts = on; arrange(); }));
  }
  const pushed = figures.some((figure) => figure.events.length);
  bar.append(
    toggle("follow", "The camera goes along", false, (on) => { if (sceneView) sceneView.follow = on; }),
    toggle("arrows", `Thrusts (green, 2 cm/N), the contact force (12 cm/N, from blue, 0 N, to red, 5 N)${pushed ? ", pushes (blue, 12 cm/N)" : ""}`, true, (on) => sceneView?.showArrows(on)),
    toggle("axes", "Numbers on the floor, whose cells are 0.5 m; axes x, y, z of the world; those of path and contact, where the flight believes its surface", true, (on) => { state.axes = on; sceneView?.showAxes(on); }));
  if (figures.some((figure) => figure.pushes)) {
    bar.append(toggle("pushes", "How hard the tip could push, each way: at rest in its posture then, leaning by up to 20° (violet, 3 cm/N)", false, (on) => {
      for (const figure of figures) figure.showPushes(on);
      sceneView?.at(clock.time);
    }));
  }
  const home = element("button", { type: "button", title: "The first view, the whole time" }, "reset");
  home.addEventListener("click", () => { sceneView?.reset(); plots.zoom(0, clock.end); });
  bar.append(home);

  clock.addEventListener("state", () => {
    play.textContent = clock.playing ? "❚❚" : "▶";
    play.setAttribute("aria-label", clock.playing ? "Pause" : "Play");
    if (!clock.playing) sceneView?.adapt(60, false);
  });
  // On paper a still stands for what moves.
  const still = element("img", { class: "still", alt: "The flight in three dimensions" });
  picture.append(still);
  addEventListener("beforeprint", () => {
    if (!sceneView) return;
    sceneView.render();
    still.src = sceneView.canvas.toDataURL();
    still.alt = `The flight in three dimensions, ${clock.time.toFixed(2)} s after take-off`;
  });
  let marked = 0;
  clock.addEventListener("time", () => {
    sceneView?.at(clock.time);
    slider.value = clock.time;
    readout.textContent = `${clock.time.toFixed(2)} s`;
    const now = performance.now() / 1000;
    if (!clock.playing || now - marked > CURSOR_PERIOD) { marked = now; plots.cursor(); }
  });
  picture.addEventListener("keydown", (event) => {
    if (!ofThePage(event)) return;
    const act = {
      " ": () => clock.play(),
      ArrowRight: () => clock.set(clock.time + (event.shiftKey ? 1 : 0.1)),
      ArrowLeft: () => clock.set(clock.time - (event.shiftKey ? 1 : 0.1)),
      Home: () => clock.set(0),
      End: () => clock.set(clock.end),
    }[event.key];
    if (act) { event.preventDefault(); act(); }
  });

  arrange();
  new ResizeObserver(label).observe(picture);
  let last = performance.now(), frames = 0, since = last, before = 0;
  const tick = (now) => {
    clock.pass((now - last) / 1000);
    last = now;
    sceneView?.draw();
    frames++;
    if (now - since > 1000) {
      const rate = (1000 * frames) / (now - since);
      root.dataset.framesPerSecond = ((1000 * ((sceneView?.drawn ?? 0) - before)) / (now - since)).toFixed(1);
      before = sceneView?.drawn ?? 0;
      sceneView?.adapt(rate, clock.playing);
      [frames, since] = [0, now];
    }
    requestAnimationFrame(tick);
  };
  requestAnimationFrame(tick);
  root.dataset.ready = "true";
  window.skylimbReplay = { clock, sceneView, plots, state };
}

const root = document.getElementById("replay");
start(root, JSON.parse(document.getElementById("replay-data").textContent)).catch((error) => {
  root.append(element("p", { class: "sorry" }, `The replay cannot be shown: ${error.message}`));
  console.error(error);
});
