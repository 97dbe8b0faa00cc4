// The page of the log: what passes on the bus, in words.

import { known, order } from "./connection.js";
import { element, show, toast } from "./element.js";

// Frames that are kept, and rows that are shown.
const KEPT = 5000;
const SHOWN = 300;
const KINDS = ["NMT", "Heartbeat", "EMCY", "SYNC", "PDO", "SDO", "LSS", "TIME", "Other"];

let parts = null;
let kept = [];
let dropped = 0;
let paused = false;
let due = false;
let query = "";
// The panel reads the drive by SDO all the time; who looks for something else is spared that.
const hidden = new Set(["SDO"]);

function wanted(frame) {
  return !hidden.has(frame.kind) && (query === "" || `${frame.id} ${frame.bytes} ${frame.meaning}`.toLowerCase().includes(query));
}

/** Frames have come. */
export function frames(event) {
  dropped += event.dropped;
  if (!paused) kept.push(...event.frames);
  if (kept.length > KEPT) kept = kept.slice(-KEPT);
  if (!due && parts) {
    due = true;
    requestAnimationFrame(draw);
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
      element("td", {}, element("span", { class: "kind" }, frame.kind)), element("td", { class: "meaning" }, frame.meaning))));
  show(parts.count, `${kept.length} frames kept${dropped ? `, ${dropped} frames or messages were too many to tell` : ""}`);
}

/** Shows the page. */
export function enter(place) {
  const search = element("input", { type: "search", placeholder: "Identifier, bytes or words", value: query, id: "log-search", "aria-label": "Filter" });
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
  parts = { rows: element("tbody", { id: "frames" }), count: element("span", { class: "quiet" }) };
  place.append(
    element("div", { class: "title" }, element("h1", {}, "Log"), pause, clear),
    element("div", { class: "fields" }, element("label", { class: "grow" }, element("span", {}, "Filter"), search)),
    element("div", { class: "chips", role: "group", "aria-label": "Services" }, ...kinds),
    parts.count,
    element("div", { class: "scroll" }, element("table", { class: "log" },
      element("thead", {}, element("tr", {}, ...["Time", "ID", "Bytes", "Service", "Meaning"].map((title) => element("th", {}, title)))),
      parts.rows)));
  if (known.connected) connected();
  draw();
}

/** Leaves the page. */
export function leave() {
  parts = null;
  if (known.connected) order("frames", { on: false }).catch(() => {});
}
