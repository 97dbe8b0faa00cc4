// The page of the objects: the whole dictionary of a node, to search, read and write.

import { known, listen, mayWrite, order } from "./connection.js";
import { element, mark, show, toast, visible } from "./element.js";

// Rows that are shown at once; a search finds the others.
const MOST = 200;

let parts = null;
let node = null;
let entries = [];
let query = "";
const values = new Map();
const changed = new Set();

async function load(id) {
  if (!id || !known.connected) return;
  try {
    const dictionary = await order("dictionary", { node: id });
    if (node !== id) {
      values.clear();
      changed.clear();
    }
    node = id;
    entries = dictionary.entries;
    if (parts) {
      show(parts.source, `${entries.length} entries of ${dictionary.title}`);
      list();
    }
  } catch (error) {
    toast(error.message);
  }
}

function found() {
  const words = query.toLowerCase().split(/\s+/).filter(Boolean);
  return entries.filter((entry) => {
    const text = `${entry.address} ${entry.name} ${entry.type}`.toLowerCase();
    return words.every((word) => text.includes(word.replace(/^0x/, "")));
  });
}

async function read(entry) {
  try {
    const value = await order("read", { node, object: entry.address });
    values.set(entry.address, { text: value });
  } catch (error) {
    values.set(entry.address, { error: error.message });
  }
  refresh(entry);
}

async function write(entry, value) {
  try {
    const now = await order("write", { node, object: entry.address, value });
    values.set(entry.address, { text: now });
    changed.add(entry.address);
    toast(`${entry.address} is ${now}`, "good");
  } catch (error) {
    toast(error.message);
  }
  refresh(entry);
}

function refresh(entry) {
  const row = parts?.rows.get(entry.address);
  if (!row) return;
  const value = values.get(entry.address);
  show(row.value, value ? value.error ?? value.text : "");
  row.value.className = value?.error ? "value bad" : "value";
  mark(row.root, "data-changed", changed.has(entry.address));
}

function limits(entry) {
  const words = [entry.type];
  if (entry.low !== null || entry.high !== null) words.push(`${entry.low ?? "…"} to ${entry.high ?? "…"}`);
  if (entry.unit) words.push(entry.unit);
  if (entry.default !== null) words.push(`default ${entry.default}`);
  return words.join(" · ");
}

function edit(entry, row) {
  if (row.editor) return;
  const input = element("input", { type: "text", value: values.get(entry.address)?.text?.split(" (")[0] ?? "", "aria-label": `New value of ${entry.address}` });
  const close = () => {
    row.editor?.remove();
    row.editor = null;
  };
  row.editor = element("form", { class: "editor" }, input,
    element("button", { class: "small primary" }, "Write"),
    element("button", { type: "button", class: "small", onclick: close }, "Cancel"));
  row.editor.addEventListener("submit", async (event) => {
    event.preventDefault();
    await write(entry, input.value);
    close();
  });
  row.editor.addEventListener("keydown", (event) => { if (event.key === "Escape") close(); });
  row.actions.before(row.editor);
  input.select();
}

function rowOf(entry) {
  const row = {
    value: element("output", { class: "value" }),
    actions: element("span", { class: "actions" }),
    editor: null,
  };
  if (entry.readable) row.actions.append(element("button", { type: "button", class: "small", onclick: () => read(entry) }, "Read"));
  if (entry.writable) row.actions.append(element("button", { type: "button", class: "small", "data-writes": true, onclick: () => edit(entry, row) }, "Change"));
  row.root = element("li", { class: "object" },
    element("code", {}, entry.address),
    element("span", { class: "object-name" }, entry.name, element("small", {}, limits(entry))),
    row.value, row.actions);
  return row;
}

function list() {
  const all = found();
  parts.rows = new Map(all.slice(0, MOST).map((entry) => [entry.address, rowOf(entry)]));
  parts.list.replaceChildren(...[...parts.rows.values()].map((row) => row.root));
  show(parts.count, all.length > MOST ? `${all.length} found, the first ${MOST} are shown` : `${all.length} found`);
  for (const entry of all.slice(0, MOST)) refresh(entry);
  update();
}

async function readShown() {
  for (const entry of found().slice(0, MOST)) {
    if (!parts || !known.connected) return;
    if (entry.readable && entry.type !== "DOMAIN") await read(entry);
  }
}

/** Shows the page. */
export function enter(place) {
  const search = element("input", { type: "search", placeholder: "Index or name: 6064, profile velocity", value: query, id: "search", "aria-label": "Search" });
  search.addEventListener("input", () => {
    query = search.value;
    list();
  });
  parts = {
    rows: new Map(),
    nodes: element("select", { id: "node", "aria-label": "Node" }),
    source: element("p", { class: "quiet" }),
    count: element("span", { class: "quiet", id: "count" }),
    list: element("ul", { class: "objects" }),
    empty: element("p", { class: "empty" }, "No node was found yet: the page of the bus looks for them."),
  };
  parts.nodes.addEventListener("change", () => { location.hash = `#objects/${parts.nodes.value}`; });
  parts.full = element("div", {},
    element("div", { class: "fields" }, element("label", { class: "grow" }, element("span", {}, "Search"), search),
      element("button", { type: "button", id: "read-shown", onclick: readShown }, "Read all shown")),
    parts.count, parts.list);
  place.append(element("div", { class: "title" }, element("h1", {}, "Objects"), parts.nodes), parts.source, parts.empty, parts.full);
  const wanted = Number(location.hash.split("/")[1]) || node || known.state?.drive?.node || known.state?.nodes[0]?.id;
  if (wanted) load(wanted);
  list();
}

/** Leaves the page. */
export function leave() {
  parts = null;
}

listen((what) => {
  // The first node that is heard of is shown.
  if (what === "state" && parts && node === null && known.state.nodes.length > 0 && !parts.asked) {
    parts.asked = true;
    load(known.state.drive?.node ?? known.state.nodes[0].id);
  }
});

/** Shows what is new. */
export function update() {
  if (!parts || !known.state) return;
  const { nodes } = known.state;
  visible(parts.empty, nodes.length === 0);
  visible(parts.full, nodes.length > 0);
  const names = nodes.map((one) => `${one.id} ${one.name}`).join();
  if (parts.names !== names) {
    parts.names = names;
    parts.nodes.replaceChildren(...nodes.map((one) => element("option", { value: one.id }, `Node ${one.id}${one.name ? ` · ${one.name}` : ""}`)));
  }
  if (node !== null && document.activeElement !== parts.nodes) parts.nodes.value = String(node);
  for (const button of parts.full.querySelectorAll("[data-writes]")) mark(button, "disabled", !mayWrite());
}
