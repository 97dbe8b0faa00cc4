// The page of the PDOs: a table to edit. What a table means and whether it can be, the panel says; it is applied as a whole or not at all.

import { known, mayWrite, order } from "./connection.js";
import { element, mark, show, toast, visible } from "./element.js";

let parts = null;
let node = null;
let table = null;
let before = "";
let planned = 0;

async function attempt(promise) {
  try {
    return await promise;
  } catch (error) {
    toast(error.message);
    return null;
  }
}

async function load() {
  const wanted = Number(location.hash.split("/")[1]) || known.state?.drive?.node || known.state?.nodes[0]?.id || null;
  if (wanted === null || !known.connected) return;
  const answer = await attempt(order("pdos", { node: wanted }));
  if (!answer) return;
  node = wanted;
  table = answer;
  before = JSON.stringify(table.pdos);
  if (!parts) return;
  parts.sync.value = String((table.sync_period ?? 10_000) / 1000);
  list();
}

/** What the panel says of the table as it stands here. */
async function plan() {
  if (!table || !parts) return;
  const turn = (planned += 1);
  const period = Math.max(0, Math.round(Number(parts.sync.value) * 1000) || 0);
  const answer = await attempt(order("plan_pdos", { node, pdos: table.pdos, sync_period: period }));
  if (!answer || !parts || turn !== planned) return;
  parts.problems.replaceChildren(...answer.problems.map((text) => element("li", {}, text)));
  const load = answer.load === null ? "" : `At most ${answer.load / 10} % of the bus`;
  const others = answer.unbounded ? `${load ? ", and " : ""}${answer.unbounded} sent whenever something changes, as often as that is: an inhibit time bounds them` : "";
  show(parts.load, load + others);
  answer.rates.forEach((rate, place) => {
    const cell = parts.rates[place];
    if (cell) show(cell, table.pdos[place].enabled ? rate === null ? "on events" : `${rate} /s` : "off");
    if (parts.kinds[place]) show(parts.kinds[place], answer.kinds[place]);
  });
  parts.fits = answer.problems.length === 0;
  update();
}

function changed() {
  plan();
  update();
}

/** Takes what was typed, if it can be a value; else it is marked, and nothing is applied. */
function take(input, can, set) {
  mark(input, "aria-invalid", !can);
  if (can) set();
  changed();
}

function numberField(pdo, key, title, label, most) {
  if (pdo[key] === null) return element("td", { class: "quiet", "data-label": title }, "–");
  const input = element("input", { type: "number", min: 0, max: most, value: pdo[key], "aria-label": label });
  input.addEventListener("input", () => {
    const value = Number(input.value);
    take(input, input.value !== "" && Number.isInteger(value) && value >= 0 && value <= most, () => { pdo[key] = value; });
  });
  return element("td", { "data-label": title }, input);
}

function mapping(pdo) {
  const cell = element("td", { class: "mapping", "data-label": "Mapped objects" });
  const objectName = (object) => table.mappable.find((one) => one.object === object)?.name ?? "";
  pdo.mapped.forEach((one, place) => {
    const without = () => {
      pdo.mapped.splice(place, 1);
      list(pdo);
    };
    cell.append(element("span", { class: "mapped", title: objectName(one.object) }, element("code", {}, one.object), ` ${objectName(one.object)} `, element("small", {}, `${one.bits} bit`),
      element("button", { type: "button", class: "take", "data-writes": true, "aria-label": `Take ${one.object} out`, onclick: without }, "×")));
  });
  const add = element("select", { "data-writes": true, "aria-label": "Map another object", class: "add" }, element("option", { value: "" }, "+ object"),
    ...table.mappable.filter((one) => (pdo.receive ? one.receive : one.transmit)).map((one) => element("option", { value: one.object }, `${one.object} ${one.name} (${one.bits} bit)`)));
  add.addEventListener("change", () => {
    const found = table.mappable.find((one) => one.object === add.value);
    if (!found) return;
    pdo.mapped.push({ object: found.object, bits: found.bits });
    list(pdo);
  });
  cell.append(add);
  return cell;
}

function nameOf(pdo) {
  return `${pdo.receive ? "RPDO" : "TPDO"} ${pdo.number}`;
}

function row(pdo) {
  const title = nameOf(pdo);
  const enabled = element("input", { type: "checkbox", "aria-label": `${title} is in use` });
  enabled.checked = pdo.enabled;
  enabled.addEventListener("change", () => {
    pdo.enabled = enabled.checked;
    changed();
  });
  const id = element("input", { type: "text", class: "id", value: pdo.cob_id.toString(16).toUpperCase(), "aria-label": `Identifier of ${title}, hexadecimal` });
  id.addEventListener("input", () => {
    take(id, /^[0-9a-fA-F]{1,8}$/.test(id.value), () => { pdo.cob_id = Number.parseInt(id.value, 16); });
  });
  const kind = element("input", { type: "number", min: 0, max: 255, value: pdo.type, "aria-label": `Transmission type of ${title}` });
  const words = element("small", { class: "quiet" });
  kind.addEventListener("input", () => {
    const value = Number(kind.value);
    take(kind, kind.value !== "" && Number.isInteger(value) && value >= 0 && value <= 255, () => { pdo.type = value; });
  });
  const rate = element("td", { class: "rate", "data-label": "At most" });
  parts.rates.push(rate);
  parts.kinds.push(words);
  const bits = pdo.mapped.reduce((sum, one) => sum + one.bits, 0);
  const cell = (label, ...children) => element("td", { "data-label": label }, ...children);
  return element("tr", { "data-pdo": title },
    element("th", {}, title), cell("In use", enabled), cell("Identifier", id), cell("Type", kind, words),
    numberField(pdo, "inhibit_time", "Inhibit, 100 µs", `Inhibit time of ${title} in 100 µs`, 65_535),
    numberField(pdo, "event_timer", "Timer, ms", `Event timer of ${title} in ms`, 65_535),
    mapping(pdo), element("td", { class: "rate", "data-label": "Bits" }, `${bits} / 64`), rate);
}

/** All rows anew; who was at the mapping of a PDO still is. */
function list(at = null) {
  if (!parts || !table) return;
  parts.rates = [];
  parts.kinds = [];
  parts.rows.replaceChildren(...table.pdos.map(row));
  changed();
  if (at) parts.rows.querySelector(`[data-pdo="${nameOf(at)}"] .add`)?.focus();
}

async function apply() {
  const was = JSON.parse(before);
  const pdos = table.pdos.filter((pdo, place) => JSON.stringify(pdo) !== JSON.stringify(was[place]));
  const words = await attempt(order("set_pdos", { node, pdos: table.pdos }));
  if (words === null) return;
  toast(`${pdos.length === 1 ? "1 PDO is" : `${pdos.length} PDOs are`} set up: ${words}`, "good");
  await load();
}

/** Shows the page. */
export function enter(place) {
  parts = {
    rows: element("tbody"), rates: [], kinds: [], fits: false,
    load: element("span", { class: "quiet", id: "load" }),
    problems: element("ul", { class: "problems", id: "problems" }),
    apply: element("button", { type: "button", class: "primary", id: "apply", onclick: apply }, "Apply"),
    undo: element("button", { type: "button", id: "undo", onclick: load }, "As the node has them"),
    sync: element("input", { type: "number", id: "sync", min: 0.1, step: "any", value: 10 }),
    empty: element("p", { class: "empty" }, "No node was found yet: the page of the bus looks for them."),
  };
  parts.nodes = element("select", { id: "pdo-node", "aria-label": "Node" });
  parts.nodes.addEventListener("change", () => { location.hash = `#pdos/${parts.nodes.value}`; });
  parts.sync.addEventListener("input", plan);
  const titles = ["PDO", "In use", "Identifier", "Type", "Inhibit, 100 µs", "Timer, ms", "Mapped objects", "Bits", "At most"];
  parts.full = element("div", {},
    element("div", { class: "fields" }, element("label", { class: "narrow" }, element("span", {}, "SYNC every, ms"), parts.sync), parts.apply, parts.undo, parts.load),
    parts.problems,
    element("div", { class: "scroll whole" }, element("table", { class: "log pdos" }, element("thead", {}, element("tr", {}, ...titles.map((title) => element("th", {}, title)))), parts.rows)));
  place.append(element("div", { class: "title" }, element("h1", {}, "PDOs"), parts.nodes), parts.empty, parts.full);
  parts.asked = Boolean(known.state?.nodes.length);
  load();
}

/** Leaves the page. */
export function leave() {
  parts = null;
}

/** Shows what is new. */
export function update() {
  if (!parts || !known.state) return;
  const has = known.state.nodes.length > 0;
  visible(parts.empty, !has);
  visible(parts.full, has);
  visible(parts.nodes, has);
  const names = known.state.nodes.map((one) => `${one.id} ${one.name}`).join();
  if (parts.names !== names) {
    parts.names = names;
    parts.nodes.replaceChildren(...known.state.nodes.map((one) => element("option", { value: one.id }, `Node ${one.id}${one.name ? ` · ${one.name}` : ""}`)));
  }
  if (node !== null && document.activeElement !== parts.nodes) parts.nodes.value = String(node);
  if (has && !parts.asked) {
    parts.asked = true;
    load();
  }
  const isNew = table !== null && JSON.stringify(table.pdos) !== before;
  const isTyped = parts.rows.querySelector("[aria-invalid]") === null;
  mark(parts.apply, "disabled", !mayWrite() || !isNew || !parts.fits || !isTyped);
  mark(parts.undo, "disabled", !isNew);
  for (const field of parts.rows.querySelectorAll("input, select, button")) mark(field, "disabled", !mayWrite());
}
