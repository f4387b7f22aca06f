// @ts-check
"use strict";
/* The transition diagram: regions, boundary, band, and the marks of points and measurements. */

/** @type {{frame: Frame, root: SVGElement, pointer: SVGElement, choice: SVGElement}} */
let diagram;
/** @type {("mild" | "severe" | "mixed" | "unjudged" | "failed" | "pending")[]} */
const KINDS = ["mild", "severe", "mixed", "unjudged", "failed", "pending"];

/** Ends of an axis that holds some values, with room about them. @param {number[]} values */
function ends(values) {
  const [low, high] = [Math.min(...values), Math.max(...values)];
  const room = 0.04 * (high - low || low || 1);
  return { low: low - room, high: high + room };
}

/**
 * Axes of a diagram that holds these places and tests.
 * @param {number[]} velocities @param {number[]} loads @param {Measurement[]} tests
 */
function planeAxes(velocities, loads, tests) {
  const width = Math.max(element("diagram").clientWidth, 280);
  const height = Math.round(Math.min(Math.max(0.72 * width, 300), 560));
  const x = ends([...velocities, ...tests.map(({ velocity }) => velocity)]);
  const y = ends([...loads, ...tests.map(({ normal_load }) => normal_load)]);
  return axes(width, height, { ...x, label: "sliding velocity [m/s]" }, { ...y, label: "normal load [N]" });
}

function drawDiagram() {
  const { velocities, loads, measured } = content;
  const { root, inside, frame } = planeAxes(velocities, loads, measured);
  const label = "Points of the sweep by velocity and load; arrow keys move, Enter keeps one";
  const about = { tabindex: 0, role: "application", "aria-label": label, "aria-describedby": "tip" };
  for (const [name, value] of Object.entries(about)) root.setAttribute(name, String(value));
  const { left, top, right, bottom } = frame;
  const size = { x: left, y: top, width: right - left, height: bottom - top };
  const viewBox = Object.values(size).join(" ");
  const layers = [drawnShades, drawnLines, drawnMarks, drawnMeasured];
  const drawn = layers.flatMap((layer) => layer(frame));
  if (isInside(chosen, sweep)) drawn.push(cross(frame, chosen));
  inside.append(svg("svg", { ...size, viewBox, class: "view" }, ...drawn)); // cut off at its frame
  const [pointer, choice] = ["pointer", "choice"].map((look) => svg("circle", { class: look, r: 8 }));
  root.append(pointer, choice);
  element("diagram").replaceChildren(root, tip);
  diagram = { frame, root, pointer, choice };
  pointTo(null);
  ring(choice, chosen.point);
  listenToPoints(root);
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
  const name = content.regions[kind === "mild" ? 0 : 1];
  const parts = content.parts.load;
  const between = sweep.fine.load.map((_, k) => k).filter((k) => k % parts === parts >> 1);
  for (const lines of [[name], name.split(/ (?=\()/)]) { // in one line, or in two
    const [width, height] = [8 * Math.max(...lines.map((words) => words.length)), 8 + 16 * lines.length];
    const places = between.map((k) => {
      const [left, right, y] = [frame.x(low[k]), frame.x(high[k]), frame.y(sweep.fine.load[k])];
      const room = Math.min((right - left) / width, (frame.bottom - y) / height, (y - frame.top) / height);
      return { x: (left + right) / 2, y: y + 12 - 8 * lines.length, room: room || 0 };
    });
    const best = places.sort((one, other) => other.room - one.room)[0];
    if (best?.room > 1) {
      const spans = lines.map((words, k) => svg("tspan", { x: best.x, y: best.y + 16 * k }, words));
      return [svg("text", { class: `region region-${kind}` }, ...spans)];
    }
  }
  return [];
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

/**
 * All points about a point have its own kind of wear.
 * @param {string[][]} kinds @param {number} i @param {number} j
 */
function isFar(kinds, i, j) {
  const about = kinds.slice(Math.max(i - 1, 0), i + 2).flatMap((row) => row.slice(Math.max(j - 1, 0), j + 2));
  const isJudged = kinds[i][j] === "mild" || kinds[i][j] === "severe";
  return isJudged && about.every((kind) => kind === kinds[i][j]);
}

/**
 * Marks of the points: faint far from the boundary, ringed where they carry a warning.
 * @param {Frame} frame
 */
function drawnMarks(frame) {
  const r = sweep.loads.length * sweep.velocities.length < 1500 ? 3.4 : 2;
  const kinds = sweep.loads.map((_load, i) => sweep.velocities.map((_velocity, j) => kindOf(i, j)));
  const all = kinds.flat();
  const isCrossed = all.includes("mild") && all.includes("severe");
  return everyPoint().flatMap(({ i, j }) => {
    const kind = kinds[i][j];
    if (!kind) return [];
    const [x, y] = [frame.x(sweep.velocities[j]), frame.y(sweep.loads[i])];
    const rings = hasWarning(i, j) ? [svg("circle", { class: "ring", cx: x, cy: y, r: r + 3 })] : [];
    const drawn = mark(kind, x, y, r);
    drawn.classList.toggle("is-far", isCrossed && isFar(kinds, i, j));
    return [...rings, drawn];
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
    const sign = testMark(x, y, measurement.outcome);
    const at = y - 18 < frame.top ? y + 17 : y - 11;
    const mark = hasDrawnBulk(measurement) ? sign : faintTest(sign, x, at, conditionsOf(measurement));
    if (!hasOwnConditions(measurement) || !Number.isFinite(expected)) return [mark];
    const line = svg("path", { class: "own", d: `M${x},${y}H${expected}` });
    return [line, diamond(expected, y, 4.5, "expected"), mark];
  });
}

/**
 * The mark of a test at another bulk temperature than that of the diagram, with its own beside it.
 * @param {SVGElement} sign @param {number} x @param {number} y of the text @param {Conditions} own
 */
function faintTest(sign, x, y, { bulk_temperature: bulk }) {
  const words = svg("text", { x, y, class: "bulk-of-test" }, `${shown(bulk - ZERO_CELSIUS, 3)} °C`);
  return svg("g", { class: "is-far" }, sign, words);
}

/** Signs of measured transitions and of tests. @param {Measurement[]} tests */
function testSigns(tests) {
  const has = (/** @type {string | undefined} */ kind) => tests.some(({ outcome }) => outcome === kind);
  return { transition: has(undefined), "test-mild": has("mild"), "test-severe": has("severe") };
}

/** Show the signs of what the diagram holds, in words. */
function showLegend() {
  const kinds = new Set(everyPoint().map(({ i, j }) => kindOf(i, j)));
  const count = surfaces().length;
  const { friction_band: band, measured } = content;
  const bridged = summary().velocity.filter(({ transitions }) => bridgedText(transitions)).length;
  const across = bridged ? `, across points not done at ${bridged} of ${sweep.loads.length} loads` : "";
  const line = `${count > 1 ? "transition, median" : "computed transition"}${across}`;
  const cut = isCut(band ?? []) ? ", in part not computed" : "";
  const frictions = `transition at friction ${band?.map((end) => shown(end)).join(" to ")}${cut}`;
  showSigns({
    boundary: isJudged() && line,
    band: isJudged() && count > 1 && `${100 * BAND[0]} to ${100 * BAND[2]} % of ${count}`,
    friction: isJudged() && band !== null && frictions,
    ...Object.fromEntries(KINDS.map((kind) => [kind, kinds.has(kind)])),
    warned: everyPoint().some(({ i, j }) => hasWarning(i, j)),
    ...testSigns(measured),
    own: isJudged() && measured.some(hasOwnConditions),
    operating: isInside(chosen, sweep),
  });
}

/**
 * Show those signs of the legend that are there, some with words of their own.
 * @param {Object<string, boolean | string>} signs
 */
function showSigns(signs) {
  for (const [name, words] of Object.entries(signs)) {
    const sign = element(`sign-${name}`);
    sign.hidden = words === false;
    if (typeof words === "string") sign.lastChild?.replaceWith(words);
  }
}
