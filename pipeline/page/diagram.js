/* The transition diagram: regions, boundary, band, and marks of points and tests. */

/** @type {{frame: Frame, root: SVGElement, pointer: SVGElement, choice: SVGElement}} */
let diagram;

/** Ends of an axis that contains the values, with a margin. @param {number[]} values */
function ends(values) {
  const { isLog } = view;
  const [low, high] = [Math.min(...values), Math.max(...values)];
  if (isLog) return { low: low / (high / low || 2) ** 0.04, high: high * (high / low || 2) ** 0.04, isLog };
  const room = 0.04 * (high - low || low || 1);
  return { low: low - room, high: high + room, isLog };
}

/** Axes that hold all values. @param {number[]} velocities @param {number[]} loads @param {Place[]} tests */
function planeAxes(velocities, loads, tests) {
  const width = Math.max(element("diagram").clientWidth, 280);
  const height = Math.round(Math.min(Math.max(0.72 * width, 300), 560));
  const x = { ...ends([...velocities, ...tests.map(({ velocity }) => velocity)]), ...view.x };
  const y = { ...ends([...loads, ...tests.map(({ load }) => load)]), ...view.y };
  return axes(width, height, { ...x, label: "sliding velocity [m/s]" }, { ...y, label: "normal load [N]" });
}

function drawDiagram() {
  const { velocities, loads, measured } = content;
  const { root, inside, frame } = planeAxes(velocities, loads, measured.filter(({ isDrawn }) => isDrawn));
  const label = "Points of the sweep by velocity and load; arrow keys move, Enter keeps one";
  const about = { tabindex: 0, role: "application", "aria-label": label, "aria-describedby": "tip" };
  const { left, top, right, bottom } = frame;
  const size = { x: left, y: top, width: right - left, height: bottom - top }; // clipped here
  const drawn = [drawnBoundary, drawnMarks, drawnMeasured].flatMap((layer) => layer(frame));
  if (isInside(chosen, content)) drawn.push(cross(frame, chosen));
  inside.append(svg("svg", { ...size, viewBox: Object.values(size).join(" "), class: "view" }, ...drawn));
  const [pointer, choice] = ["pointer", "choice"].map((look) => svg("circle", { class: look, r: 8 }));
  filled(root, about, [pointer, choice]);
  element("diagram").replaceChildren(root, tip);
  diagram = { frame, root, pointer, choice };
  pointTo(null);
  ring(choice, chosen.point);
  listenToPoints(root);
}

/** Draw the regions of the next run, the boundaries, and the band that tests leave. @param {Frame} frame */
function drawnBoundary(frame) {
  if (!isJudged()) return [];
  const [x, y] = [content.fine.velocity.map(frame.x), content.fine.load.map(frame.y)];
  const shades = regions().map(([look, ...grids]) => svg("path", { class: look, d: contour(x, y, grids) }));
  const line = (/** @type {string} */ name, /** @type {number[][]} */ grid) =>
    svg("path", { class: name, d: contour(x, y, [grid], true) });
  const frictions = (content.friction_band ?? []).map((friction) =>
    line("friction", excess({ ...chosen.conditions, friction })));
  const hasTests = content.measured.some(({ friction }) => friction !== null);
  const tested = !hasTests ? [] : ["tested-band", "tested-line", "tested-band"].map((name, k) =>
    line(name, excess(chosen.conditions, (place) => levelAt(place, k))));
  const place = Math.min(x.length, y.length) < 2 ? drawnPlace(frame) : [];
  return [...shades, ...frictions, ...tested, line("boundary", excess(chosen.conditions)), ...place];
}

/** Regions where the next run is mild, severe or not decided: CSS class, and grids that are positive there.
 * @returns {[string, ...number[][][]][]} */
function regions() {
  const [{ conditions }, [mild, severe], { load, velocity }] = [chosen, content.decided, content.fine];
  const nodes = load.map((_, k) => velocity.map((_place, j) => marginAt([k, j], conditions)));
  const grid = (/** @type {(lowest: number, highest: number, verdict: string) => number} */ value) =>
    nodes.map((row) => row.map(({ y, probabilities: [lowest, , highest], verdict }) =>
      (Number.isNaN(y) || verdict === OUTSIDE ? NaN : value(lowest, highest, verdict))));
  // A test may forbid a verdict at a node where the probability alone would give it.
  const within = (/** @type {number} */ way, /** @type {boolean} */ isSo) =>
    (isSo ? way : Math.min(way, -1e-6));
  const isMild = grid((_, highest, verdict) => within(mild - highest, verdict === "mild"));
  const isSevere = grid((lowest, _, verdict) => within(lowest - severe, verdict === "severe"));
  const open = isMild.map((row, k) => row.map((value, j) => -Math.max(value, isSevere[k][j])));
  return [["mild", isMild], ["severe", isSevere], ["open", open]];
}

/** Draw the transition of a sweep that has a single load or velocity. @param {Frame} frame */
function drawnPlace(frame) {
  const { loads, velocities } = content;
  const places = [
    ...loads.map((load) => [frame.x(turnAt("velocity", load, chosen.conditions).place), frame.y(load)]),
    ...velocities.map((velocity) =>
      [frame.x(velocity), frame.y(turnAt("load", velocity, chosen.conditions).place)]),
  ];
  const known = places.filter((place) => place.every(Number.isFinite));
  return known.slice(0, 1).map(([cx, cy]) => svg("circle", { cx, cy, r: 4 }));
}

/** y minus a level at the nodes (load, velocity), finite without friction; NaN if unknown. @param
 * {Conditions} conditions @param {(place: Place) => number} level */
function excess(conditions, level = () => 0) {
  const plane = planeOf(conditions);
  return content.fine.load.map((load, k) => content.fine.velocity.map((velocity, j) =>
    Math.max(Math.min(plane[indexOf(k, j)] - level({ load, velocity }), 50), -50)));
}

/** Indices of all points. @returns {Point[]} */
function everyPoint() {
  return content.loads.flatMap((_load, i) => content.velocities.map((_velocity, j) => ({ i, j })));
}

/** Draw the marks of the points, with a ring if they carry a warning. @param {Frame} frame */
function drawnMarks(frame) {
  const r = content.loads.length * content.velocities.length < 1500 ? 3.4 : 2; // [px]; 4 in the legend
  return everyPoint().flatMap((point) => {
    const kind = kindOf(point);
    if (!kind) return [];
    const [x, y] = [frame.x(content.velocities[point.j]), frame.y(content.loads[point.i])];
    const isWarned = isDone(point) && content.messages[placeOf(point)];
    const signs = [sign(kind, x, y, r / 4)];
    return isWarned ? [sign("warned", x, y, (r + 3) / 6), ...signs] : signs;
  });
}

/** Draw the tests. @param {Frame} frame */
function drawnMeasured(frame) {
  return content.measured.filter(({ isDrawn }) => isDrawn).map((test) =>
    sign(test.sign, frame.x(test.velocity), frame.y(test.load)));
}
