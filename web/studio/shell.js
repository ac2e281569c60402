// What stands around the picture: status, seats, notes, tabs, second controller, scores, keep.

import { button, choice, element, withArrows } from "../shared/elements.js";

const TOLD = 8000; // ms for which a note is seen
const find = (id) => document.getElementById(id);

const ENDED = "came to its end"; // the verdict on a flight that wasn't lost

/** What became of the flights, in a line. */
function verdictOf(verdicts, figures, missed) {
  if (verdicts.every((text) => text === ENDED)) return missed ? "Over: not done as commanded" : "Over: came to its end";
  if (verdicts.length === 1) return `Lost: ${verdicts[0]}`;
  return verdicts.map((text, i) => `${figures[i]?.scene.name ?? i}: ${text}`).join("; ");
}

export class Shell {
  constructor(studio) {
    this.studio = studio;
    this.online = this.busy = false;
    this.seats = { drives: false, others: 0 };
    this.#buildTabs();
    find("take-over").addEventListener("click", () => studio.say("take over"));
    find("help-open").addEventListener("click", () => this.help());
    addEventListener("keydown", (event) => {
      if (event.key === "?" && !event.target.matches("input, select")) this.help();
    });
    find("lost").append(button("Fly again with the last good gains", { class: "main" }, () => studio.say("recover")));
    this.first = choice("Controller", [], "", () => this.#choose());
    this.second = choice("Second controller", [], "", () => this.#choose());
    find("controllers").append(this.first, element("span", { class: "soft" }, "beside"), this.second);
    this.name = element("input", { type: "text", id: "keep-name", maxlength: 80, placeholder: "a name (optional)" });
    find("panel-keep").append(
      element("p", {}, "Writes what was flown so far: the experiment with every poke and change, the preset, the log, the report. Flown again, it gives the same numbers to the last bit."),
      element("div", { class: "row" }, element("label", { for: "keep-name" }, "Name"), this.name,
        button("Keep", { class: "main" }, () => studio.say("keep", { name: this.name.value.trim() }))),
      this.keptList = element("ul", { class: "kept", "aria-live": "polite" }));
    find("panel-scores").append(
      element("div", { class: "row" }, button("Score now", { class: "main" }, () => studio.say("scores")),
        this.scoredOf = element("span", { class: "soft", role: "status" })),
      this.scores = element("div", { class: "scroll" }));
    this.forgetScores();
  }

  /** Scores of a flight that is not the one that flies now would be taken for its own. */
  forgetScores() {
    this.scored = this.verdict = undefined;
    this.scoredOf.textContent = "of the flight so far";
    this.scores.replaceChildren();
  }

  #buildTabs() {
    const tabs = [...document.querySelectorAll('[role="tab"]')];
    this.choose = (chosen) => {
      for (const tab of tabs) {
        const on = tab === chosen;
        tab.setAttribute("aria-selected", on);
        tab.tabIndex = on ? 0 : -1;
        find(tab.getAttribute("aria-controls")).hidden = !on;
      }
    };
    for (const tab of tabs) tab.addEventListener("click", () => this.choose(tab));
    withArrows(tabs, this.choose);
  }

  /** Bring a panel to the front. */
  open(panel) {
    this.choose(document.querySelector(`[aria-controls="panel-${panel}"]`));
  }

  /** The controllers that may be flown. */
  offer(controllers) {
    const options = (none) => [...(none ? [["", "nobody"]] : []), ...controllers.map((name) => [name, name.split("/").pop()])]
      .map(([value, text]) => element("option", { value }, text));
    this.first.replaceChildren(...options(false));
    this.second.replaceChildren(...options(true));
  }

  /** Show what flies, and whether it was lost. */
  apply({ controllers, verdict, here }) {
    if (this.scored !== undefined && this.scored !== here) this.forgetScores();
    this.first.value = controllers[0];
    this.second.value = controllers[1] ?? "";
    find("lost").hidden = !verdict.some((text) => text !== ENDED);
    this.status();
  }

  #choose() {
    const names = [this.first.value, this.second.value].filter(Boolean);
    this.studio.say("controllers", { names: [...new Set(names)] });
  }

  status() {
    const { state, looking, pending, answers } = this.studio;
    const lost = state.verdict?.some((text) => text !== ENDED);
    const missed = this.verdict && this.verdict.here === state.here ? this.verdict.words : "";
    const [kind, text] = !this.online ? ["off", this.ended ?? "No connection; trying again"]
      : !answers ? ["over", "Taking off"]
        : this.busy ? ["over", "Busy"]
          : looking !== null ? ["paused", pending.length ? `Looking back; changes that go along: ${pending.length}` : "Looking back"]
            : state.over ? [lost || missed ? "bad" : "over", verdictOf(state.verdict ?? [], this.studio.figures, missed)]
              : state.paused ? ["paused", "Paused"] : ["flying", "Flying"];
    const status = find("status");
    const title = missed && state.over ? missed : text;
    if (status.textContent !== text || status.dataset.kind !== kind || status.title !== title) {
      status.textContent = text;
      status.title = title;
      status.dataset.kind = kind;
    }
    const { drives, others } = this.seats;
    document.body.dataset.drives = String(drives);
    for (const part of document.querySelectorAll(".drives")) part.inert = !drives;
    const { may_drive: may = true, watch } = this.seats;
    find("seat").textContent = drives ? (others ? `You drive, ${others} watching` : "") : "You watch";
    find("take-over").hidden = drives || !this.online || !may;
    find("watch").hidden = !watch;
    find("watch-link").textContent = watch ?? "";
  }

  /** Tell something for a while; what is told again is counted. */
  note(text, kind = "", lasting = TOLD) {
    const again = [...find("notes").children].find(({ dataset }) => dataset.text === text);
    const made = again ?? element("p", { class: `note ${kind}`, dataset: { text, count: 0 } }, text);
    if (++made.dataset.count > 1) made.textContent = `${text} (${made.dataset.count} times)`;
    if (!again) find("notes").append(made);
    while (find("notes").children.length > 4) find("notes").firstChild.remove();
    clearTimeout(Number(made.dataset.timer));
    made.dataset.timer = setTimeout(() => made.remove(), lasting);
  }

  kept({ folder, commands }) {
    const flown = (command) => {
      const line = element("code", {}, command);
      return [line, button("Copy", { "aria-label": "Copy the command line" }, async ({ target }) => {
        try {
          await navigator.clipboard.writeText(command);
          target.textContent = "Copied";
        } catch {
          getSelection().selectAllChildren(line);
        }
      })];
    };
    this.keptList.prepend(element("li", {}, element("strong", {}, folder), ...commands.flatMap(flown)));
    this.note(`Kept in ${folder}`);
  }

  showScores({ flights, groups, here, until, over, missed }) {
    this.scored = here; // a flight that goes back is another branch
    const words = Object.entries(missed).map(([name, what]) => `${name} was not done as commanded: ${what.join("; ")}`);
    this.verdict = over ? { here, words: words.join(". ") } : undefined;
    this.status();
    this.scoredOf.textContent = `of the flight until ${until.toFixed(1)} s`;
    if (!groups.length) return this.scores.replaceChildren(element("p", { class: "soft" }, "Nothing to score yet: scores are of the sliding period."));
    const head = (text) => element("th", { scope: "col" }, text), cell = (text) => element("td", {}, text);
    const row = ({ label, unit, values }) => element("tr", {}, element("th", { scope: "row" }, label),
      cell(unit), ...values.map((value) => cell(value || "–")));
    this.scores.replaceChildren(...words.map((text) => element("p", { class: "missed" }, text)), element("table", {},
      element("thead", {}, element("tr", {}, head("Score"), head("Unit"), ...flights.map(head))),
      ...groups.map(({ title, rows }) => element("tbody", {},
        element("tr", {}, element("th", { scope: "rowgroup", colspan: 2 + flights.length, class: "heading" }, title)), ...rows.map(row)))));
  }

  /** What can be done, and with which keys. */
  help() {
    this.studio.hints.done("help");
    const dialog = find("help");
    if (!dialog.open) dialog.showModal();
  }

  /** The studio has ended. */
  farewell({ folder }) {
    const text = folder ? `The studio has ended. The flight is kept in ${folder}` : "The studio has ended.";
    this.ended = text;
    this.status();
  }

  /** An exception in the user's controller: where and what; null once it is mended. */
  controllerError(error) {
    const box = find("trouble");
    box.hidden = !error;
    if (!error) return box.replaceChildren();
    const where = error.file ? `${error.file}${error.line ? `, line ${error.line}` : ""}` : "";
    box.replaceChildren(element("strong", {}, "The controller failed. "), where ? element("code", {}, where) : "",
      element("pre", {}, error.text), element("p", { class: "soft" }, error.flying ? `${error.flying} ` : "", "Save the file and it is flown anew."));
  }
}
