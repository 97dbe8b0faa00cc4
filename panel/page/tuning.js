// The page of the tuning: the drive measures its motor, gains are proposed beside those that are set, and how the loops answer is drawn by
// uPlot. What is measured and how, the drive and the panel know; here it is shown.

import uPlot from "./uplot/uPlot.esm.js";
import { known, mayWrite, order } from "./connection.js";
import { card, element, mark, show, toast, visible } from "./element.js";
import { inks } from "./chart.js";

const HEIGHT = 220;
const FONT = "12px system-ui, sans-serif";
// What a person has typed stays when the page is left.
const typed = { current: "", bandwidth: "" };
let parts = null;
let tuned = null;
// Which state of things `tuned` is, and whether it was asked for.
let shown = null;
let asked = false;
let plots = [];

async function attempt(promise) {
  try {
    return await promise;
  } catch (error) {
    toast(error.message);
    return null;
  }
}

async function measure(what) {
  const number = (text) => (text.trim() === "" ? null : Number(text));
  const wish = { ...what, current: number(typed.current), bandwidth: number(typed.bandwidth) };
  if ([wish.current, wish.bandwidth].some((one) => one !== null && !(Number.isInteger(one) && one > 0))) {
    toast("Current and bandwidth are whole numbers, or left to the drive");
    return;
  }
  const done = await attempt(order("tune", wish));
  if (done) toast("Measured; nothing is written", "good");
}

async function write() {
  const said = await attempt(order("write_tuning"));
  if (said) toast(said, "good");
}

/** Asks for what is known, when that is another thing than what is shown. */
async function renew(drive) {
  const wanted = `${drive.node} ${drive.can_tune} ${known.state.tunings}`;
  if (asked || shown === wanted || !drive.can_tune || known.state.tuning || !drive.answers) return;
  asked = true;
  const answer = await attempt(order("tuned"));
  asked = false;
  // Who does not answer now is not asked again and again.
  shown = wanted;
  tuned = answer;
  draw();
}

function rows() {
  const cell = (text, name = "") => element("td", { class: name }, text ?? "–");
  parts.rows.replaceChildren(...tuned.parameters.map((one) => element("tr", { "data-differs": one.found !== null && one.found !== one.set },
    element("th", { scope: "row" }, one.name, " ", element("span", { class: "unit" }, one.unit)),
    cell(one.found, "measured"), cell(one.set ?? "as built"), element("td", { class: "object" }, element("code", {}, one.object)))));
  visible(parts.encoder, tuned.encoder !== null);
  show(parts.encoder, tuned.encoder ? `Encoder: ${tuned.encoder}.` : "");
  const isFound = tuned.parameters.some((one) => one.found !== null);
  visible(parts.write, isFound && !tuned.is_written);
  show(parts.said, !isFound ? "Nothing was measured yet." : tuned.is_written ? "The drive goes by what was measured." : "Nothing of it is written yet.");
  parts.fields.current.placeholder = String(tuned.current / 10);
  parts.fields.bandwidth.placeholder = tuned.bandwidth === 0 ? "left to the drive" : String(tuned.bandwidth);
}

/** One picture: `curves` are the ink, the words and the values of each. */
function picture(place, title, at, curves, axis) {
  const [quiet, line] = inks(parts.root, ["quiet-ink", "line-ink"]);
  const colours = inks(parts.root, curves.map((curve) => curve.ink));
  const common = { stroke: quiet, grid: { stroke: line, width: 1 }, ticks: { stroke: line, width: 1 }, font: FONT };
  const holder = element("div", { class: "curve", role: "img", "aria-label": title });
  place.append(holder);
  plots.push(new uPlot({
    width: Math.max(200, holder.clientWidth), height: HEIGHT, title,
    legend: { show: curves.length > 1, live: false },
    cursor: { y: false, drag: { x: false, y: false } },
    scales: { x: { time: false, ...axis.scale }, y: { range: (self, low, high) => [low - (high - low) / 15 - 1e-3, high + (high - low) / 15 + 1e-3] } },
    axes: [{ ...common, ...axis.marks }, { ...common, size: 64 }],
    series: [{ label: "" }, ...curves.map((curve, which) => ({ label: curve.words, stroke: colours[which], width: 2, points: { show: false } }))],
  }, [at, ...curves.map((curve) => curve.values)], holder));
}

function draw() {
  for (const plot of plots) plot.destroy();
  plots = [];
  if (!parts) return;
  parts.responses.replaceChildren();
  parts.steps.replaceChildren();
  const response = tuned?.response;
  const step = tuned?.step;
  visible(parts.responseCard, Boolean(response?.frequency.length));
  visible(parts.stepCard, Boolean(step?.time.length));
  if (!tuned) return;
  rows();
  if (response.frequency.length > 0) {
    // On a scale of factors: from the first frequency to the last one, with marks at 1, 2 and 5 of each ten.
    const [first, last] = [response.frequency[0], response.frequency.at(-1)];
    const marks = [-1, 0, 1, 2, 3, 4].flatMap((power) => [1, 2, 5].map((part) => part * 10 ** power)).filter((one) => one >= first && one <= last);
    const axis = { scale: { distr: 3, range: () => [first, last] }, marks: { splits: () => marks, filter: (self, splits) => splits, values: () => marks.map((one) => `${one} Hz`) } };
    picture(parts.responses, "Speed for a torque, in dB of rad/s per N·m", response.frequency, [{ words: "amplitude", ink: "accent-ink", values: response.decibels }], axis);
    picture(parts.responses, "Phase in degrees", response.frequency, [{ words: "phase", ink: "warn-ink", values: response.phase }], axis);
  }
  if (step.time.length > 0) {
    const axis = { marks: { values: (self, splits) => splits.map((split) => `${+split.toFixed(3)} ms`) } };
    picture(parts.steps, "Position in increments, from where it began", step.time,
      [{ words: "wanted", ink: "quiet-ink", values: step.wanted }, { words: "was", ink: "accent-ink", values: step.was }], axis);
  }
}

function field(key, label, unit) {
  const input = element("input", { type: "number", id: `tuning-${key}`, value: typed[key], inputmode: "numeric", step: 1, min: 1 });
  input.addEventListener("input", () => { typed[key] = input.value; });
  parts.fields[key] = input;
  return element("label", {}, element("span", {}, label), element("span", { class: "with-unit" }, input, element("span", { class: "unit" }, unit)));
}

/** Shows the page. */
export function enter(place) {
  const button = (label, id, action, properties = {}) => element("button", { type: "button", id, onclick: action, ...properties }, label);
  const moves = (label, id, what, properties) => button(label, id, () => measure(what), { "data-moves": true, ...properties });
  parts = { fields: {} };
  Object.assign(parts, {
    none: element("div", { class: "empty" }, element("p", {}, "No drive is open."), element("a", { class: "button primary", href: "#bus" }, "Go to the bus")),
    without: element("div", { class: "empty", id: "cannot-tune" },
      element("p", {}, "This drive has nothing to tune: it has no objects to measure its motor with (20C0h to 20C2h)."),
      element("p", {}, "A stepper that follows its pulses has no loops of velocity and position. The page Scope records how it moves.")),
    progress: element("progress", { id: "tuning-progress", "aria-label": "How far the measurement is" }),
    at: element("p", { class: "busy", id: "tuning-at", role: "status" }),
    silent: element("p", { class: "fault", role: "alert" }, "The drive does not answer."),
    power: element("p", { class: "quiet", id: "tuning-power" }, "The motor has power. The page Drive takes it away; it is given back here for the measurement alone."),
    rows: element("tbody", { id: "tuning-rows" }),
    encoder: element("p", { class: "quiet", id: "tuning-encoder" }),
    said: element("p", { class: "quiet grow", id: "tuning-said" }),
    write: button("Write to the drive", "tuning-write", write),
    responses: element("div", { class: "curves", id: "tuning-response" }),
    steps: element("div", { class: "curves", id: "tuning-step" }),
  });
  parts.buttons = [
    moves("Measure the motor", "tune-motor", { motor: true }, { class: "primary" }),
    moves("Frequency response", "tune-response", { response: true }),
    moves("Step response", "tune-step", { step: true }),
  ];
  parts.responseCard = card("Frequency response", parts.responses);
  parts.stepCard = card("Step response", parts.steps);
  parts.full = element("div", {},
    card("Measure",
      element("p", {}, "The motor moves by itself: a turn of its field and strokes to both sides. It must be free to turn, and lift nothing. STOP and the space bar end it at any moment."),
      element("div", { class: "fields" }, field("current", "Current, of the rated one", "%"), field("bandwidth", "Wanted bandwidth of the velocity loop", "1/s")),
      element("div", { class: "line" }, ...parts.buttons),
      parts.silent, parts.power, parts.at, parts.progress),
    card("Motor and gains",
      element("div", { class: "scroll low" }, element("table", { class: "log tuned" },
        element("thead", {}, element("tr", {}, ...[["", ""], ["Measured", ""], ["Set", ""], ["Object", "object"]].map(([title, name]) => element("th", { scope: "col", class: name }, title)))), parts.rows)),
      parts.encoder,
      element("div", { class: "line" }, parts.said, parts.write)),
    parts.responseCard, parts.stepCard);
  parts.root = element("div", {}, element("div", { class: "title" }, element("h1", {}, "Tuning")), parts.none, parts.without, parts.full);
  place.append(parts.root);
  parts.sized = new ResizeObserver(() => {
    for (const plot of plots) plot.setSize({ width: Math.max(200, plot.root.parentElement.clientWidth), height: HEIGHT });
  });
  parts.sized.observe(parts.root);
  parts.scheme = matchMedia("(prefers-color-scheme: dark)");
  parts.scheme.addEventListener("change", draw);
  shown = null;
  draw();
}

/** Leaves the page. */
export function leave() {
  parts?.sized.disconnect();
  parts?.scheme.removeEventListener("change", draw);
  for (const plot of plots) plot.destroy();
  plots = [];
  parts = null;
}

/** Shows what is new. */
export function update() {
  if (!parts) return;
  const state = known.connected ? known.state : null;
  const drive = state?.drive;
  visible(parts.none, !drive);
  visible(parts.without, Boolean(drive) && !drive.can_tune);
  visible(parts.full, Boolean(drive?.can_tune));
  if (!drive?.can_tune) return;
  renew(drive);
  const { tuning } = state;
  const hasPower = ["switched_on", "operation_enabled", "quick_stop_active", "fault_reaction_active"].includes(drive.state);
  visible(parts.silent, !drive.answers && !tuning);
  visible(parts.power, hasPower && drive.answers && !tuning);
  visible(parts.at, Boolean(tuning));
  visible(parts.progress, Boolean(tuning));
  if (tuning) {
    show(parts.at, tuning.words);
    parts.progress.max = tuning.parts;
    parts.progress.value = tuning.part;
  }
  const may = mayWrite() && drive.answers && !tuning && !hasPower;
  for (const button of [...parts.buttons, parts.write]) mark(button, "disabled", !may);
}
