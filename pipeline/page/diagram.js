/* The transition diagram: regions, boundary, band, and marks of points and tests. */

/** @type {{frame: Frame, root: SVGElement, pointer: SVGElement, choice: SVGElement}} */
let diagram;

/** Ends of an axis that contains the values, with a margin. @param {number[]} values */
function ends(values) {
  const [low, high] = [Math.min(...values), Math.max(...values)];
  const room = 0.04 * (high - low || low || 1);
  return { low: low - room, high: high + room };
}

/** Axes that hold all values. @param {number[]} velocities @param {number[]} loads @param {Place[]} tests */
function planeAxes(velocities, loads, tests) {
  const width = Math.max(element("diagram").clientWidth, 280);
  const height = Math.round(Math.min(Math.max(0.72 * width, 300), 560));
  const x = ends([...velocities, ...tests.map(({ velocity }) => velocity)]);
  const y = ends([...loads, ...tests.map(({ load }) => load)]);
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

/** Draw the regions of the next run, the band over surfaces, and the boundaries. @param {Frame} frame */
function drawnBoundary(frame) {
  if (!isJudged()) return [];
  const [x, y] = [content.inner.map(frame.x), content.fine.load.map(frame.y)];
  const negative = (/** @type {number[][]} */ grid) => grid.map((row) => row.map((value) => -value));
  const middle = excess(0.5, chosen.conditions);
  /** @type {[string, ...number[][][]][]} */
  const parts = regions();
  if (surfaces().length > 1) {
    const [cold, , hot] = BAND.map((share) => excess(share, chosen.conditions));
    parts.push(["band", hot, negative(cold)]);
  }
  const shades = parts.map(([look, ...grids]) => svg("path", { class: look, d: contour(x, y, grids) }));
  const look = surfaces().length > 1 ? "boundary median" : "boundary";
  const line = (/** @type {string} */ name, /** @type {number[][]} */ grid) =>
    svg("path", { class: name, d: contour(x, y, [grid], true) });
  const frictions = (content.friction_band ?? []).map((friction) =>
    line("friction", excess(0.5, { ...chosen.conditions, friction })));
  const place = Math.min(x.length, y.length) < 2 ? drawnPlace(frame) : [];
  return [...shades, ...frictions, line(look, middle), ...place];
}

/** Regions where the next run is mild, severe or not decided: CSS class, and grids that are positive there.
 * @returns {[string, ...number[][][]][]} */
function regions() {
  const [{ conditions }, [mild, severe], own] = [chosen, content.decided, modelError()];
  const bounds = content.fine.load.map((_, k) => content.inner.map((_place, j) => {
    const { rises, probabilities } = marginAt([k, j + content.first], conditions, own, 1);
    if (rises.some(Number.isNaN)) return [NaN, NaN];
    return content.misfit ? [0, 1] : [probabilities[0], probabilities[2]];
  }));
  const grid = (/** @type {(lowest: number, highest: number) => number} */ value) =>
    bounds.map((row) => row.map(([lowest, highest]) => value(lowest, highest)));
  const [isMild, isSevere] = [grid((_, highest) => mild - highest), grid((lowest) => lowest - severe)];
  const open = grid((lowest, highest) => Math.min(highest - mild, severe - lowest));
  return [["mild", isMild], ["severe", isSevere], ["open", open]];
}

/** Draw the transition of a sweep that has a single load or velocity. @param {Frame} frame */
function drawnPlace(frame) {
  const { velocity, load } = boundaries();
  const places = [
    ...velocity.map(({ middle }, i) => [frame.x(middle), frame.y(content.loads[i])]),
    ...load.map(({ middle }, j) => [frame.x(content.velocities[j]), frame.y(middle)]),
  ];
  const known = places.filter((place) => place.every(Number.isFinite));
  return known.slice(0, 1).map(([cx, cy]) => svg("circle", { cx, cy, r: 4 }));
}

/** Quantile over surfaces of ln(rise/limit) at the nodes (load, velocity); NaN if unknown. @param {number}
 * share @param {Conditions} conditions */
function excess(share, conditions) {
  const [plane, limit, { load, velocity }] = [knownPlane(conditions), heatOf(conditions).limit, content.fine];
  const isThere = load.map((_, k) => surfaces().filter((surface) =>
    velocity.some((_place, j) => !Number.isNaN(plane[indexOf(surface, k, j)]))));
  return load.map((_, k) => content.inner.map((_place, j) => {
    const all = isThere[k].map((surface) => Math.log(plane[indexOf(surface, k, j + content.first)] / limit));
    /** @type {Ends[]} */
    const ways = all.map((one) => (Number.isNaN(one) ? [-Infinity, Infinity] : [one, one]));
    return Math.max(Math.min(quantileOfEnds(ways, share), 50), -50); // finite without friction
  }));
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
    const isWarned = risesAt(point).length && messagesOf(point).length;
    const signs = [sign(kind, x, y, r / 4)];
    return isWarned ? [sign("warned", x, y, (r + 3) / 6), ...signs] : signs;
  });
}

/** True if a test's own conditions give another transition than that drawn. @param {Measurement} test */
function hasOwnConditions({ own, node: [, j] }) {
  const there = { ...chosen.conditions, ...own };
  const factor = own.strip_friction ? content.friction_factors[j] : 1;
  return Math.abs((heatOf(there).limit / heatOf(chosen.conditions).limit) * factor - 1) > 0.02;
}

/** Draw the tests, each with the transition computed at its own conditions. @param {Frame} frame */
function drawnMeasured(frame) {
  const judged = judgedTests();
  return content.measured.flatMap((test, number) => {
    if (!test.isDrawn) return [];
    const [x, y] = [frame.x(test.velocity), frame.y(test.load)];
    const expected = frame.x(judged[number].expected);
    const signs = [sign(test.sign, x, y)];
    if (!hasOwnConditions(test) || !Number.isFinite(expected)) return signs;
    const line = svg("path", { class: "own", d: `M${x},${y}H${expected}` });
    return [line, sign("own", expected, y, 0.9), ...signs];
  });
}
