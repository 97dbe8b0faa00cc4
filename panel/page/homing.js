// Homing as a drawing: the axis, the switch that is looked for, the way there, and where home lies. What a method means, the panel says.

import { order } from "./connection.js";
import { drawn, element, show, toast } from "./element.js";

// The axis of the drawing, and where a switch is active on it.
const LEFT = 30;
const RIGHT = 390;
const AXIS = 78;
const ACTIVE = {
  negative_limit: [LEFT, 90], positive_limit: [330, RIGHT], home_positive: [230, RIGHT], home_negative: [LEFT, 190], home_middle: [180, 250],
  negative_stop: [LEFT, LEFT + 14], positive_stop: [RIGHT - 14, RIGHT],
};
const NAMES = {
  negative_limit: "negative limit switch", positive_limit: "positive limit switch", home_positive: "home switch", home_negative: "home switch",
  home_middle: "home switch", negative_stop: "hard stop", positive_stop: "hard stop",
};

function arrow(from, to, y, name) {
  const head = to > from ? -7 : 7;
  return drawn("path", { class: name, d: `M${from} ${y}H${to}M${to + head} ${y - 5}L${to} ${y}L${to + head} ${y + 5}` });
}

/** The drawing of a method. */
export function drawing(method) {
  const root = drawn("svg", { viewBox: "0 0 420 118", class: "homing", role: "img", "aria-label": `Homing method ${method.number}: ${method.words}` });
  root.append(drawn("path", { class: "axis", d: `M${LEFT} ${AXIS}H${RIGHT}` }));
  root.append(drawn("text", { x: LEFT, y: AXIS + 34, class: "end" }, "−"), drawn("text", { x: RIGHT, y: AXIS + 34, class: "end" }, "+"));
  const active = ACTIVE[method.switch];
  let home = (LEFT + RIGHT) / 2;
  if (active) {
    const [low, high] = active;
    root.append(drawn("rect", { class: "active", x: low, y: AXIS - 12, width: high - low, height: 12 }));
    root.append(drawn("text", { x: Math.min(Math.max((low + high) / 2, LEFT + 54), RIGHT - 54), y: AXIS + 18 }, NAMES[method.switch]));
    home = method.edge > 0 ? high : low;
  }
  const start = method.start > 0 ? Math.max(LEFT + 20, home - 130) : Math.min(RIGHT - 20, home + 130);
  // The way out, and back over the edge where home lies on the side it came from.
  const beyond = active ? home + 26 * method.start : home + 110 * method.start;
  if (method.start !== 0) {
    const from = active ? start : home;
    root.append(drawn("circle", { class: "start", cx: from, cy: 26, r: 4 }));
    root.append(arrow(from + 6 * method.start, active ? Math.min(Math.max(beyond, LEFT), RIGHT) : beyond, 26, "fast"));
  }
  let mark = active ? home + 5 * method.side : home;
  if (method.index) {
    mark = active ? home + 38 * method.side : beyond;
    // Its word stands beside it, where no arrow is.
    const side = method.side || 1;
    root.append(drawn("path", { class: "index", d: `M${mark} ${AXIS - 30}V${AXIS + 4}` }),
      drawn("text", { x: mark + 11 * side, y: AXIS - 8, class: side > 0 ? "behind" : "before" }, "index"));
  }
  if (active && method.side !== 0) root.append(arrow(home - 30 * method.side, method.index ? mark - 3 * method.side : home + 12 * method.side, 42, "slow"));
  root.append(drawn("path", { class: "home", d: `M${mark} ${AXIS}l-8 -9v-8h16v8z` }));
  return root;
}

/** The card: choose a method, see it, set it up. */
export function homing() {
  const field = (id) => element("input", { type: "number", id, min: 0, step: 1 });
  const [fast, slow, acceleration] = ["homing-fast", "homing-slow", "homing-acceleration"].map(field);
  const method = element("select", { id: "homing-method", "data-writes": true });
  const picture = element("div", { class: "homing-picture" });
  const units = [1, 1, 2].map((which) => [element("span", { class: "unit" }), which]);
  let known = "";
  let methods = [];
  let last = {};
  const draw = () => {
    const found = methods.find((one) => one.number === Number(method.value));
    picture.replaceChildren(...(found && found.number !== 0 ? [drawing(found)] : []));
  };
  method.addEventListener("change", draw);
  const wanted = () => ({ method: Number(method.value), fast: Number(fast.value), slow: Number(slow.value), acceleration: Number(acceleration.value) });
  const attempt = async (work) => {
    try {
      await work();
    } catch (error) {
      toast(error.message);
    }
  };
  const set = () => attempt(async () => {
    await order("set_homing", wanted());
    toast("Homing is set up", "good");
  });
  // It homes as it is drawn here, and not as it was set up before.
  const home = () => attempt(async () => {
    const homing = wanted();
    if (Object.keys(homing).some((key) => homing[key] !== last[key])) await order("set_homing", homing);
    await order("home");
  });
  const label = (words, input, unit) => element("label", {}, element("span", {}, words), unit ? element("span", { class: "with-unit" }, input, unit) : input);
  const root = element("section", { class: "card" }, element("h2", {}, "Homing"),
    element("div", { class: "fields" }, label("Method (6098h)", method)),
    picture,
    element("div", { class: "fields" }, label("To the switch", fast, units[0][0]), label("Over its edge", slow, units[1][0]), label("Acceleration", acceleration, units[2][0])),
    element("div", { class: "fields" },
      element("button", { type: "button", id: "set-homing", "data-writes": true, onclick: set }, "Set up"),
      element("button", { type: "button", id: "home", class: "primary", "data-powered": true, onclick: home }, "Home")));
  const update = (drive) => {
    root.hidden = drive.homing === null;
    for (const [unit, which] of units) show(unit, drive.units[which]);
    const text = JSON.stringify(drive.homing);
    if (drive.homing === null || text === known) return;
    known = text;
    last = drive.homing;
    ({ methods } = last);
    method.replaceChildren(...methods.map((one) => element("option", { value: one.number }, `${one.number}  ${one.words}${one.index ? ", index pulse" : ""}`)));
    method.value = String(drive.homing.method);
    fast.value = drive.homing.fast;
    slow.value = drive.homing.slow;
    acceleration.value = drive.homing.acceleration;
    draw();
  };
  return { root, update };
}
