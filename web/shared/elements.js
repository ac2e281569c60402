// Elements of a page, made in one call.

/** An element with attributes and children; `style` and `dataset` take objects, as a strict page allows no style texts. */
export function element(name, attributes = {}, ...children) {
  const made = document.createElement(name);
  if (name === "input" || name === "select") made.setAttribute("autocomplete", "off"); // else a reload fills in what another field had
  for (const [key, value] of Object.entries(attributes)) {
    if (value === undefined || value === null) continue;
    if (key.startsWith("aria-")) { made.setAttribute(key, value); continue; }
    if (value === false) continue;
    if (key === "style" || key === "dataset") Object.assign(made[key], value);
    else made.setAttribute(key, value === true ? "" : value);
  }
  made.append(...children);
  return made;
}

export function button(text, attributes, act) {
  const made = element("button", { type: "button", ...attributes }, text);
  made.addEventListener("click", act);
  return made;
}

/** A button that is on or off. */
export function toggle(text, title, pressed, change) {
  const made = button(text, { title, "aria-pressed": String(pressed) }, () => {
    const on = made.getAttribute("aria-pressed") !== "true";
    made.setAttribute("aria-pressed", on);
    change(on);
  });
  return made;
}

export function choice(label, options, chosen, change) {
  const select = element("select", { "aria-label": label },
    ...options.map(([value, text]) => element("option", { value }, text)));
  select.value = chosen;
  select.addEventListener("change", () => change(select.value));
  return select;
}

/** Whether a key is meant for the page: with one of these held it is the browser's, such as Ctrl-R or Alt-Left. */
export const ofThePage = ({ ctrlKey, metaKey, altKey }) => !(ctrlKey || metaKey || altKey);

/** One of some elements has the focus by Tab, arrow keys go on to the others; `choose` gets the one that is next. */
export function withArrows(members, choose) {
  for (const [i, member] of members.entries()) {
    member.addEventListener("keydown", (event) => {
      const step = { ArrowRight: 1, ArrowDown: 1, ArrowLeft: -1, ArrowUp: -1 }[event.key];
      if (!step || !ofThePage(event)) return;
      event.preventDefault();
      const next = members[(i + step + members.length) % members.length];
      choose(next);
      next.focus();
    });
  }
}
