// The page of the drive: state machine, words, moves, jog.

import { known, mayWrite, order, say } from "./connection.js";
import { card, element, mark, number, show, toast, visible } from "./element.js";
import { chart } from "./chart.js";
import { homing } from "./homing.js";
import { machine } from "./machine.js";

// How often a held button says that it is held, in milliseconds. The panel ends a jog when nothing was heard for 150.
const BEAT = 40;

const STATE_NAMES = {
  not_ready: "Not ready to switch on",
  switch_on_disabled: "Switch on disabled",
  ready_to_switch_on: "Ready to switch on",
  switched_on: "Switched on",
  operation_enabled: "Operation enabled",
  quick_stop_active: "Quick stop active",
  fault_reaction_active: "Fault reaction active",
  fault: "Fault",
};

let parts = null;
let beating = null;
// What a person has typed stays when the page is left, for the drive that it was meant for. How far a machine can go nobody knows but that
// person; the virtual drive may go anywhere.
const NOTHING = { target: "", distance: "", velocity: "", acceleration: "", deceleration: "", jog: "", set_point: "" };
const typed = { ...NOTHING };
const VIRTUAL = { target: "5000", distance: "1000", jog: "2000" };
let typedFor = null;

async function attempt(what, details) {
  try {
    await order(what, details);
  } catch (error) {
    toast(error.message);
  }
}

function field(key, label, unit) {
  const input = element("input", { type: "number", value: typed[key], id: key, inputmode: "numeric", step: 1 });
  input.addEventListener("input", () => { typed[key] = input.value; });
  return { input, root: element("label", {}, element("span", {}, label), element("span", { class: "with-unit" }, input, unit)) };
}

/** A whole number that was typed; a toast, and nothing, for what is none. */
function whole(input, name) {
  const value = Number(input.value);
  if (input.value.trim() === "" || !Number.isInteger(value)) {
    toast(`${name}: a whole number is needed`);
    return null;
  }
  return value;
}

async function move(relative) {
  const target = relative ? whole(parts.distance.input, "Distance") : whole(parts.target.input, "Position");
  const optional = ({ input }, name) => (input.value.trim() === "" ? undefined : whole(input, name));
  const velocity = optional(parts.velocity, "Velocity");
  const acceleration = optional(parts.acceleration, "Acceleration");
  const deceleration = optional(parts.deceleration, "Deceleration");
  if ([target, velocity, acceleration, deceleration].includes(null)) return;
  await attempt("move", { target, relative, velocity, acceleration, deceleration });
}

async function setPoint() {
  const value = whole(parts.setPoint.input, parts.setPointName.textContent);
  if (value !== null) await attempt("set_point", { value });
}

// The dead man's switch: it moves while the button is held, and says so again and again.
function press(direction) {
  const velocity = whole(parts.jog.input, "Jog velocity");
  if (velocity === null || beating !== null) return;
  attempt("jog", { velocity: direction * Math.abs(velocity) });
  beating = setInterval(() => say("beat"), BEAT);
}

function release() {
  if (beating === null) return;
  clearInterval(beating);
  beating = null;
  say("release");
}
for (const end of ["pointerup", "pointercancel", "blur", "pagehide"]) window.addEventListener(end, release);
document.addEventListener("visibilitychange", () => { if (document.hidden) release(); });

function jogButton(label, direction, id) {
  const button = element("button", { type: "button", class: "jog", id, "data-powered": true }, label);
  button.addEventListener("pointerdown", (event) => {
    if (event.button !== 0 || button.disabled) return;
    press(direction);
  });
  for (const end of ["pointerleave", "lostpointercapture"]) button.addEventListener(end, release);
  button.addEventListener("contextmenu", (event) => event.preventDefault());
  button.addEventListener("keydown", (event) => {
    if (event.key === "Enter") {
      event.preventDefault();
      if (!event.repeat) press(direction);
    }
  });
  button.addEventListener("keyup", release);
  return button;
}

/** Shows the page. */
export function enter(place) {
  const unit = () => element("span", { class: "unit" });
  parts = {
    name: element("h1", {}, "Drive"),
    pill: element("span", { class: "pill big", id: "state" }),
    guard: element("span", { class: "quiet", id: "guard" }),
    fault: element("p", { class: "fault", role: "alert" }),
    silent: element("p", { class: "fault", role: "alert" }),
    position: element("output", { id: "position" }),
    velocityNow: element("output", { id: "velocity-now" }),
    demand: element("output"),
    lag: element("output"),
    units: [],
    enable: element("button", { type: "button", class: "primary", id: "enable", "data-writes": true, onclick: () => attempt("enable") }, "Enable"),
    disable: element("button", { type: "button", id: "disable", "data-writes": true, onclick: () => attempt("transition", { transition: "shutdown" }) }, "Disable"),
    transitions: element("div", { class: "transitions" }),
    machine: machine((transition) => { if (mayWrite()) attempt("transition", { transition }); }),
    homing: homing(),
    chart: chart(() => {
      const drive = known.connected ? known.state?.drive : null;
      return drive?.answers ? [drive.position, drive.velocity] : [null, null];
    }),
    statusword: element("dd", { id: "statusword" }),
    controlword: element("dd"),
    mode: element("dd", { id: "mode" }),
    modes: element("select", { id: "modes", "data-writes": true, "aria-label": "Mode of operation" }),
    values: element("dl", { class: "values" }),
    legal: "",
  };
  const unitOf = (which) => {
    const made = unit();
    parts.units.push([made, which]);
    return made;
  };
  parts.target = field("target", "Position", unitOf(0));
  parts.distance = field("distance", "Distance", unitOf(0));
  parts.velocity = field("velocity", "Velocity", unitOf(1));
  parts.acceleration = field("acceleration", "Acceleration", unitOf(2));
  parts.deceleration = field("deceleration", "Deceleration", unitOf(2));
  parts.jog = field("jog", "Jog velocity", unitOf(1));
  parts.setPointName = element("span", { id: "set-point-name" });
  parts.setPointUnit = unit();
  parts.setPoint = field("set_point", parts.setPointName, parts.setPointUnit);
  const powered = (label, id, action) => element("button", { type: "button", id, "data-powered": true, onclick: action }, label);
  parts.setPoints = element("div", { class: "fields" }, parts.setPoint.root, powered("Set", "set", setPoint), powered("Zero", "zero", () => attempt("set_point", { value: 0 })));
  parts.modes.addEventListener("change", () => attempt("mode", { mode: Number(parts.modes.value) }));

  const reading = (label, output, which) => element("div", { class: "reading" }, element("span", { class: "quiet" }, label), element("span", {}, output, " ", unitOf(which)));
  parts.empty = element("div", { class: "empty" }, element("p", {}, "No drive is open. The page of the bus lists those that were found."), element("a", { class: "button primary", href: "#bus" }, "Go to the bus"));
  parts.full = element("div", { class: "drive" },
    element("div", { class: "column" },
      element("section", { class: "card readings" },
        element("div", { class: "line" }, parts.pill, parts.enable, parts.disable),
        parts.silent, parts.fault,
        element("div", { class: "reading main" }, element("span", { class: "quiet" }, "Position"), element("span", {}, parts.position, " ", unitOf(0))),
        element("div", { class: "grid3" },
          reading("Velocity", parts.velocityNow, 1), reading("Demand", parts.demand, 0), reading("Following error", parts.lag, 0)),
        parts.chart.root,
        parts.guard),
      card("Move",
        element("div", { class: "pair" },
          element("div", { class: "fields" }, parts.target.root, powered("Move to", "move-to", () => move(false))),
          element("div", { class: "fields" }, parts.distance.root, powered("Move by", "move-by", () => move(true)))),
        element("div", { class: "fields" }, parts.velocity.root, parts.acceleration.root, parts.deceleration.root)),
      card("Jog",
        element("div", { class: "fields" }, parts.jog.root, jogButton("◀ Negative", -1, "jog-negative"), jogButton("Positive ▶", 1, "jog-positive")),
        element("p", { class: "quiet" }, "It runs as long as a button is held.")),
      card("Mode",
        element("div", { class: "fields" }, element("label", {}, element("span", {}, "Mode of operation (6060h)"), parts.modes)),
        parts.setPoints)),
    element("div", { class: "column" },
      card("State machine", parts.machine.root, parts.transitions),
      parts.homing.root,
      card("Words",
        element("dl", { class: "values" },
          element("dt", {}, "Statusword"), parts.statusword,
          element("dt", {}, "Controlword"), parts.controlword,
          element("dt", {}, "Mode"), parts.mode),
        parts.values)));
  place.append(element("div", { class: "title" }, parts.name), parts.empty, parts.full);
}

/** Leaves the page: whoever is not on it holds no button of it. */
export function leave() {
  release();
  parts?.chart.end();
  parts = null;
}

function transitionButtons(drive) {
  const ways = drive.answers ? drive.transitions : [];
  const legal = JSON.stringify(ways);
  if (legal === parts.legal) return;
  parts.legal = legal;
  parts.transitions.replaceChildren(...ways.map((way) =>
    element("button", { type: "button", class: "small", "data-writes": true, title: `to ${STATE_NAMES[way.to]}`, onclick: () => attempt("transition", { transition: way.transition }) },
      element("span", { class: "way-number" }, String(way.number)), way.label)));
  if (drive.answers && ways.length === 0) parts.transitions.append(element("p", { class: "quiet" }, "No command leads on from here."));
}

function word(target, value) {
  show(target, value ? `${value.number}  ${value.words}` : "–");
}

/** Shows what is new. */
export function update() {
  if (!parts) return;
  const drive = known.connected ? known.state?.drive : null;
  visible(parts.empty, !drive);
  visible(parts.full, Boolean(drive));
  if (!drive) {
    release();
    show(parts.name, "Drive");
    return;
  }
  if (typedFor !== drive.node) {
    typedFor = drive.node;
    Object.assign(typed, { ...NOTHING, ...(known.state.bus.is_virtual ? VIRTUAL : {}) });
    for (const { input } of [parts.target, parts.distance, parts.velocity, parts.acceleration, parts.deceleration, parts.jog, parts.setPoint]) {
      input.value = typed[input.id];
    }
  }
  show(parts.name, `${drive.name} · node ${drive.node}`);
  show(parts.pill, drive.answers ? STATE_NAMES[drive.state] ?? "–" : "No answer");
  parts.pill.dataset.state = drive.answers ? drive.state : "silent";
  const isStopped = known.state.nodes.find((one) => one.id === drive.node)?.state === "stopped";
  visible(parts.silent, !drive.answers);
  show(parts.silent, isStopped ? "The node is stopped by NMT, so it answers nothing. The page Bus starts it." : "The drive does not answer.");
  visible(parts.fault, Boolean(drive.fault));
  show(parts.fault, drive.fault ? `Error ${drive.fault}` : "");
  // What was read before it fell silent is not where it is now.
  const now = (value) => (drive.answers ? number(value) : "–");
  show(parts.position, now(drive.position));
  show(parts.velocityNow, now(drive.velocity));
  show(parts.demand, now(drive.demand));
  show(parts.lag, now(drive.following_error));
  for (const [place, which] of parts.units) show(place, drive.units[which]);
  parts.velocity.input.placeholder = drive.profile_velocity ?? "";
  parts.acceleration.input.placeholder = drive.profile_acceleration ?? "";
  parts.deceleration.input.placeholder = drive.profile_deceleration ?? "";
  visible(parts.setPoints, drive.set_point !== null);
  if (drive.set_point !== null) {
    show(parts.setPointName, drive.set_point.name);
    show(parts.setPointUnit, drive.set_point.unit);
  }
  show(parts.guard, drive.guard === "on" ? "The drive watches the panel's heartbeat (1016h)."
    : drive.guard === "off" ? "The drive will watch the panel's heartbeat as soon as it is commanded."
    : `The drive does not watch the panel: ${drive.guard.impossible}`);
  const isOn = drive.state === "operation_enabled";
  visible(parts.enable, !isOn);
  visible(parts.disable, isOn);
  parts.machine.update(drive, mayWrite());
  parts.homing.update(drive);
  transitionButtons(drive);
  word(parts.statusword, drive.statusword);
  word(parts.controlword, drive.controlword);
  const name = drive.modes.find((mode) => mode.number === drive.mode)?.name;
  show(parts.mode, drive.mode === null ? "–" : name ? `${drive.mode}  ${name}` : `${drive.mode}`);
  if (parts.modes.childElementCount !== drive.modes.length) {
    parts.modes.replaceChildren(...drive.modes.map((mode) => element("option", { value: mode.number }, mode.name)));
  }
  if (document.activeElement !== parts.modes && drive.mode !== null) parts.modes.value = String(drive.mode);
  const values = JSON.stringify(drive.values);
  if (parts.valuesText !== values) {
    parts.valuesText = values;
    parts.values.replaceChildren(...drive.values.flatMap(([label, text]) => [element("dt", {}, label), element("dd", {}, text)]));
  }
  const may = mayWrite();
  for (const button of parts.full.querySelectorAll("[data-writes]")) mark(button, "disabled", !may || !drive.answers);
  for (const button of parts.full.querySelectorAll("[data-powered]")) mark(button, "disabled", !may || !isOn || !drive.answers);
  if (!may) release();
}
