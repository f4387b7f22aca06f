"use strict";
/* The page of a sweep of samples: probabilities of severe wear, which Python has tabulated. */

/** @type {Samples} */
const samples = JSON.parse(element("content").textContent ?? "");
const probability = floats(samples.probability);
/** The operating point. */
const operating = { load: NaN, velocity: NaN };

/** Velocities of each of the three probabilities, by load. */
const columns = samples.shares.map((_, k) => samples.lines.map((row) => row[k]));
/** Probability at a place, by the table. @param {number} load @param {number} velocity */
function probabilityAt(load, velocity) {
  const { loads, velocities } = samples;
  const n = velocities.length;
  const rows = loads.map((_, i) => linear(velocities, probability.subarray(i * n, (i + 1) * n), velocity));
  return linear(loads, rows, load);
}

/** The probability as colours, and where it has the three values. @param {Frame} frame */
function drawnBand(frame) {
  const { loads, velocities, picture } = samples;
  const [left, right] = [velocities[0], velocities[velocities.length - 1]];
  const [bottom, top] = [loads[0], loads[loads.length - 1]].map(frame.y);
  const size = { x: frame.x(left), y: top, width: frame.x(right) - frame.x(left), height: bottom - top };
  const lines = columns.map((line, k) => {
    const within = line.map((place) => (place === left || place === right ? NaN : frame.x(place)));
    return svg("path", { class: k === 1 ? "boundary" : "own", d: path(within, loads.map(frame.y)) });
  });
  const look = { preserveAspectRatio: "none", href: `data:image/png;base64,${picture}` };
  return [svg("image", { ...size, ...look }), ...lines];
}

/** Draw the diagram, and show the probability at the pointer. */
function drawSamples() {
  const { loads, velocities, measured } = samples;
  const { root, inside, frame } = planeAxes(velocities, loads, measured);
  inside.append(...drawnBand(frame));
  for (const { velocity, load, outcome } of measured) {
    inside.append(testMark(frame.x(velocity), frame.y(load), outcome));
  }
  if (isInside(operating, samples)) inside.append(cross(frame, operating));
  root.addEventListener("pointerleave", () => tip.toggleAttribute("hidden", true));
  root.addEventListener("pointermove", (event) => {
    const { left, top } = root.getBoundingClientRect();
    showTip(frame, frame.load(event.clientY - top), frame.velocity(event.clientX - left));
  });
  element("diagram").replaceChildren(root, tip);
}

/** Show the probability beside a place. @param {Frame} frame @param {number} load @param {number} velocity */
function showTip(frame, load, velocity) {
  tip.hidden = !isInside({ load, velocity }, samples);
  if (tip.hidden) return;
  const text = `severe with a probability of ${percent(probabilityAt(load, velocity))}`;
  const title = `${shown(load, 3)} N, ${shown(velocity, 3)} m/s`;
  placeTip(frame, [frame.x(velocity), frame.y(load)], title, [text]);
}

/** Take an operating point, and show its probability. @param {number} load @param {number} velocity */
function judge(load, velocity) {
  Object.assign(operating, { load, velocity });
  const { loads, velocities, shares } = samples;
  drawSamples();
  if (!isInside(operating, samples)) return showMargin(samples.outside);
  /** @type {[string, string][]} */
  const rows = [["probability of severe wear", percent(probabilityAt(load, velocity))]];
  columns.forEach((line, k) => {
    const place = linear(loads, line, load);
    const [low, high] = [velocities[0], velocities[velocities.length - 1]];
    const sign = place <= low ? "below " : place >= high ? "above " : "";
    rows.push([`${shown(100 * shares[k])} % at this load`, `${sign}${shown(place, 3)} m/s`]);
  });
  showMargin(rows);
}

takeScene(() => ({}));
listenToOperatingPoint(judge);
judge(NaN, NaN);
offerCsv("velocities", samples.name);
new ResizeObserver(drawSamples).observe(element("diagram"));
