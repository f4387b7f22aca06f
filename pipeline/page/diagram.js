/* The transition diagram: regions, boundary, band, and marks of points and tests. */

/** @type {{frame: Frame, root: SVGElement, pointer: SVGElement}} */
let diagram;

/** Axis that contains the values, with a margin. @param {number[]} values @param {boolean} isLog */
function ends(values, isLog) {
  const [low, high] = [Math.min(...values), Math.max(...values)];
  if (isLog) return { low: low / (high / low || 2) ** 0.04, high: high * (high / low || 2) ** 0.04, isLog };
  const room = 0.04 * (high - low || low || 1);
  return { low: low - room, high: high + room, isLog };
}

/** Axes that hold all values. @param {number[]} velocities @param {number[]} loads @param {Place[]} tests */
function planeAxes(velocities, loads, tests) {
  const width = Math.max(element("diagram").clientWidth, 280);
  const height = Math.round(Math.min(Math.max(0.72 * width, 300), 560));
  const x = { ...ends([...velocities, ...tests.map(({ velocity }) => velocity)], view.isLog), ...view.x };
  const y = { ...ends([...loads, ...tests.map(({ load }) => load)], view.isLog), ...view.y };
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
  const pointer = svg("circle", { class: "pointer", r: 8 });
  filled(root, about, [hatch(), pointer]);
  const held = element("diagram").contains(document.activeElement) ? pointed : null;
  element("diagram").replaceChildren(root, tip);
  diagram = { frame, root, pointer };
  listenToPoints(root);
  if (held) root.focus({ preventScroll: true });
  pointTo(held);
}

/** Draw the regions of the next run, the boundaries, and the band that tests leave. @param {Frame} frame */
function drawnBoundary(frame) {
  if (!isJudged()) return [];
  const [x, y] = [content.fine.velocity.map(frame.x), content.fine.load.map(frame.y)];
  const line = (/** @type {string} */ look, /** @type {number[][]} */ grid) =>
    [look, contour(x, y, [grid], true)];
  const frictions = (content.friction_band ?? []).map((friction) =>
    line("friction", excess({ ...chosen.conditions, friction })));
  const hasTests = content.measured.some(({ friction }) => friction !== null);
  const tested = !hasTests ? [] : ["tested-band", "tested-line", "tested-band"].map((look, k) =>
    line(look, excess(chosen.conditions, (place) => levelAt(place, k))));
  const shades = regions().map(([look, ...grids]) => [look, contour(x, y, grids)]);
  const shapes = [...shades, ...frictions, ...tested, line("boundary", excess(chosen.conditions))];
  return shapes.filter(([, d]) => d).map(([look, d]) => svg("path", { class: look, d }));
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
  const outside = load.map((_, k) => velocity.map((_place, j) => (isFilm(indexOf(k, j)) ? 1 : -1)));
  return [["mild", isMild], ["severe", isSevere], ["open", open], ["outside", outside]];
}

/** y minus a level at the nodes (load, velocity), finite without friction; NaN if unknown, or where a film
 * carries too much. @param {Conditions} conditions @param {(place: Place) => number} level */
function excess(conditions, level = () => 0) {
  const plane = planeOf(conditions);
  return content.fine.load.map((load, k) => content.fine.velocity.map((velocity, j) => (isFilm(indexOf(k, j))
    ? NaN : Math.max(Math.min(plane[indexOf(k, j)] - level({ load, velocity }), 50), -50))));
}

/** Draw the marks of the points, with a ring if they carry a warning. @param {Frame} frame */
function drawnMarks(frame) {
  const { loads, velocities, messages } = content;
  const r = loads.length * velocities.length < 1500 ? 3.4 : 2; // [px]; 4 in the legend
  return loads.flatMap((load, i) => velocities.flatMap((velocity, j) => {
    const [x, y, kind] = [frame.x(velocity), frame.y(load), kindOf({ i, j })];
    if (!kind) return [];
    const isWarned = isDone({ i, j }) && messages[placeOf({ i, j })];
    return [...isWarned ? [sign("warned", x, y, (r + 3) / 6)] : [], sign(kind, x, y, r / 4)];
  }));
}

/** Draw the tests. @param {Frame} frame */
function drawnMeasured(frame) {
  return content.measured.filter(({ isDrawn }) => isDrawn).map((test) =>
    sign(test.sign, frame.x(test.velocity), frame.y(test.load)));
}
