// The page of the objects: the whole dictionary of a node, to search, read and write.

import { known, listen, mayWrite, order } from "./connection.js";
import { element, mark, show, toast, visible } from "./element.js";

// Rows that are shown at once; a search finds the others.
const MOST = 200;

let parts = null;
let node = null;
let entries = [];
let query = "";
let onlyChanged = false;
const values = new Map();
const changed = new Set();
let differences = null;

async function load(id) {
  if (!id || !known.connected) return;
  if (node !== id) {
    values.clear();
    changed.clear();
    differences = null;
  }
  // From here on orders are for this node, and no row of another one can be written.
  node = id;
  entries = [];
  if (parts) list();
  try {
    const dictionary = await order("dictionary", { node: id });
    if (node !== id) return;
    entries = dictionary.entries;
    if (parts) {
      show(parts.source, `${entries.length} entries of ${dictionary.title}`);
      list();
    }
  } catch (error) {
    toast(error.message);
  }
}

/** Whether it was written here, or is known not to be what it was from the factory. */
function isChanged(entry) {
  const value = values.get(entry.address)?.text;
  return changed.has(entry.address) || (entry.writable && value !== undefined && entry.default !== null && value !== entry.default);
}

function found() {
  const words = query.toLowerCase().split(/\s+/).filter(Boolean);
  return entries.filter((entry) => {
    if (onlyChanged && !isChanged(entry)) return false;
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
    refresh(entry);
    return true;
  } catch (error) {
    toast(error.message);
    return false;
  }
}

function refresh(entry) {
  const row = parts?.rows.get(entry.address);
  if (!row) return;
  const value = values.get(entry.address);
  show(row.value, value ? value.error ?? value.text : "");
  row.value.className = value?.error ? "value bad" : "value";
  mark(row.root, "data-changed", isChanged(entry));
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
  const input = element("input", { type: "text", "data-spaces": true, value: values.get(entry.address)?.text?.split(" (")[0] ?? "", "aria-label": `New value of ${entry.address}` });
  const close = () => {
    row.editor?.remove();
    row.editor = null;
  };
  row.editor = element("form", { class: "editor" }, input,
    element("button", { class: "small primary" }, "Write"),
    element("button", { type: "button", class: "small", onclick: close }, "Cancel"));
  row.editor.addEventListener("submit", async (event) => {
    event.preventDefault();
    const isWritten = await write(entry, input.value);
    if (isWritten) close();
    else mark(input, "aria-invalid", true);
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

function keep(name, text) {
  const link = element("a", { href: URL.createObjectURL(new Blob([text], { type: "text/plain" })), download: name });
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 1000);
}

async function attempt(promise) {
  try {
    return await promise;
  } catch (error) {
    toast(error.message);
    return null;
  }
}

async function dump() {
  const file = await attempt(order("dump", { node }));
  if (file) {
    keep(file.name, file.text);
    toast(`${file.name} holds the configuration`, "good");
  }
}

/** Lets a person choose a file, and does something with it. */
function choose(work) {
  const input = element("input", { type: "file", accept: ".dcf,.xdc,.eds,.xdd" });
  input.addEventListener("change", async () => {
    const [file] = input.files;
    if (file) await work({ node, name: file.name, text: await file.text() });
  });
  input.click();
}

async function loadFile(file) {
  const words = await attempt(order("load", file));
  if (words === null) return;
  toast(words, "good");
  values.clear();
  await compareFile(file);
}

async function useSheet(file) {
  const words = await attempt(order("sheet", file));
  if (words === null) return;
  toast(words, "good");
  values.clear();
  changed.clear();
  await load(node);
}

async function compareFile(file) {
  const found = await attempt(order("compare", file));
  if (found === null) return;
  differences = { name: file.name, found };
  tellDifferences();
}

function tellDifferences() {
  if (!parts) return;
  visible(parts.differences, differences !== null);
  if (differences === null) return;
  const { name, found } = differences;
  show(parts.differ, found.length === 0 ? `Node ${node} is as ${name} says.` : `${found.length === 1 ? "1 value is" : `${found.length} values are`} not as ${name} says:`);
  parts.differing.replaceChildren(...found.map((one) => element("tr", {},
    element("td", {}, element("code", {}, one.address)), element("td", { class: "meaning" }, one.name), element("td", {}, one.here), element("td", {}, one.file))));
}

/** Shows the page. */
export function enter(place) {
  const writing = (label, action, properties = {}) => element("button", { type: "button", "data-writes": true, onclick: action, ...properties }, label);
  const said = async (promise) => {
    const words = await attempt(promise);
    if (words) toast(words, "good");
  };
  const search = element("input", { type: "search", "data-spaces": true, placeholder: "Index or name: 6064, profile velocity", value: query, id: "search", "aria-label": "Search" });
  search.addEventListener("input", () => {
    query = search.value;
    list();
  });
  parts = {
    rows: new Map(),
    nodes: element("select", { id: "node", "aria-label": "Node" }),
    source: element("p", { class: "quiet", id: "source" }),
    count: element("span", { class: "quiet", id: "count" }),
    list: element("ul", { class: "objects" }),
    empty: element("p", { class: "empty" }, "No node was found yet: the page of the bus looks for them."),
  };
  parts.differ = element("p", { id: "differ" });
  parts.differing = element("tbody");
  parts.differences = element("section", { class: "card" }, element("h2", {}, "Compared"), parts.differ,
    element("div", { class: "scroll low" }, element("table", { class: "log" },
      element("thead", {}, element("tr", {}, ...["Object", "Name", "Node", "File"].map((title) => element("th", {}, title)))), parts.differing)));
  const only = element("button", { type: "button", class: "chip", "aria-pressed": String(onlyChanged), id: "only-changed" }, "Changed only");
  only.addEventListener("click", () => {
    onlyChanged = !onlyChanged;
    only.setAttribute("aria-pressed", String(onlyChanged));
    list();
  });
  parts.nodes.addEventListener("change", () => { location.hash = `#objects/${parts.nodes.value}`; });
  parts.full = element("div", {},
    element("div", { class: "fields" }, element("label", { class: "grow" }, element("span", {}, "Search"), search),
      element("button", { type: "button", id: "read-shown", onclick: readShown }, "Read all shown")),
    element("div", { class: "line files" },
      element("button", { type: "button", id: "dump", "data-holds": true, onclick: dump }, "Save as DCF"),
      element("button", { type: "button", id: "compare", "data-holds": true, onclick: () => choose(compareFile) }, "Compare with a DCF"),
      writing("Load a DCF", () => choose(loadFile), { id: "load" }),
      element("button", { type: "button", id: "sheet", "data-holds": true, onclick: () => choose(useSheet) }, "Use a data sheet"),
      writing("Store (1010h)", () => said(order("save", { node })), { id: "store" }),
      writing("Restore (1011h)", () => said(order("restore", { node })), { id: "restore" }),
      only),
    parts.differences, parts.count, parts.list);
  place.append(element("div", { class: "title" }, element("h1", {}, "Objects"), parts.nodes), parts.source, parts.empty, parts.full);
  const wanted = Number(location.hash.split("/")[1]) || node || known.state?.drive?.node || known.state?.nodes[0]?.id;
  if (wanted) load(wanted);
  tellDifferences();
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
  const holds = mayWrite() || known.readOnly && known.writer === known.window;
  for (const button of parts.full.querySelectorAll("[data-holds]")) mark(button, "disabled", !holds);
}
