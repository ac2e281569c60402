// The line to the studio: it comes back by itself, and the page keeps its name over a reload.

const FRAME = 1, HISTORY = 2;
const WAITS = [0.3, 0.6, 1, 2]; // s between attempts
const SILENT = 3000, DEAD = 12000; // ms without a message, of which 50 a second come: the line is lost; another is tried

/** The page's name. It is stored while no page is shown: who duplicates a tab copies what is stored, and would drive as well. */
function pageName() {
  const key = "skylimb-page", name = sessionStorage.getItem(key)
    ?? Array.from(crypto.getRandomValues(new Uint8Array(12)), (b) => b.toString(16).padStart(2, "0")).join("");
  const forget = () => sessionStorage.removeItem(key);
  forget();
  addEventListener("pagehide", () => sessionStorage.setItem(key, name));
  addEventListener("pageshow", forget);
  return name;
}

export class Connection extends EventTarget {
  constructor() {
    super();
    this.open = false;
    this.attempts = 0;
    this.name = pageName();
    this.connect();
    setInterval(() => this.#listen(), 1000);
  }

  connect() {
    const query = new URLSearchParams(location.search);
    query.set("page", this.name);
    this.socket = new WebSocket(`${location.origin.replace(/^http/, "ws")}/socket?${query}`);
    this.socket.binaryType = "arraybuffer";
    this.heard = performance.now();
    this.socket.addEventListener("open", () => {
      this.attempts = 0;
      this.#hear();
    });
    this.socket.addEventListener("message", ({ data }) => {
      this.#hear();
      if (typeof data === "string") {
        const { event, ...content } = JSON.parse(data);
        this.#tell(event, content);
      } else this.#numbers(data);
    });
    this.socket.addEventListener("close", () => {
      this.#lose();
      setTimeout(() => this.connect(), 1000 * WAITS[Math.min(this.attempts++, WAITS.length - 1)]);
    });
  }

  #hear() {
    this.heard = performance.now();
    if (this.open) return;
    this.open = true;
    this.#tell("line", { open: true });
  }

  #lose() {
    this.open = false;
    this.#tell("line", { open: false });
  }

  /** A network that breaks does not close a socket: it only falls silent. */
  #listen() {
    const silent = performance.now() - this.heard;
    if (this.open && silent > SILENT) this.#lose();
    if (this.socket.readyState === WebSocket.OPEN && silent > DEAD) this.socket.close();
  }

  #numbers(data) {
    const [kind, number, scene, width] = new Uint32Array(data, 0, 4);
    const values = new Float32Array(data, 16), frames = [];
    for (let at = 0; width && at + width <= values.length; at += width) frames.push(values.subarray(at, at + width));
    if (kind === FRAME) this.say("got", { frame: number });
    this.#tell(kind === HISTORY ? "history" : "frame", { scene, frames });
  }

  #tell(event, content) {
    this.dispatchEvent(Object.assign(new Event(event), { content }));
  }

  on(event, act) {
    this.addEventListener(event, ({ content }) => act(content));
  }

  /** Send a command; false where there is no line. */
  say(what, content = {}) {
    if (!this.open || this.socket.readyState !== WebSocket.OPEN) return false;
    this.socket.send(JSON.stringify({ do: what, ...content }));
    return true;
  }
}

/** A function that is called at most every `period` ms, the last time with the newest arguments. */
export function seldom(period, act) {
  let waiting = null, then = -Infinity, timer = null;
  const run = () => {
    timer = null;
    then = performance.now();
    const newest = waiting;
    waiting = null;
    act(...newest);
  };
  const call = (...values) => {
    waiting = values;
    if (timer === null) timer = setTimeout(run, Math.max(0, period - (performance.now() - then)));
  };
  call.cancel = () => { clearTimeout(timer); timer = null; waiting = null; };
  return call;
}
