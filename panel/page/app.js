// The window: which page is shown, the stop that is on all of them, who has control.

import { connect, hasControl, known, listen, mayWrite, order, say } from "./connection.js";
import { element, mark, show, toast, visible } from "./element.js";
import * as bus from "./bus.js";
import * as drive from "./drive.js";
import * as objects from "./objects.js";
import * as pdos from "./pdos.js";
import * as scope from "./scope.js";
import * as tuning from "./tuning.js";
import * as log from "./log.js";

const pages = { bus, drive, scope, tuning, objects, pdos, log };
const place = document.getElementById("page");
const banner = document.getElementById("banner");
const status = document.getElementById("status");
let shown = null;

function route() {
  const name = location.hash.slice(1).split("/")[0] || "bus";
  const page = pages[name] ?? bus;
  for (const link of document.querySelectorAll("nav a")) {
    if (link.hash === `#${name}`) link.setAttribute("aria-current", "page");
    else link.removeAttribute("aria-current");
  }
  shown?.leave?.();
  place.replaceChildren();
  shown = page;
  page.enter(place);
  update();
}

// The stop: the button, and the space bar wherever it does not write a space. Where it does, the button says so.
function stop() {
  say("stop");
  if (!known.connected) toast("Stop was not sent: there is no connection with the panel");
  else if (known.readOnly) toast("Read-only: nothing can be stopped from here");
  else toast("Stop was sent", "good");
}
const writesSpaces = (event) => Boolean(event.target.closest?.("[data-spaces]"));
document.getElementById("stop").addEventListener("click", stop);
document.addEventListener("keydown", (event) => {
  if (event.code !== "Space" || writesSpaces(event)) return;
  event.preventDefault();
  if (!event.repeat) stop();
}, true);
// A button under the focus must not be pressed by the same key.
document.addEventListener("keyup", (event) => {
  if (event.code !== "Space" || writesSpaces(event)) return;
  event.preventDefault();
}, true);
document.addEventListener("focusin", (event) => mark(document.body, "data-typing", writesSpaces(event)));
document.addEventListener("focusout", () => mark(document.body, "data-typing", false));
// As the space bar is taken, a check box under the focus is switched by the enter key.
document.addEventListener("keydown", (event) => {
  if (event.key !== "Enter" || !event.target.matches?.("input[type=checkbox]")) return;
  event.preventDefault();
  event.target.click();
});

const takeButton = element("button", { type: "button", onclick: () => order("take").catch((error) => toast(error.message)) }, "Take control");
const bannerText = element("span");
banner.append(bannerText, takeButton);

function updateBanner() {
  let text = null;
  let kind = "";
  if (!known.connected && known.refused) {
    [text, kind] = ["This address has no token, or not that of the panel that runs now. The panel has printed the right address when it was started.", "bad"];
  } else if (!known.connected) {
    [text, kind] = ["No connection with the panel. It is tried again each second; a drive that was jogged has been stopped.", "bad"];
  } else if (known.readOnly) {
    [text, kind] = ["Read-only: nothing is written, and nothing can be stopped from here.", "info"];
  } else if (!hasControl()) {
    [text, kind] = [known.writer ? "Another window has control. This one watches; Stop works here too." : "Nobody has control.", "info"];
  } else if (known.state?.tuning) {
    [text, kind] = ["The motor is being measured, and moves by itself. STOP ends it.", "info"];
  } else if (known.state?.notice) {
    [text, kind] = [known.state.notice, "bad"];
  }
  visible(banner, text !== null);
  banner.className = kind;
  show(bannerText, text ?? "");
  visible(takeButton, known.connected && !known.readOnly && !hasControl());
}

function update() {
  updateBanner();
  const state = known.state;
  const load = state?.bus.load;
  const parts = [];
  if (known.connected && state) {
    parts.push(state.bus.title);
    parts.push(load === null ? `${state.bus.rate} frames/s` : `${load} % load`);
    if (state.busy) parts.push(state.busy);
    if (state.tuning) parts.push(state.tuning.words);
  }
  show(status, known.connected ? parts.join(" · ") : "not connected");
  mark(document.body, "data-offline", !known.connected);
  mark(document.body, "data-watching", !hasControl());
  shown?.update?.();
}

let looked = false;
listen((what, detail) => {
  if (what === "frames") {
    log.frames(detail);
    return;
  }
  if (what === "live") {
    scope.values(detail);
    return;
  }
  if (what === "missed") {
    scope.missed(detail.messages);
    log.missed(detail.messages);
    return;
  }
  update();
  if (what === "connection" && known.connected) log.connected();
  // The first look round is the panel's; it only reads.
  if (!looked && known.connected && known.state && (mayWrite() || known.readOnly && known.writer === known.window)) {
    looked = true;
    if (known.state.bus.unnumbered === null && known.state.nodes.length === 0) bus.scan();
  }
});
window.addEventListener("hashchange", route);
route();
connect();
