// The page of the scope: what the drive records in each control tick, and what its transmit PDOs bring live. Curves are drawn by uPlot:
// drag to zoom, double click to see all; a click sets cursor A, a click with shift cursor B. The arrow keys move them, + and - zoom.

import uPlot from "./uplot/uPlot.esm.js";
import { known, mayWrite, order } from "./connection.js";
import { element, mark, number, show, toast, visible } from "./element.js";
import { inks } from "./chart.js";
import { Ring } from "./ring.js";

const TRIGGERS = [
  ["now", "At once"], ["606C>100", "Movement (606Ch > 100)"], ["6041#10", "Target reached (bit 10)"],
  ["fault", "Fault"], ["own", "Another one ..."],
];
// Edges of a trigger, as `sim scope --trigger` has them.
const EDGES = {
  ">": { words: "rises to", trigger: (object, level) => `${object}>${level}` },
  "<": { words: "falls below", trigger: (object, level) => `${object}<${level}` },
  "~": { words: "crosses", trigger: (object, level) => `${object}~${level}` },
  "#1": { words: "has bit … set", trigger: (object, bit) => `${object}#${bit}` },
  "#0": { words: "has bit … cleared", trigger: (object, bit) => `${object}#${bit}=0` },
};
const COLOURS = ["accent-ink", "warn-ink", "bad-ink", "good-ink", "blue-ink", "violet-ink", "quiet-ink", "text-ink"];

const typed = { channels: new Set(["606Ch:00", "6064h:00", "6062h:00", "60F4h:00"]), trigger: "606C>100", object: "6064h:00", edge: ">", level: "1000", divider: "1", samples: "", before: "20" };
let parts = null;
let recording = null;
let shown = 0;
let asked = false;
let live = null;
let dropped = 0;
let plots = [];
let cursors = { a: null, b: null };
let due = false;
// What the drive can record, and of which drive that is.
let choices = [];
let choicesOf = null;

async function attempt(promise, done) {
  try {
    const answer = await promise;
    if (done) toast(done, "good");
    return answer;
  } catch (error) {
    toast(error.message);
    return null;
  }
}

function wish() {
  const whole = (text) => (text.trim() === "" ? null : Number(text));
  return {
    channels: choices.map((one) => one.object).filter((object) => typed.channels.has(object)),
    trigger: typed.trigger === "own" ? EDGES[typed.edge].trigger(typed.object, typed.level.trim()) : typed.trigger,
    divider: whole(typed.divider), samples: whole(typed.samples), before: typed.trigger === "now" ? null : whole(typed.before),
  };
}

/** What came last, as it is drawn next; in `columns` of a picture that goes on, and each value of one that stands. */
function renew(columns) {
  const end = Math.max(...live.rings.map((ring) => ring.last()), 0);
  const span = Number(parts.span.value);
  live.end = end;
  live.curves = live.channels.map((channel, place) => {
    const [at, values] = live.rings[place].since(end - span, end, columns);
    return { name: `${channel.object} ${channel.name}`, at, values };
  });
}

/** The curves that are drawn: `at` in seconds. */
function curves() {
  if (live) return live.curves;
  if (!recording) return [];
  return recording.report.channels.map((channel) => ({ name: channel.name, at: recording.report.time_s, values: channel.values }));
}

function valueAt(curve, at) {
  let low = 0;
  let high = curve.at.length - 1;
  while (high > low) {
    const middle = (low + high) >> 1;
    if (curve.at[middle] < at) low = middle + 1;
    else high = middle;
  }
  return curve.values[low];
}

function readCursors() {
  const { a, b } = cursors;
  const all = curves();
  const rows = [];
  const shown = (place, at) => (live && !parts.paused ? live.rings[place].value(live.end + at) : valueAt(all[place], at));
  const seconds = (at) => (at === null ? "–" : `${(at * 1000).toFixed(3)} ms`);
  rows.push(element("tr", {}, element("th", {}, "Time"), element("td", {}, seconds(a)), element("td", {}, seconds(b)), element("td", {}, a !== null && b !== null ? seconds(b - a) : "–")));
  for (const [place, curve] of all.entries()) {
    const [first, second] = [a, b].map((at) => (at === null || curve.at.length === 0 ? null : shown(place, at)));
    rows.push(element("tr", {}, element("th", {}, curve.name), element("td", {}, number(first)), element("td", {}, number(second)),
      element("td", {}, first !== null && second !== null ? number(second - first) : "–")));
  }
  parts.cursors.replaceChildren(...rows);
}

function markCursors(plot) {
  const marks = live ? cursors : { "": 0, ...cursors };
  for (const [name, at] of Object.entries(marks)) {
    if (at === null) continue;
    const x = plot.valToPos(at, "x", true);
    if (x < plot.bbox.left || x > plot.bbox.left + plot.bbox.width) continue;
    const { ctx } = plot;
    ctx.save();
    ctx.strokeStyle = ctx.fillStyle = name === "" ? parts.ink[0] : parts.ink[3];
    ctx.setLineDash(name === "" ? [1, 3] : [4, 4]);
    ctx.beginPath();
    ctx.moveTo(x, plot.bbox.top);
    ctx.lineTo(x, plot.bbox.top + plot.bbox.height);
    ctx.stroke();
    ctx.font = "12px system-ui, sans-serif";
    ctx.fillText(name.toUpperCase(), x + 4, plot.bbox.top + 12);
    ctx.restore();
  }
}

/** One picture below the other, with one time: position at a look, velocity, the rest. */
function make() {
  for (const plot of plots) plot.destroy();
  plots = [];
  if (!parts) return;
  parts.ink = inks(parts.pictures, ["quiet-ink", "line-ink", "text-ink", "warn-ink"]);
  const colours = inks(parts.pictures, COLOURS);
  const all = curves();
  visible(parts.empty, all.length === 0);
  visible(parts.result, all.length > 0);
  const font = "12px system-ui, sans-serif";
  const [quiet, line] = parts.ink;
  const sync = uPlot.sync("scope");
  // A line of one point of the screen is drawn in a tenth of the time, and a live picture is drawn 60 times a second.
  const width = live ? 1 / devicePixelRatio : 1.6;
  all.forEach((curve, place) => {
    const last = place === all.length - 1;
    const holder = element("div", { class: "curve", role: "img", "aria-label": curve.name });
    parts.pictures.append(holder);
    const axis = { stroke: quiet, grid: { stroke: line, width: 1 }, ticks: { stroke: line, width: 1 }, font };
    const plot = new uPlot({
      width: Math.max(200, parts.pictures.clientWidth), height: last ? 170 : 140, title: curve.name,
      legend: { show: false },
      cursor: { sync: { key: sync.key }, drag: { x: true, y: false } },
      scales: { x: { time: false }, y: { range: (self, low, high) => (low === high ? [low - 1, high + 1] : [low - (high - low) / 20, high + (high - low) / 20]) } },
      axes: [{ ...axis, show: last, values: (self, splits) => splits.map((at) => `${+(at * 1000).toFixed(3)} ms`) }, { ...axis, size: 78 }],
      series: [{}, { stroke: colours[place % colours.length], width, points: { show: false } }],
      hooks: {
        draw: [markCursors],
        // Whoever looks closer wants it to stand.
        setSelect: [() => pause(true)],
        setScale: [(self, key) => {
          if (key !== "x" || self.zooming) return;
          for (const other of plots) {
            if (other === self) continue;
            other.zooming = true;
            other.setScale("x", { min: self.scales.x.min, max: self.scales.x.max });
            other.zooming = false;
          }
        }],
      },
    }, [curve.at, curve.values], holder);
    plot.over.addEventListener("click", (event) => {
      const at = plot.posToVal(event.offsetX, "x");
      cursors = event.shiftKey ? { ...cursors, b: at } : { ...cursors, a: at };
      readCursors();
      for (const other of plots) other.redraw();
    });
    plots.push(plot);
  });
  readCursors();
}

function draw() {
  due = false;
  if (!parts || !live || parts.paused) return;
  renew(parts.pictures.clientWidth);
  const all = curves();
  if (plots.length !== all.length) {
    parts.pictures.replaceChildren();
    make();
  } else {
    all.forEach((curve, place) => plots[place].setData([curve.at, curve.values]));
    if (cursors.a !== null || cursors.b !== null) readCursors();
  }
  live.drawn += 1;
}

/** How many pictures a second there are. */
function pace() {
  const now = performance.now();
  const took = now - live.since;
  if (took >= 1000) {
    live.pace = Math.round((live.drawn * 1000) / took);
    live.drawn = 0;
    live.since = now;
  }
  return live.pace;
}

/** A live picture stands, or goes on. */
function pause(is) {
  if (!live || parts.paused === is) return;
  parts.paused = is;
  if (is && plots.length > 0) {
    renew();
    live.curves.forEach((curve, place) => plots[place].setData([curve.at, curve.values], false));
  }
  show(parts.pause, is ? "Go on" : "Pause");
}

function showAll() {
  for (const plot of plots) plot.setData(plot.data);
}

/** The same with the keyboard. */
function key(event) {
  const [plot] = plots;
  if (!plot || event.target !== parts.pictures) return;
  const { min, max } = plot.scales.x;
  const move = (by) => {
    const which = event.shiftKey ? "b" : "a";
    const at = (cursors[which] ?? (min + max) / 2) + (by * (max - min)) / 100;
    cursors = { ...cursors, [which]: Math.min(max, Math.max(min, at)) };
    readCursors();
    for (const one of plots) one.redraw();
  };
  const zoom = (factor) => {
    pause(true);
    const centre = Math.min(max, Math.max(min, cursors.a ?? (min + max) / 2));
    plot.setScale("x", { min: centre - (centre - min) * factor, max: centre + (max - centre) * factor });
  };
  const keys = { ArrowLeft: () => move(-1), ArrowRight: () => move(1), "+": () => zoom(0.5), "-": () => zoom(2), Home: showAll };
  if (!keys[event.key]) return;
  event.preventDefault();
  keys[event.key]();
}

async function fetchRecording() {
  if (asked || known.state.recordings === shown) return;
  asked = true;
  const answer = await attempt(order("recording"));
  asked = false;
  if (!answer) return;
  shown = answer.number;
  recording = answer;
  live = null;
  cursors = { a: null, b: null };
  if (parts) {
    parts.pictures.replaceChildren();
    make();
    update();
  }
}

async function setLive(on) {
  if (!on) {
    live = null;
    if (known.connected) order("live", { on: false }).catch(() => {});
  } else {
    const channels = await attempt(order("channels"));
    if (!channels || !parts) return;
    if (channels.length === 0) {
      toast("No transmit PDO is in use: the page PDOs sets them up");
      return;
    }
    live = { channels, rings: channels.map(() => new Ring()), curves: [], drawn: 0, pace: null, since: performance.now() };
    pause(false);
    dropped = 0;
    await attempt(order("live", { on: true }));
  }
  if (!parts) return;
  cursors = { a: null, b: null };
  parts.pictures.replaceChildren();
  make();
  update();
}

/** Values of transmit PDOs have come. */
export function values(event) {
  if (!live) return;
  dropped += event.dropped;
  for (const one of event.values) {
    const ring = live.rings[one.channel];
    if (ring) one.at.forEach((at, place) => ring.push(at, one.values[place]));
  }
  if (!due && parts) {
    due = true;
    requestAnimationFrame(draw);
  }
}

/** Values were missed, as this window was too slow. */
export function missed(messages) {
  dropped += messages;
}

function keep(name, blob) {
  const link = element("a", { href: URL.createObjectURL(blob), download: name });
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 1000);
}

function csv() {
  if (live && !parts.paused) renew();
  const all = curves();
  const quoted = (text) => `"${text.replaceAll('"', '""')}"`;
  // Live channels of different PDOs come at different times: each has its own.
  const longest = Math.max(...all.map((curve) => curve.at.length));
  const one = !live;
  const lines = [one ? ["time_s", ...all.map((curve) => quoted(curve.name))] : all.flatMap((curve) => ["time_s", quoted(curve.name)])];
  for (let row = 0; row < longest; row += 1) {
    lines.push(one ? [all[0].at[row].toFixed(9), ...all.map((curve) => curve.values[row])]
      : all.flatMap((curve) => (row < curve.at.length ? [curve.at[row].toFixed(6), curve.values[row]] : ["", ""])));
  }
  keep("scope.csv", new Blob([`${lines.map((line) => line.join(",")).join("\n")}\n`], { type: "text/csv" }));
}

function png() {
  const canvases = [...parts.pictures.querySelectorAll("canvas")];
  if (canvases.length === 0) return;
  const whole = document.createElement("canvas");
  const titles = 24 * devicePixelRatio;
  whole.width = canvases[0].width;
  whole.height = canvases.reduce((sum, canvas) => sum + canvas.height + titles, 0);
  const paint = whole.getContext("2d");
  paint.fillStyle = getComputedStyle(parts.result).backgroundColor;
  paint.fillRect(0, 0, whole.width, whole.height);
  paint.fillStyle = parts.ink[2];
  paint.font = `${13 * devicePixelRatio}px system-ui, sans-serif`;
  let top = 0;
  const names = curves().map((curve) => curve.name);
  canvases.forEach((canvas, place) => {
    paint.fillText(names[place], 12, top + titles * 0.75);
    paint.drawImage(canvas, 0, top + titles);
    top += canvas.height + titles;
  });
  whole.toBlob((blob) => keep("scope.png", blob));
}

function field(key, label, properties = {}) {
  const input = element("input", { type: "text", id: `scope-${key}`, value: typed[key], ...properties });
  input.addEventListener("input", () => { typed[key] = input.value; });
  return element("label", {}, element("span", {}, label), input);
}

/** A channel is wanted, or no longer; the recorder has eight. */
function want(object, is) {
  if (!is) typed.channels.delete(object);
  else if (typed.channels.size < 8) typed.channels.add(object);
  else toast("The recorder has eight channels");
  chips();
}

/** The usual channels and those that were chosen; a list has the others. */
function chips() {
  if (!parts) return;
  const focused = document.activeElement?.dataset.object;
  const isShown = (one) => one.is_usual || typed.channels.has(one.object);
  const add = element("select", { "aria-label": "Record another object", class: "add" }, element("option", { value: "" }, "+ object"),
    ...choices.filter((one) => !isShown(one)).map((one) => element("option", { value: one.object }, `${one.object} ${one.name}`)));
  add.addEventListener("change", () => want(add.value, true));
  const made = choices.filter(isShown).map((one) => {
    const is = typed.channels.has(one.object);
    return element("button", { type: "button", class: "chip", "data-object": one.object, "aria-pressed": String(is), onclick: () => want(one.object, !is) }, `${one.object.replace(":00", "")} ${one.name}`);
  });
  parts.chips.replaceChildren(...made, add);
  parts.object.replaceChildren(...choices.map((one) => element("option", { value: one.object }, `${one.object.replace(":00", "")} ${one.name}`)));
  parts.object.value = typed.object;
  made.find((chip) => chip.dataset.object === focused)?.focus();
}

/** What the drive can record. */
async function choose(drive) {
  const name = `${drive.node} ${drive.name} ${drive.has_recorder}`;
  if (choicesOf === name || !known.connected) return;
  choicesOf = name;
  choices = (await attempt(order("recordable"))) ?? [];
  chips();
}

/** Shows the page. */
export function enter(place) {
  const trigger = element("select", { id: "scope-trigger" }, ...TRIGGERS.map(([value, label]) => element("option", { value }, label)));
  trigger.value = typed.trigger;
  const edge = element("select", { id: "scope-edge" }, ...Object.entries(EDGES).map(([value, { words }]) => element("option", { value }, words)));
  const object = element("select", { id: "scope-object" });
  for (const [name, select] of [["edge", edge], ["object", object]]) {
    select.value = typed[name];
    select.addEventListener("change", () => { typed[name] = select.value; });
  }
  const own = element("div", { class: "fields" },
    element("label", {}, element("span", {}, "When"), object), element("label", {}, element("span", {}, "Edge"), edge),
    field("level", "Level or bit", { inputmode: "numeric" }));
  trigger.addEventListener("change", () => {
    typed.trigger = trigger.value;
    visible(own, typed.trigger === "own");
  });
  visible(own, typed.trigger === "own");
  const button = (label, action, properties = {}) => element("button", { type: "button", onclick: action, ...properties }, label);
  parts = {
    paused: false,
    record: button("Record", () => attempt(order("record", wish())), { class: "primary", id: "record", "data-writes": true }),
    stop: button("Stop the recorder", () => attempt(order("stop_recorder")), { "data-writes": true }),
    live: button("Live", () => setLive(!live), { id: "live" }),
    span: element("select", { "aria-label": "Live span", id: "live-span" }, ...[1, 2, 5, 10, 30, 60].map((span) => element("option", { value: span }, `${span} s`))),
    pause: button("Pause", () => pause(!parts.paused)),
    chips: element("div", { class: "chips", role: "group", "aria-label": "Channels" }),
    object,
    words: element("p", { class: "quiet grow", id: "scope-words" }),
    pictures: element("div", { class: "curves", id: "curves", tabindex: 0, role: "group", onkeydown: key, "aria-label": "Curves: the arrow keys move cursor A, with shift cursor B; plus and minus zoom, Home shows all" }),
    cursors: element("tbody", { id: "cursors" }),
    empty: element("p", { class: "empty" }, "Nothing was recorded yet. Choose channels, press Record, and move the drive: the recording is shown when its trigger has come. Live shows what the transmit PDOs bring."),
    without: element("p", { class: "quiet" }, "This drive has no recorder (20D0h). Live shows what its transmit PDOs bring."),
  };
  parts.span.value = "5";
  parts.none = element("div", { class: "empty" }, element("p", {}, "No drive is open."), element("a", { class: "button primary", href: "#bus" }, "Go to the bus"));
  parts.result = element("section", { class: "card" },
    element("div", { class: "line" }, parts.words, button("All", showAll), button("CSV", csv, { id: "csv" }), button("PNG", png, { id: "png" })),
    parts.pictures,
    element("p", { class: "quiet" }, "Drag to zoom, double click to see all. The dotted line is the trigger. A click sets cursor A, with shift cursor B; so do the arrow keys, and + and − zoom."),
    element("div", { class: "scroll low" }, element("table", { class: "log" },
      element("thead", {}, element("tr", {}, ...["Channel", "A", "B", "B − A"].map((title) => element("th", {}, title)))), parts.cursors)));
  parts.recorder = element("div", { class: "recorder" },
    parts.chips,
    element("div", { class: "fields" },
      element("label", {}, element("span", {}, "Trigger"), trigger),
      field("before", "Before the trigger, %", { inputmode: "numeric" }),
      field("divider", "One sample every … control ticks", { inputmode: "numeric" }),
      field("samples", "Samples", { inputmode: "numeric", placeholder: "all there is room for" })),
    own);
  parts.full = element("div", {},
    element("section", { class: "card" },
      element("h2", {}, "Recorder"),
      parts.without, parts.recorder,
      element("div", { class: "line" }, parts.record, parts.stop, element("span", { class: "grow" }), parts.live, parts.span, parts.pause)),
    parts.empty, parts.result);
  chips();
  place.append(element("div", { class: "title" }, element("h1", {}, "Scope")), parts.none, parts.full);
  parts.sized = new ResizeObserver(() => {
    for (const plot of plots) plot.setSize({ width: Math.max(200, parts.pictures.clientWidth), height: plot.height });
  });
  parts.sized.observe(parts.pictures);
  parts.scheme = matchMedia("(prefers-color-scheme: dark)");
  parts.remake = () => { parts.pictures.replaceChildren(); make(); };
  parts.scheme.addEventListener("change", parts.remake);
  make();
}

/** Leaves the page. */
export function leave() {
  parts?.sized.disconnect();
  parts?.scheme.removeEventListener("change", parts.remake);
  for (const plot of plots) plot.destroy();
  plots = [];
  parts = null;
  if (live) setLive(false);
}

/** Shows what is new. */
export function update() {
  if (!parts || !known.state) return;
  const { drive, recorder, recordings } = known.state;
  visible(parts.none, !drive);
  visible(parts.full, Boolean(drive));
  if (!known.connected) live = null;
  if (recordings !== shown && recordings > 0) fetchRecording();
  if (drive) {
    choose(drive);
    for (const part of [parts.recorder, parts.record, parts.stop]) visible(part, drive.has_recorder);
    visible(parts.without, !drive.has_recorder);
  }
  const may = mayWrite() && Boolean(drive);
  mark(parts.record, "disabled", !may || Boolean(recorder));
  mark(parts.stop, "disabled", !may || !recorder);
  show(parts.record, recorder === "armed" ? "Armed, waits for its trigger" : recorder === "triggered" ? "Records" : "Record");
  show(parts.live, live ? "End live" : "Live");
  visible(parts.pause, Boolean(live));
  visible(parts.span, Boolean(live));
  if (live) {
    show(parts.words, `Live: ${live.channels.length} channels of ${new Set(live.channels.map((one) => one.pdo)).size} PDOs${pace() === null ? "" : `, ${pace()} pictures/s`}${dropped ? `, ${dropped} frames or messages were too many to tell` : ""}`);
  } else if (recording) {
    const { report } = recording;
    show(parts.words, `Recording ${recording.number} of node ${report.node}: ${report.samples} samples, one every ${+(report.period_s * 1000).toFixed(3)} ms`);
  }
}
