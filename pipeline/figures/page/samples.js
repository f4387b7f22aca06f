// @ts-check
"use strict";
/* The page of a sweep of samples: probabilities of severe wear, which Python has tabulated. */

/**
 * @typedef {{name: string, measured: Measurement[], loads: number[], velocities: number[],
 *   probability: string, picture: string, scale: string, shares: number[],
 *   lines: number[][]}} Samples probabilities by load and velocity, and velocities by load and
 *   probability, within those computed
 */

/** @type {Samples} */
const samples = JSON.parse(element("content").textContent ?? "");
const probability = new Float32Array(bytes(samples.probability));
/** The operating point. */
const operating = { load: NaN, velocity: NaN };

/** Velocities of each of the three probabilities, by load. */
function columns() {
  return samples.shares.map((_, k) => samples.lines.map((row) => row[k]));
}

/**
 * Probability at a place, from the nearest ones of the table.
 * @param {number} load @param {number} velocity
 */
function probabilityAt(load, velocity) {
  const { loads, velocities } = samples;
  const n = velocities.length;
  const rows = loads.map((_, i) => linear(velocities, probability.subarray(i * n, (i + 1) * n), velocity));
  return linear(loads, rows, load);
}

/** @param {number} value */
function percent(value) {
  if (value < 0.001 || value > 0.999) return value < 0.5 ? "below 0.1 %" : "above 99.9 %";
  return `${shown(100 * value, 2)} %`;
}

/** The probability as colours, and where it has the three values. @param {Frame} frame */
function drawnBand(frame) {
  const { loads, velocities, picture } = samples;
  const [left, right] = [velocities[0], velocities[velocities.length - 1]];
  const [bottom, top] = [loads[0], loads[loads.length - 1]].map(frame.y);
  const size = { x: frame.x(left), y: top, width: frame.x(right) - frame.x(left), height: bottom - top };
  const lines = columns().map((line, k) => {
    const within = line.map((place) => (place === left || place === right ? NaN : frame.x(place)));
    return svg("path", { class: k === 1 ? "boundary" : "own", d: path(within, loads.map(frame.y)) });
  });
  const look = { preserveAspectRatio: "none", href: `data:image/png;base64,${picture}` };
  return [svg("image", { ...size, ...look }), ...lines];
}

/** The operating point lies within the sweep. */
function isJudgedPlace() {
  return isOn(operating.load, samples.loads) && isOn(operating.velocity, samples.velocities);
}

/** Draw the diagram, and show the probability at the pointer. */
function drawSamples() {
  const { loads, velocities, measured } = samples;
  const width = Math.max(element("diagram").clientWidth, 280);
  const x = ends([...velocities, ...measured.map(({ velocity }) => velocity)]);
  const y = ends([...loads, ...measured.map(({ normal_load }) => normal_load)]);
  const { root, inside, frame } = axes(
    width,
    Math.round(Math.min(Math.max(0.72 * width, 300), 560)),
    { ...x, label: "sliding velocity [m/s]" },
    { ...y, label: "normal load [N]" },
  );
  inside.append(...drawnBand(frame));
  for (const { velocity, normal_load, outcome } of measured) {
    inside.append(testMark(frame.x(velocity), frame.y(normal_load), outcome));
  }
  if (isJudgedPlace()) inside.append(cross(frame.x(operating.velocity), frame.y(operating.load)));
  root.addEventListener("pointerleave", () => {
    tip.hidden = true;
  });
  root.addEventListener("pointermove", (event) => {
    const { left, top } = root.getBoundingClientRect();
    const across = (event.clientX - left - frame.left) / (frame.right - frame.left);
    const up = (event.clientY - top - frame.bottom) / (frame.top - frame.bottom);
    showTip(frame, y.low + up * (y.high - y.low), x.low + across * (x.high - x.low));
  });
  element("diagram").replaceChildren(root, tip);
}

/**
 * Show the probability at a place beside it.
 * @param {Frame} frame @param {number} load @param {number} velocity
 */
function showTip(frame, load, velocity) {
  tip.hidden = !(isOn(load, samples.loads) && isOn(velocity, samples.velocities));
  if (tip.hidden) return;
  const text = `severe with a probability of ${percent(probabilityAt(load, velocity))}`;
  const place = html("b", {}, `${shown(load, 3)} N, ${shown(velocity, 3)} m/s`);
  tip.replaceChildren(place, html("div", {}, text));
  placeTip(frame, load, velocity);
}

/** Take an operating point, and show its probability. @param {number} load @param {number} velocity */
function judge(load, velocity) {
  Object.assign(operating, { load, velocity });
  const { loads, velocities, shares } = samples;
  drawSamples();
  element("operating").classList.toggle("is-used", isJudgedPlace());
  if (!isJudgedPlace()) {
    const hint = html("p", { class: "hint" }, reasonAgainst(load, velocity, loads, velocities));
    element("margin").replaceChildren(hint);
    return;
  }
  /** @type {[string, string][]} */
  const rows = [["probability of severe wear", percent(probabilityAt(load, velocity))]];
  columns().forEach((line, k) => {
    const place = linear(loads, line, load);
    const [low, high] = [velocities[0], velocities[velocities.length - 1]];
    const sign = place <= low ? "below " : place >= high ? "above " : "";
    rows.push([`${shown(100 * shares[k])} % at this load`, `${sign}${shown(place, 3)} m/s`]);
  });
  element("margin").replaceChildren(pairs(rows));
}

function beginSamples() {
  takeScene(() => ({}));
  listenToOperatingPoint(judge);
  judge(NaN, NaN);
  const [low, , high] = samples.shares.map((share) => 100 * share);
  const href = `data:image/png;base64,${samples.scale}`;
  const scale = svg("image", { href, width: 26, height: 14, preserveAspectRatio: "none" });
  showSigns([
    [true, "probability of severe wear, 0 to 100 %", scale],
    [true, "50 %, as likely severe as mild", svg("path", { class: "boundary", d: "M0,7H26" })],
    [true, `${low} and ${high} %`, svg("path", { class: "own", d: "M0,7H26" })],
    ...testSigns(samples.measured),
  ]);
  const lines = [...element("velocities").querySelectorAll("tr")].map((row) =>
    [...row.cells].map((cell) => cell.textContent).join(","),
  );
  const link = /** @type {HTMLAnchorElement} */ (element("velocities-csv"));
  link.href = `data:text/csv;charset=utf-8,${encodeURIComponent(lines.join("\r\n"))}`;
  link.download = `${samples.name || "sweep"}_velocities.csv`;
  new ResizeObserver(drawSamples).observe(document.body);
}

beginSamples();
