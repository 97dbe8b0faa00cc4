// The page of the log: what passes on the bus, in words.

import { known, order } from "./connection.js";
import { element, show, toast } from "./element.js";

// Frames that are kept, and rows that are shown.
const KEPT = 5000;
const SHOWN = 300;

// From a picture to the next in milliseconds: nobody reads faster.
const EVERY = 100;
const KINDS = ["NMT", "Heartbeat", "EMCY", "SYNC", "PDO", "SDO", "LSS", "TIME", "Other"];

let parts = null;
let kept = [];
let dropped = 0;
let paused = false;
let due = false;
let query = "";
let node = "";
// The panel reads the drive by SDO all the time; who looks for something else is spared that.
const hidden = new Set(["SDO"]);

function wanted(frame) {
  return !hidden.has(frame.kind) && (node === "" || String(frame.node) === node) && (query === "" || `${frame.id} ${frame.bytes} ${frame.meaning}`.toLowerCase().includes(query));
}

/** Frames have come. */
export function frames(event) {
  dropped += event.dropped;
  if (!paused) kept.push(...event.frames);
  if (kept.length > KEPT) kept = kept.slice(-KEPT);
  if (!due && parts) {
    due = true;
    setTimeout(draw, EVERY);
  }
}

/** Messages with frames were missed, as this window was too slow. */
export function missed(messages) {
  dropped += messages;
}

/** There is a new connection: it knows nothing of what was wanted. */
export function connected() {
  if (parts) order("frames", { on: true }).catch((error) => toast(error.message));
}

function draw() {
  due = false;
  if (!parts) return;
  const rows = kept.filter(wanted).slice(-SHOWN).reverse();
  parts.rows.replaceChildren(...rows.map((frame) =>
    element("tr", { class: frame.own ? "own" : "" },
      element("td", { class: "at" }, frame.at), element("td", {}, element("code", {}, frame.id)),
      element("td", { class: "bytes" }, element("code", {}, frame.bytes)),
      element("td", { class: "kind" }, frame.kind), element("td", { class: "meaning" }, frame.meaning))));
  nodes();
  show(parts.count, `${kept.length} frames kept${dropped ? `, ${dropped} frames or messages were too many to tell` : ""}`);
}

/** The nodes that were heard, to choose one. */
function nodes() {
  const heard = [...new Set(kept.map((frame) => frame.node))].filter((one) => one !== null).sort((one, other) => one - other);
  const wanted = ["", ...heard.map(String)];
  if (node !== "" && !wanted.includes(node)) wanted.push(node);
  if (wanted.join() === parts.listed) return;
  parts.listed = wanted.join();
  parts.nodes.replaceChildren(...wanted.map((one) => element("option", { value: one }, one === "" ? "All nodes" : `Node ${one}`)));
  parts.nodes.value = node;
}

/** What is shown as a file, with all that is kept of it. */
function keep() {
  const lines = kept.filter(wanted).map((frame) => `${frame.at}  ${frame.id}  ${frame.bytes.padEnd(23)}  ${frame.meaning}`);
  const link = element("a", { href: URL.createObjectURL(new Blob([`${lines.join("\n")}\n`], { type: "text/plain" })), download: "log.txt" });
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 1000);
}

/** Shows the page. */
export function enter(place) {
  const search = element("input", { type: "search", "data-spaces": true, placeholder: "Identifier, bytes or words", value: query, id: "log-search", "aria-label": "Filter" });
  search.addEventListener("input", () => {
    query = search.value.toLowerCase();
    draw();
  });
  const kinds = KINDS.map((kind) => {
    const button = element("button", { type: "button", class: "chip", "aria-pressed": String(!hidden.has(kind)) }, kind);
    button.addEventListener("click", () => {
      if (!hidden.delete(kind)) hidden.add(kind);
      button.setAttribute("aria-pressed", String(!hidden.has(kind)));
      draw();
    });
    return button;
  });
  const pause = element("button", { type: "button", "aria-pressed": String(paused) }, paused ? "Go on" : "Pause");
  pause.addEventListener("click", () => {
    paused = !paused;
    pause.textContent = paused ? "Go on" : "Pause";
    pause.setAttribute("aria-pressed", String(paused));
  });
  const clear = element("button", { type: "button", onclick: () => { kept = []; dropped = 0; draw(); } }, "Clear");
  const save = element("button", { type: "button", id: "save-log", onclick: keep }, "Save");
  const chosen = element("select", { id: "log-node" });
  chosen.addEventListener("change", () => {
    node = chosen.value;
    draw();
  });
  parts = { rows: element("tbody", { id: "frames" }), count: element("span", { class: "quiet" }), nodes: chosen };
  place.append(
    element("div", { class: "title" }, element("h1", {}, "Log"), pause, clear, save),
    element("div", { class: "fields" }, element("label", { class: "narrow" }, element("span", {}, "Node"), chosen), element("label", { class: "grow" }, element("span", {}, "Filter"), search)),
    element("div", { class: "chips", role: "group", "aria-label": "Services" }, ...kinds),
    parts.count,
    element("div", { class: "scroll" }, element("table", { class: "log" },
      element("thead", {}, element("tr", {}, ...[["at", "Time"], ["", "ID"], ["bytes", "Bytes"], ["kind", "Service"], ["", "Meaning"]].map(([name, title]) => element("th", { class: name }, title)))),
      parts.rows)));
  if (known.connected) connected();
  draw();
}

/** Leaves the page. */
export function leave() {
  parts = null;
  if (known.connected) order("frames", { on: false }).catch(() => {});
}
