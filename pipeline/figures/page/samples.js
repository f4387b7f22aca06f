// @ts-check
"use strict";
/* The page of a sweep of samples: probabilities of severe wear, which Python has tabulated. */

/**
 * @typedef {{name: string, measured: Measurement[], loads: number[], velocities: number[],
 *   probability: string, shares: number[], lines: number[][]}} Samples probabilities by load and
 *   velocity, and velocities by load and probability, within those computed
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

/** Mild and severe regions, the band of the boundary, and its median. @param {Frame} frame */
function drawnBand(frame) {
  const { loads, velocities } = samples;
  const ends = [velocities[0], velocities[velocities.length - 1]];
  const up = loads.map(frame.y);
  const [low, middle, high] = columns();
  const between = (/** @type {string} */ look, /** @type {number[]} */ from, /** @type {number[]} */ to) => {
    const across = [...from, ...to.slice().reverse()].map(frame.x);
    return svg("path", { class: look, d: `${path(across, [...up, ...up.slice().reverse()])}Z` });
  };
  const [left, right] = ends.map((end) => loads.map(() => end));
  const within = middle.map((place) => (ends.includes(place) ? NaN : frame.x(place)));
  return [
    between("mild", left, middle),
    between("severe", middle, right),
    between("band", low, high),
    svg("path", { class: "boundary", d: path(within, up) }),
  ];
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
  const box = (/** @type {string} */ look) => svg("rect", { class: look, width: 26, height: 14 });
  const [low, , high] = samples.shares;
  showSigns([
    [true, "as likely severe as mild", svg("path", { class: "boundary", d: "M0,7H26" })],
    [true, `severe with a probability of ${100 * low} to ${100 * high} %`, box("band")],
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
