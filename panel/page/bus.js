// The page of the bus: who is there, numbers for those that have none, NMT, store.

import { known, mayWrite, order } from "./connection.js";
import { card, element, mark, show, toast, visible } from "./element.js";

// Bit rates that devices have (CiA 305, table of bit timings), in kbit/s.
const RATES = [1000, 800, 500, 250, 125, 50, 20, 10];

let parts = null;

/** Looks who is there. */
export async function scan() {
  await attempt(order("scan"));
}

async function attempt(promise, done) {
  try {
    const text = await promise;
    const words = done ?? text;
    if (words) toast(words, "good");
    return true;
  } catch (error) {
    toast(error.message);
    return false;
  }
}

function nmtButtons(node) {
  const commands = [["start", "Start"], ["pre_operational", "Pre-operational"], ["stop", "Stop node"], ["reset", "Reset"]];
  return commands.map(([command, label]) =>
    element("button", { type: "button", class: "small", "data-writes": true, onclick: () => attempt(order("nmt", { command, node }), `${label}: sent to ${node === 0 ? "all" : `node ${node}`}`) }, label));
}

/** LSS fastscan: each of them is told with its identity. */
async function findUnnumbered() {
  try {
    const text = await order("find");
    if (parts) show(parts.found, text);
  } catch (error) {
    toast(error.message);
  }
}

async function open(node) {
  if (await attempt(order("choose", { node }))) location.hash = "#drive";
}

function row(node) {
  const made = {
    state: element("span", { class: "pill" }),
    name: element("strong"),
    device: element("span", { class: "quiet" }),
    identity: element("code"),
    heard: element("span", { class: "quiet" }),
    emergencies: element("ul", { class: "emergencies" }),
    open: element("button", { type: "button", class: "primary", "data-writes": true, "data-node": node.id, onclick: () => open(node.id) }, "Open drive"),
  };
  const other = element("input", { type: "number", min: 1, max: 127, "aria-label": `New node-ID of node ${node.id}` });
  const keeps = element("input", { type: "checkbox", checked: true });
  const renumber = () => {
    if (other.value === "") toast("A node-ID is needed");
    else attempt(order("renumber", { node: node.id, to: Number(other.value), store: keeps.checked }));
  };
  made.root = element("article", { class: "card node" },
    element("div", { class: "node-number" }, String(node.id)),
    element("div", { class: "node-words" },
      element("div", { class: "line" }, made.name, made.state, made.heard),
      element("div", { class: "line" }, made.device, made.identity),
      made.emergencies),
    element("div", { class: "node-actions" },
      made.open,
      element("a", { class: "button", href: `#objects/${node.id}` }, "Objects"),
      element("button", { type: "button", "data-writes": true, onclick: () => attempt(order("save", { node: node.id })) }, "Save parameters"),
      element("details", {}, element("summary", {}, "NMT, node-ID"),
        element("div", { class: "line" }, ...nmtButtons(node.id)),
        element("div", { class: "fields renumber" },
          element("label", { class: "narrow" }, element("span", {}, "New node-ID"), other),
          element("label", { class: "check" }, keeps, element("span", {}, "The device stores it")),
          element("button", { type: "button", class: "renumber-button", "data-writes": true, onclick: renumber }, "Change")))));
  return made;
}

function fillRow(made, node) {
  show(made.name, node.name ?? `Node ${node.id}`);
  show(made.state, node.is_lost ? "silent" : node.state ?? "state unknown");
  made.state.dataset.state = node.is_lost ? "silent" : node.state ?? "";
  show(made.device, node.device ?? "");
  show(made.identity, node.identity ?? "");
  const age = (tenths) => (tenths < 20 ? `${(tenths / 10).toFixed(1)} s` : `${Math.floor(tenths / 10)} s`);
  const heard = node.silent === null ? "" : `heard ${age(node.silent)} ago`;
  show(made.heard, node.heartbeat !== null ? `heartbeat ${age(node.heartbeat)} ago` : [heard, "no heartbeat"].filter(Boolean).join(", "));
  visible(made.open, node.is_drive);
  if (made.emergencies.childElementCount !== node.emergencies.length || made.emergencies.lastChild?.textContent !== node.emergencies.at(-1)) {
    made.emergencies.replaceChildren(...node.emergencies.map((text) => element("li", {}, text)));
  }
}

/** Shows the page. */
export function enter(place) {
  const first = element("input", { type: "number", min: 1, max: 127, value: 4, id: "first" });
  const store = element("input", { type: "checkbox", checked: true, id: "store" });
  const number = element("button", {
    type: "button", class: "primary", id: "number", "data-writes": true,
    onclick: () => attempt(order("number", { first: Number(first.value), store: store.checked })),
  }, "Give node-ID");
  parts = {
    rows: new Map(),
    list: element("div", { class: "nodes" }),
    scan: element("button", { type: "button", id: "scan", "data-writes": true, onclick: scan }, "Scan"),
    summary: element("p", { class: "quiet" }),
    empty: element("p", { class: "empty" }, "Nobody was heard yet. Scan asks every node-ID, and whether there is a device without one."),
    busy: element("p", { class: "busy", role: "status" }),
    found: element("pre", { class: "found", id: "found" }),
    unnumbered: card("A device has no node-ID",
      element("p", {}, "It was found by LSS (CiA 305). Give it a free node-ID, and it is on the bus."),
      element("div", { class: "fields" },
        element("label", {}, element("span", {}, "Lowest node-ID"), first),
        element("label", { class: "check" }, store, element("span", {}, "The device stores it")),
        number)),
  };
  parts.unnumbered.classList.add("attention");
  visible(parts.unnumbered, false);
  const rate = element("select", { id: "rate", "data-writes": true }, ...RATES.map((kbit) => element("option", { value: kbit }, `${kbit} kbit/s`)));
  rate.addEventListener("input", () => { parts.chosen = true; });
  const keeps = element("input", { type: "checkbox", checked: true, id: "rate-store" });
  const writing = (label, id, action) => element("button", { type: "button", id, "data-writes": true, onclick: action }, label);
  parts.rate = rate;
  parts.whole = element("details", { class: "card", open: true }, element("summary", {}, "The whole bus: LSS, bit rate, NMT"),
    element("div", { class: "fields" },
      element("label", {}, element("span", {}, "Bit rate"), rate), element("label", { class: "check" }, keeps, element("span", {}, "The devices store it")),
      writing("Switch all", "switch-rate", () => attempt(order("bit_rate", { kbit: Number(rate.value), store: keeps.checked })))),
    element("p", { class: "quiet" }, "All devices and the adapter change together, after half a second of silence. Nobody stores before all are heard again: until then power-off brings the old bit rate back. A device that refuses keeps all where they are."),
    element("div", { class: "line" },
      writing("Find devices without a node-ID", "find", findUnnumbered),
      writing("Let all store (LSS)", "store-lss", () => attempt(order("store_lss"))), ...nmtButtons(0)),
    parts.found);
  place.append(
    element("div", { class: "title" }, element("h1", {}, "Bus"), parts.scan),
    parts.summary, parts.busy, parts.unnumbered, parts.empty, parts.list, parts.whole);
}

/** Leaves the page. */
export function leave() {
  parts = null;
}

/** Shows what is new. */
export function update() {
  if (!parts || !known.state) return;
  const { nodes, bus, busy } = known.state;
  show(parts.busy, busy ?? "");
  visible(parts.busy, Boolean(busy));
  visible(parts.unnumbered, bus.unnumbered === true && !known.readOnly);
  visible(parts.empty, nodes.length === 0 && !busy && bus.unnumbered !== true);
  show(parts.summary, `${bus.title}: ${nodes.length === 1 ? "1 node" : `${nodes.length} nodes`}, ${bus.rate} frames/s${bus.load === null ? "" : `, ${bus.load} % of the bus`}${bus.kbit === null ? "" : ` at ${bus.kbit} kbit/s`}${bus.errors ? `, ${bus.errors === 1 ? "1 error was" : `${bus.errors} errors were`} told (EMCY)` : ""}`);
  if (!parts.chosen && bus.kbit !== null) parts.rate.value = String(bus.kbit);
  const ids = new Set(nodes.map((node) => node.id));
  for (const [id, made] of parts.rows) {
    if (ids.has(id)) continue;
    made.root.remove();
    parts.rows.delete(id);
  }
  for (const node of nodes) {
    if (!parts.rows.has(node.id)) {
      const made = row(node);
      parts.rows.set(node.id, made);
      parts.list.append(made.root);
    }
    fillRow(parts.rows.get(node.id), node);
  }
  const may = mayWrite() || known.readOnly && known.writer === known.window;
  for (const button of document.querySelectorAll("[data-writes]")) {
    const reads = button === parts.scan || button.hasAttribute("data-node");
    mark(button, "disabled", !(reads ? may : mayWrite()) || Boolean(busy));
  }
}
