// Position and velocity of the last seconds at a look, drawn by uPlot (page/uplot, with its licence). What comes is kept in two rings of
// fixed length; a picture is drawn when the screen asks for one.

import uPlot from "./uplot/uPlot.esm.js";
import { element } from "./element.js";

// What is shown, in seconds, and how often the values are taken, in milliseconds.
const SPAN = 20;
const EVERY = 40;
const KEPT = (SPAN * 1000) / EVERY;
const MARKS = [-20, -15, -10, -5, 0];
const HEIGHT = 170;

/** The colours of these classes, as the style sheet has them now, dark or light. */
export function inks(place, names) {
  return names.map((name) => {
    const probe = element("i", { class: `ink ${name}` });
    place.append(probe);
    const found = getComputedStyle(probe).color;
    probe.remove();
    return found;
  });
}

/** The chart; `values()` gives position and velocity, null for what is not known. */
export function chart(values) {
  const place = element("div", { class: "chart", role: "img", "aria-label": "Position and velocity of the last seconds" });
  const data = [[], [], []];
  let plot = null;
  let due = false;

  const make = () => {
    plot?.destroy();
    const [quiet, line, accent, warn] = inks(place, ["quiet-ink", "line-ink", "accent-ink", "warn-ink"]);
    const axis = { stroke: quiet, grid: { stroke: line, width: 1 }, ticks: { stroke: line, width: 1 }, font: "12px system-ui, sans-serif" };
    plot = new uPlot({
      width: Math.max(200, place.clientWidth),
      height: HEIGHT,
      legend: { show: false },
      cursor: { y: false, drag: { x: false, y: false } },
      scales: { x: { time: false, range: (self, low, high) => [high - SPAN, high] }, position: {}, velocity: {} },
      axes: [
        { ...axis, size: 30, splits: () => MARKS.map((mark) => (data[0].at(-1) ?? 0) + mark), values: () => MARKS.map((mark) => `${mark} s`) },
        { ...axis, scale: "position", size: 64, label: "Position", labelSize: 20, labelFont: "12px system-ui, sans-serif", stroke: accent },
        { ...axis, scale: "velocity", side: 1, size: 64, label: "Velocity", labelSize: 20, labelFont: "12px system-ui, sans-serif", stroke: warn, grid: { show: false } },
      ],
      series: [
        {},
        { label: "Position", scale: "position", stroke: accent, width: 2, points: { show: false } },
        { label: "Velocity", scale: "velocity", stroke: warn, width: 1.5, points: { show: false } },
      ],
    }, data, place);
  };

  const draw = () => {
    due = false;
    if (!place.isConnected) return;
    if (!plot) make();
    plot.setData(data);
  };
  const take = setInterval(() => {
    const [position, velocity] = values();
    data[0].push(performance.now() / 1000);
    data[1].push(position);
    data[2].push(velocity);
    for (const one of data) if (one.length > KEPT) one.shift();
    if (!due) {
      due = true;
      requestAnimationFrame(draw);
    }
  }, EVERY);

  const sized = new ResizeObserver(() => plot?.setSize({ width: Math.max(200, place.clientWidth), height: HEIGHT }));
  sized.observe(place);
  const scheme = matchMedia("(prefers-color-scheme: dark)");
  scheme.addEventListener("change", make);
  const end = () => {
    clearInterval(take);
    sized.disconnect();
    scheme.removeEventListener("change", make);
    plot?.destroy();
  };
  return { root: place, end };
}
