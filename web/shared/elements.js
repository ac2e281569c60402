// Elements of a page, made in one call.

/** An element with attributes and children; `style` and `dataset` take objects, as a strict page allows no style texts. */
export function element(name, attributes = {}, ...children) {
  const made = document.createElement(name);
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
