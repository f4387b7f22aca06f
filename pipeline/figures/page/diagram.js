// @ts-check
"use strict";
/* The transition diagram: regions, boundary, band, and the marks of points and measurements. */

/** @type {{frame: Frame, root: SVGElement, shades: SVGElement, lines: SVGElement, pointer: SVGElement,
 *  choice: SVGElement} | null} */
let diagram = null;

/** @type {[string, string][]} */
const KINDS = [
  ["mild", "mild wear, computed"],
  ["severe", "severe wear, computed"],
  ["mixed", "severe on some"],
  ["unjudged", "computed"],
  ["failed", "failed"],
  ["pending", "pending"],
];

/** Ends of an axis that holds some values, with room about them. @param {number[]} values */
function ends(values) {
  const [low, high] = [Math.min(...values), Math.max(...values)];
  const room = 0.04 * (high - low || low || 1);
  return { low: low - room, high: high + room };
}

/** Velocities and loads that the diagram holds: of several wear rates the velocities that all have. */
function extent() {
  const { velocities, wear_rates: rates, conditions } = content;
  const { wear_rate = NaN } = conditions;
  const [low, high] = [velocities.find((velocity) => velocity > 0) ?? 0, velocities.slice(-1)[0]];
  const common = rates.length
    ? [(low * wear_rate) / rates[0], (high * wear_rate) / rates.slice(-1)[0]]
    : velocities;
  return {
    velocities: [...common, ...content.measured.map(({ velocity }) => velocity)],
    loads: [...sweep.loads, ...content.measured.map(({ normal_load }) => normal_load)],
  };
}

/** Draw the parts that do not follow the conditions: axes, and rings about points. */
function makeDiagram() {
  const room = element("diagram");
  const width = Math.max(room.clientWidth, 280);
  const { velocities, loads } = extent();
  const x = { ...ends(velocities), label: "sliding velocity [m/s]" };
  const y = { ...ends(loads), label: "normal load [N]" };
  const height = Math.round(Math.min(Math.max(0.72 * width, 300), 560));
  const { root, inside, frame } = axes(width, height, x, y);
  const label = "Points of the sweep by velocity and load; arrow keys move, Enter keeps one";
  const about = { tabindex: 0, role: "application", "aria-label": label, "aria-describedby": "tip" };
  for (const [name, value] of Object.entries(about)) root.setAttribute(name, String(value));
  const [shades, lines] = [svg("g"), svg("g")];
  const { left, top, right, bottom } = frame;
  const size = { x: left, y: top, width: right - left, height: bottom - top };
  const viewBox = Object.values(size).join(" ");
  const view = svg("svg", { ...size, viewBox, class: "view" }, shades, lines);
  inside.append(view); // cut off where another wear rate has velocities beyond
  const pointer = svg("circle", { class: "pointer", r: 8, display: "none" });
  const choice = svg("circle", { class: "choice", r: 8, display: "none" });
  root.append(pointer, choice);
  room.replaceChildren(root, tip);
  diagram = { frame, root, shades, lines, pointer, choice };
  pointTo(null);
  ring(choice, chosen.point);
  listenToPoints(root);
}

/** Draw the parts that follow the conditions. */
function drawDiagram() {
  if (!diagram) return;
  const { frame, shades, lines } = diagram;
  shades.replaceChildren(...drawnShades(frame));
  lines.replaceChildren(
    ...drawnLines(frame), ...drawnMarks(frame), ...drawnMeasured(frame), ...drawnPlace(frame),
  );
}

/** Mild and severe regions, and the bands over surfaces and frictions. @param {Frame} frame */
function drawnShades(frame) {
  if (!isJudged() || Math.min(sweep.loads.length, sweep.velocities.length) < 2) return [];
  const [slowest, fastest] = [sweep.velocities[0], sweep.velocities[sweep.velocities.length - 1]];
  // Beyond the sweep the boundary is drawn along its end.
  const edgesAt = (/** @type {number} */ friction) =>
    sweep
      .drawn(surfaces(), { ...chosen.conditions, friction })
      .map((all) => all.map((velocity) => Math.min(Math.max(velocity, slowest), fastest)));
  const edges = edgesAt(chosen.conditions.friction);
  const middle = edges[edges.length >> 1];
  const shades = [];
  if (!content.chosen) {
    shades.push(area(frame, middle.map(() => slowest), middle, "mild"));
    shades.push(area(frame, middle, middle.map(() => fastest), "severe"));
  }
  if (content.friction_band) {
    const [upper, lower] = content.friction_band.map(edgesAt).map((lines) => lines[lines.length >> 1]);
    shades.push(area(frame, lower, upper, "friction"));
  }
  if (edges.length > 1) shades.push(area(frame, edges[0], edges[2], "band"));
  if (!content.chosen) {
    shades.push(...regionName(frame, middle.map(() => slowest), middle, "mild"));
    shades.push(...regionName(frame, middle, middle.map(() => fastest), "severe"));
  }
  return shades;
}

/**
 * Name of a region between two velocities, where it is roomiest; none where it does not fit.
 * @param {Frame} frame @param {number[]} low @param {number[]} high @param {"mild" | "severe"} kind
 */
function regionName(frame, low, high, kind) {
  const words = content.regions[kind === "mild" ? 0 : 1];
  const parts = content.parts.load;
  const places = sweep.fine.load.map((load, k) => {
    const [left, right, y] = [frame.x(low[k]), frame.x(high[k]), frame.y(load)];
    const isBetweenRows = k % parts === parts >> 1;
    const room = Math.min((right - left) / (8 * words.length), (frame.bottom - y) / 24, (y - frame.top) / 24);
    return { x: (left + right) / 2, y: y + 4, room: (isBetweenRows && room) || 0 };
  });
  const best = places.reduce((one, other) => (other.room > one.room ? other : one));
  if (!(best.room > 1)) return [];
  return [svg("text", { x: best.x, y: best.y, class: `region region-${kind}` }, words)];
}

/**
 * Area between two velocities at each of the fine loads, where both are known and apart.
 * @param {Frame} frame @param {number[]} low @param {number[]} high @param {string} look
 */
function area(frame, low, high, look) {
  const y = sweep.fine.load.map(frame.y);
  const isApart = (/** @type {number} */ k) => [k - 1, k, k + 1].some((next) => high[next] > low[next]);
  let text = "";
  for (let k = 0; k < y.length; k++) {
    let end = k;
    while (end < y.length && Number.isFinite(high[end] - low[end]) && isApart(end)) end++;
    const across = [...low.slice(k, end), ...high.slice(k, end).reverse()].map(frame.x);
    const up = [...y.slice(k, end), ...y.slice(k, end).reverse()];
    if (end > k + 1) text += `${path(across, up)}Z`;
    k = end;
  }
  return svg("path", { class: look, d: text });
}

/** The boundary: on one surface, or the median over them. @param {Frame} frame */
function drawnLines(frame) {
  if (!isJudged()) return [];
  const edges = sweep.drawn(surfaces(), chosen.conditions);
  const points = [
    ...edges[edges.length >> 1].map((velocity, i) => [velocity, sweep.fine.load[i]]),
    ...summary().load.map(({ middle }, j) => [sweep.velocities[j], middle]),
  ];
  const finite = points.filter((point) => point.every(Number.isFinite)).sort((a, b) => a[0] - b[0]);
  if (finite.length === 1) {
    const [[velocity, load]] = finite;
    return [svg("circle", { cx: frame.x(velocity), cy: frame.y(load), r: 4 })];
  }
  const [x, y] = [finite.map(([velocity]) => frame.x(velocity)), finite.map(([, load]) => frame.y(load))];
  return [svg("path", { class: "boundary", d: path(x, y) })];
}

/** Indices of all points. */
function everyPoint() {
  return sweep.loads.flatMap((_load, i) => sweep.velocities.map((_velocity, j) => ({ i, j })));
}

/** Marks of the points, ringed where they carry a warning. @param {Frame} frame */
function drawnMarks(frame) {
  const r = sweep.loads.length * sweep.velocities.length < 1500 ? 3.4 : 2;
  return everyPoint().flatMap(({ i, j }) => {
    const kind = kindOf(i, j);
    if (!kind) return [];
    const [x, y] = [frame.x(sweep.velocities[j]), frame.y(sweep.loads[i])];
    const rings = hasWarning(i, j) ? [svg("circle", { class: "ring", cx: x, cy: y, r: r + 3 })] : [];
    return [...rings, mark(kind, x, y, r)];
  });
}

/**
 * Measured transitions and tests, each beside the transition computed at its own conditions.
 * @param {Frame} frame
 */
function drawnMeasured(frame) {
  return content.measured.flatMap((measurement) => {
    const [x, y] = [frame.x(measurement.velocity), frame.y(measurement.normal_load)];
    const expected = frame.x(expectedVelocity(measurement));
    const mark = testMark(x, y, measurement.outcome);
    if (!hasOwnConditions(measurement)) return [mark];
    if (!Number.isFinite(expected)) return [mark];
    const line = svg("path", { class: "own", d: `M${x},${y}H${expected}` });
    return [line, diamond(expected, y, 4.5, "expected"), mark];
  });
}

/** The operating point. @param {Frame} frame */
function drawnPlace(frame) {
  if (!isInside()) return [];
  return [cross(frame.x(chosen.velocity), frame.y(chosen.load))];
}

/**
 * Signs of measured transitions and of tests, in words.
 * @param {Measurement[]} tests @returns {[boolean, string, SVGElement][]}
 */
function testSigns(tests) {
  const kinds = /** @type {["mild" | "severe" | undefined, string][]} */ ([
    [undefined, "measured transition"], ["mild", "test: mild wear"], ["severe", "test: severe wear"],
  ]);
  return kinds.map(([kind, words]) => {
    const isThere = tests.some(({ outcome }) => outcome === kind);
    return [isThere, words, testMark(13, 7, kind)];
  });
}

/** Signs of the diagram, in words. */
function showLegend() {
  const box = (/** @type {string} */ look) => svg("rect", { class: look, width: 26, height: 14 });
  const line = (/** @type {string} */ look, /** @type {string} */ d) => svg("path", { class: look, d });
  /** @type {Set<string>} */
  const kinds = new Set(everyPoint().map(({ i, j }) => kindOf(i, j)));
  const isWarned = everyPoint().some(({ i, j }) => hasWarning(i, j));
  const count = surfaces().length;
  const drawn = line("boundary", "M0,7H26");
  const { friction_band: band, measured } = content;
  /** @type {[boolean | number | string, string, SVGElement][]} */
  const signs = [
    [isJudged(), `${count > 1 ? "transition, median" : "computed transition"}${bridgedLoads()}`, drawn],
    [isJudged() && count > 1, `${100 * BAND[0]} to ${100 * BAND[2]} % of ${count}`, box("band")],
  ];
  const frictions = band ? band.map((end) => shown(end)).join(" to ") : "";
  const cut = isJudged() ? loadsBeyond(band ?? []) : 0;
  const beyond = cut ? `, beyond what was computed at ${cut} of ${sweep.loads.length} loads` : "";
  signs.push([frictions && isJudged(), `transition at friction ${frictions}${beyond}`, box("friction")]);
  for (const [kind, words] of KINDS) signs.push([kinds.has(kind), words, mark(kind, 13, 7, 4)]);
  signs.push(
    [isWarned, "carries a warning", svg("circle", { class: "ring", cx: 13, cy: 7, r: 6 })],
    ...testSigns(measured),
    [
      isJudged() && measured.some(hasOwnConditions),
      "computed at the test’s own conditions",
      diamond(13, 7, 5, "expected"),
    ],
    [isInside(), "operating point", line("operating", "M5,7h16M13,-1v16")],
  );
  showSigns(signs);
}

/**
 * Show those signs that are there, in words.
 * @param {[boolean | number | string, string, SVGElement][]} signs
 */
function showSigns(signs) {
  const items = signs.filter(([isThere]) => isThere).map(([, words, sign]) =>
    html("li", {}, svg("svg", { "aria-hidden": "true", viewBox: "0 0 26 14" }, sign), words),
  );
  element("legend").replaceChildren(...items);
}
