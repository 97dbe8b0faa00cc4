// Elements of the page, made without any markup in strings: what a device says is text, never HTML.

/** Makes an element: `element("button", { class: "primary", onclick }, "Go")`. */
export function element(name, properties = {}, ...children) {
  const made = document.createElement(name);
  return fill(made, properties, children);
}

/** The same in a drawing. */
export function drawn(name, properties = {}, ...children) {
  const made = document.createElementNS("http://www.w3.org/2000/svg", name);
  return fill(made, properties, children);
}

function fill(made, properties, children) {
  for (const [key, value] of Object.entries(properties)) {
    if (value === undefined || value === null || value === false) continue;
    if (key.startsWith("on")) made.addEventListener(key.slice(2), value);
    else made.setAttribute(key, value === true ? "" : value);
  }
  made.append(...children.filter((child) => child !== null && child !== undefined));
  return made;
}

/** Sets the text of an element, if it is another one: what a person has selected stays selected. */
export function show(target, text) {
  const wanted = text ?? "–";
  if (target.textContent !== String(wanted)) target.textContent = wanted;
}

/** Shows or hides, without a flicker. */
export function visible(target, is) {
  if (target.hidden === is) target.hidden = !is;
}

/** Sets or takes an attribute. */
export function mark(target, name, is) {
  if (target.hasAttribute(name) !== Boolean(is)) target.toggleAttribute(name, Boolean(is));
}

/** A number with its thousands apart, as people read it. */
export function number(value) {
  if (value === null || value === undefined) return "–";
  return String(value).replace(/\B(?=(\d{3})+(?!\d))/g, "\u202F");
}

/** A card with a title. */
export function card(title, ...children) {
  return element("section", { class: "card" }, element("h2", {}, title), ...children);
}

/** Words that go away by themselves, or by a click. */
export function toast(text, kind = "error") {
  const place = document.getElementById("toasts");
  const made = element("div", { class: `toast ${kind}`, role: kind === "error" ? "alert" : "status", onclick: () => made.remove() }, text);
  place.append(made);
  while (place.children.length > 4) place.firstElementChild.remove();
  setTimeout(() => made.remove(), kind === "error" ? 8000 : 3500);
}
