// What a first visit is told: a few lines, one after the other, above the picture.

import { button, element } from "../shared/elements.js";

const KEPT = "skylimb-hints"; // that they were read, over visits
const HINTS = [ // where, what is told, what is done then
  ["#picture", "Push the robot: hold Shift and drag on one of its links. The arrow is the force.", "poke"],
  ["#panel-gains", "Change a gain: it acts at once. Undo (Ctrl-Z) takes back whatever you did.", "set"],
  ["#timeline", "Drag on the line of time to look back; Go on from here flies on from there, as a branch.", "look"],
  ["#help-open", "The question mark, or its key, shows all that can be done.", "help"],
];

export class Hints {
  constructor(holder) {
    this.holder = holder;
    this.words = element("p", { role: "status" });
    this.next = button("Next", { class: "main" }, () => this.#show(this.at + 1));
    holder.append(this.words, this.next, button("Got it", { title: "Not shown again" }, () => this.#show(HINTS.length)));
  }

  /** Tell them to whoever may do what they say, once. */
  begin(drives) {
    if (drives && this.at === undefined && !localStorage.getItem(KEPT)) this.#show(0);
  }

  /** What a line asks for was done: the next one may be told. */
  done(act) {
    if (!this.holder.hidden && HINTS[this.at][2] === act) this.#show(this.at + 1);
  }

  #show(at) {
    document.querySelector(".hinted")?.classList.remove("hinted");
    const [place, words] = HINTS[this.at = at] ?? [];
    this.holder.hidden = !place;
    if (!place) return localStorage.setItem(KEPT, "read");
    document.querySelector(place).classList.add("hinted");
    this.words.textContent = `${at + 1} of ${HINTS.length}. ${words}`;
    this.next.hidden = at === HINTS.length - 1;
  }
}
