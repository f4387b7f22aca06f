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

/** Axes of a diagram that holds these places and tests. @param {number[]} velocities @param {number[]} loads
 * @param {Measurement[]} tests */
function planeAxes(velocities, loads, tests) {
  const width = Math.max(element("diagram").clientWidth, 280);
  const height = Math.round(Math.min(Math.max(0.72 * width, 300), 560));
  const x = ends([...velocities, ...tests.map(({ velocity }) => velocity)]);
  const y = ends([...loads, ...tests.map(({ load }) => load)]);
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
  const layers = [drawnBoundary, drawnMarks, drawnMeasured];
  const drawn = layers.flatMap((layer) => layer(frame));
  if (isInside(chosen, content)) drawn.push(cross(frame, chosen));
  inside.append(svg("svg", { ...size, viewBox, class: "view" }, ...drawn)); // cut off at its frame
  const [pointer, choice] = ["pointer", "choice"].map((look) => svg("circle", { class: look, r: 8 }));
  root.append(pointer, choice);
  element("diagram").replaceChildren(root, tip);
  diagram = { frame, root, pointer, choice };
  pointTo(null);
  ring(choice, chosen.point);
  listenToPoints(root);
}

/** Mild and severe regions, bands over surfaces and frictions, and the boundary. @param {Frame} frame */
function drawnBoundary(frame) {
  if (!isJudged()) return [];
  const [x, y] = [inner().map(frame.x), content.fine.load.map(frame.y)];
  if (Math.min(x.length, y.length) < 2) return drawnPlace(frame);
  const middle = excess(0.5, chosen.conditions);
  /** @type {[string, ...number[][][]][]} */
  const parts = content.chosen ? [] : [["mild", negative(middle)], ["severe", middle]];
  if (content.friction_band) {
    const at = (/** @type {number} */ friction) => excess(0.5, { ...chosen.conditions, friction });
    const [cold, hot] = content.friction_band.map(at);
    parts.push(["friction", hot, negative(cold)]);
  }
  if (surfaces().length > 1) {
    const [cold, , hot] = BAND.map((share) => excess(share, chosen.conditions));
    parts.push(["band", hot, negative(cold)]);
  }
  const shades = parts.map(([look, ...grids]) => svg("path", { class: look, d: contour(x, y, grids) }));
  const d = contour(x, y, [middle], true);
  return d ? [...shades, svg("path", { class: "boundary", d })] : shades;
}

/** The transition of a sweep at one load or one velocity. @param {Frame} frame */
function drawnPlace(frame) {
  const { velocity, load } = boundaries();
  const places = [
    ...velocity.map(({ middle }, i) => [frame.x(middle), frame.y(content.loads[i])]),
    ...load.map(({ middle }, j) => [frame.x(content.velocities[j]), frame.y(middle)]),
  ];
  const [place] = places.filter((one) => one.every(Number.isFinite));
  return place ? [svg("circle", { cx: place[0], cy: place[1], r: 4 })] : [];
}

/** @param {number[][]} grid */
function negative(grid) {
  return grid.map((row) => row.map((value) => -value));
}

/** ln(rise/limit) at the nodes that a share of the surfaces stays below; NaN where not known. @param {number}
 * share @param {Conditions} conditions */
function excess(share, conditions) {
  const [plane, limit, { load, velocity }] = [knownPlane(conditions), riseLimit(conditions), content.fine];
  const isThere = load.map((_, k) => surfaces().filter((surface) =>
    velocity.some((_place, j) => !Number.isNaN(plane[indexOf(surface, k, j)]))));
  return load.map((_, k) => inner().map((_place, j) => {
    const all = isThere[k].map((surface) => Math.log(plane[indexOf(surface, k, j + content.first)] / limit));
    /** @type {Ends[]} */
    const ways = all.map((one) => (Number.isNaN(one) ? [-Infinity, Infinity] : [one, one]));
    return Math.max(Math.min(quantileOfEnds(ways, share), 50), -50); // finite without friction
  }));
}

/** Indices of all points. */
function everyPoint() {
  return content.loads.flatMap((_load, i) => content.velocities.map((_velocity, j) => ({ i, j })));
}

/** Marks of the points, ringed where they carry a warning. @param {Frame} frame */
function drawnMarks(frame) {
  const r = content.loads.length * content.velocities.length < 1500 ? 3.4 : 2;
  const kinds = content.loads.map((_load, i) => content.velocities.map((_velocity, j) => kindOf(i, j)));
  return everyPoint().flatMap(({ i, j }) => {
    const kind = kinds[i][j];
    if (!kind) return [];
    const [x, y] = [frame.x(content.velocities[j]), frame.y(content.loads[i])];
    const rings = hasWarning(i, j) ? [svg("circle", { class: "ring", cx: x, cy: y, r: r + 3 })] : [];
    return [...rings, mark(kind, x, y, r)];
  });
}

/** A test has another transition than the boundary that is drawn. @param {Measurement} test */
function hasOwnConditions({ own, node: [, j] }) {
  const there = { ...chosen.conditions, ...own };
  const factor = own.at_one_friction ? content.friction_factors[j] : 1;
  return Math.abs((riseLimit(there) / riseLimit(chosen.conditions)) * factor - 1) > 0.02;
}

/** Measured transitions and tests, each beside the transition computed at its own conditions. @param {Frame}
 * frame */
function drawnMeasured(frame) {
  const judged = judgedTests();
  return content.measured.flatMap((test, number) => {
    const [x, y] = [frame.x(test.velocity), frame.y(test.load)];
    const expected = frame.x(judged[number].expected);
    const sign = testMark(x, y, test.outcome);
    if (!hasOwnConditions(test) || !Number.isFinite(expected)) return [sign];
    const line = svg("path", { class: "own", d: `M${x},${y}H${expected}` });
    return [line, diamond(expected, y, 4.5, "expected"), sign];
  });
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
  const frictions = `transition at friction ${band?.map((end) => shown(end)).join(" to ")}`;
  showSigns({
    boundary: isJudged() && (count > 1 ? "transition, median" : "computed transition"),
    "region-mild": isJudged() && !content.chosen && content.regions[0],
    "region-severe": isJudged() && !content.chosen && content.regions[1],
    band: isJudged() && count > 1 && `${100 * BAND[0]} to ${100 * BAND[2]} % of ${count}`,
    friction: isJudged() && band !== null && frictions,
    ...Object.fromEntries(KINDS.map((kind) => [kind, kinds.has(kind)])),
    warned: everyPoint().some(({ i, j }) => hasWarning(i, j)),
    ...testSigns(measured),
    own: isJudged() && measured.some(hasOwnConditions),
    operating: isInside(chosen, content),
  });
}

/** Show those signs of the legend that are there, some with words of their own. @param {Object<string,
 * boolean | string>} signs */
function showSigns(signs) {
  for (const [name, words] of Object.entries(signs)) {
    const sign = element(`sign-${name}`);
    sign.hidden = words === false;
    if (typeof words === "string") sign.lastChild?.replaceWith(words);
  }
}
