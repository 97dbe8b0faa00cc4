// The state machine of a drive as a drawing (CiA 402-2, figure of the power drive system FSA). Which state it is in, and which ways
// lead on, the panel says.

import { drawn, mark } from "./element.js";

const WIDTH = 150;
const HEIGHT = 34;

const STATES = {
  not_ready: ["Not ready to switch on", 62, 8],
  switch_on_disabled: ["Switch on disabled", 62, 66],
  ready_to_switch_on: ["Ready to switch on", 62, 124],
  switched_on: ["Switched on", 62, 182],
  operation_enabled: ["Operation enabled", 62, 240],
  fault: ["Fault", 268, 8],
  fault_reaction_active: ["Fault reaction active", 268, 66],
  quick_stop_active: ["Quick stop active", 268, 240],
};

// Number, from, to, path, and where its number stands.
const WAYS = [
  [1, "not_ready", "switch_on_disabled", "M137 42V64", 146, 57],
  [2, "switch_on_disabled", "ready_to_switch_on", "M117 100V122", 106, 115],
  [7, "ready_to_switch_on", "switch_on_disabled", "M157 124V102", 168, 115],
  [3, "ready_to_switch_on", "switched_on", "M117 158V180", 106, 173],
  [6, "switched_on", "ready_to_switch_on", "M157 182V160", 168, 173],
  [4, "switched_on", "operation_enabled", "M117 216V238", 106, 231],
  [5, "operation_enabled", "switched_on", "M157 240V218", 168, 231],
  [8, "operation_enabled", "ready_to_switch_on", "M62 250H48V141H60", 55, 226],
  [10, "switched_on", "switch_on_disabled", "M62 199H30V89H60", 37, 128],
  [9, "operation_enabled", "switch_on_disabled", "M62 263H12V77H60", 19, 170],
  [11, "operation_enabled", "quick_stop_active", "M212 251H266", 239, 246],
  [16, "quick_stop_active", "operation_enabled", "M268 264H214", 239, 277],
  [12, "quick_stop_active", "switch_on_disabled", "M343 240V146H236V90H214", 350, 196],
  [14, "fault_reaction_active", "fault", "M343 66V44", 354, 59],
  [15, "fault", "switch_on_disabled", "M268 25H236V76H214", 228, 52],
];

/** The drawing; `update(drive, may)` shows where it is. A state that a command leads to is a button: `command(transition)`. */
export function machine(command) {
  const commands = {};
  const boxes = {};
  const ways = new Map();
  const root = drawn("svg", { viewBox: "0 0 426 284", class: "machine", role: "group", "aria-label": "State machine of the drive" });
  const head = (id) => drawn("marker", { id, viewBox: "0 0 8 8", refX: 7, refY: 4, markerWidth: 7, markerHeight: 7, orient: "auto-start-reverse" },
    drawn("path", { d: "M0 0 8 4 0 8Z" }));
  root.append(drawn("defs", {}, head("head"), head("head-legal")));
  for (const [number, from, , path, x, y] of WAYS) {
    const way = drawn("g", { class: "way" }, drawn("path", { d: path }), drawn("text", { x, y }, String(number)));
    ways.set(`${number} ${from}`, way);
    root.append(way);
  }
  for (const [name, [label, x, y]] of Object.entries(STATES)) {
    boxes[name] = drawn("g", { class: "state", "data-state": name },
      drawn("rect", { x, y, width: WIDTH, height: HEIGHT, rx: 8 }),
      drawn("text", { x: x + WIDTH / 2, y: y + HEIGHT / 2 + 4 }, label));
    const go = () => { if (commands[name]) command(commands[name]); };
    boxes[name].addEventListener("click", go);
    boxes[name].addEventListener("keydown", (event) => { if (event.key === "Enter") go(); });
    root.append(boxes[name]);
  }
  const update = (drive, may) => {
    for (const [name, box] of Object.entries(boxes)) {
      const way = may && drive.answers ? drive.transitions.find((one) => one.to === name) : undefined;
      if (commands[name] === way?.transition) continue;
      commands[name] = way?.transition;
      mark(box, "data-go", Boolean(way));
      if (way) {
        box.setAttribute("role", "button");
        box.setAttribute("tabindex", "0");
        box.setAttribute("aria-label", `${way.label}: to ${STATES[name][0]}`);
      } else {
        for (const attribute of ["role", "tabindex", "aria-label"]) box.removeAttribute(attribute);
      }
    }
    for (const [name, box] of Object.entries(boxes)) mark(box, "data-here", drive.answers && drive.state === name);
    const legal = new Set(drive.transitions.map((way) => `${way.number} ${drive.state}`));
    for (const [key, way] of ways) mark(way, "data-legal", drive.answers && legal.has(key));
  };
  return { root, update };
}
