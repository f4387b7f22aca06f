// @ts-check
"use strict";
/* The transition diagram: regions, boundary, band, and the marks of points and measurements. */

/** @type {{frame: Frame, shades: SVGElement, lines: SVGElement, targets: SVGElement[][]} | null} */
let diagram = null;

/** Ends of an axis that holds some values, with room about them. */
function ends(/** @type {number[]} */ values, isLog = false) {
  const [low, high] = [Math.min(...values), Math.max(...values)];
  if (isLog) {
    const factor = (high > low ? high / low : 2) ** 0.04;
    return { low: low / factor, high: high * factor, isLog: true };
  }
  const room = 0.04 * (high - low || low || 1);
  return { low: low - room, high: high + room };
}

/** Velocities of the sweep; where it answers for several wear rates those that all of them have. */
function commonVelocities() {
  const { velocities, wear_rates, conditions } = content;
  const { wear_rate = NaN } = conditions;
  if (!wear_rates.length) return velocities;
  const [low, high] = [velocities.find((velocity) => velocity > 0) ?? 0, velocities.slice(-1)[0]];
  return [(low * wear_rate) / wear_rates[0], (high * wear_rate) / wear_rates.slice(-1)[0]];
}

/** Velocities and loads that the diagram is to hold. */
function extent() {
  return {
    velocities: [...commonVelocities(), ...content.measured.map((at) => at.velocity)],
    loads: [...sweep.loads, ...content.measured.map((at) => at.normal_load)],
  };
}

/** Offer logarithmic axes, where all values have a logarithm. */
function makeScaleChoice() {
  const { velocities, loads } = extent();
  element("log-choice").hidden = Math.min(...velocities, ...loads) <= 0;
  input("log").checked = chosen.isLog;
  input("log").addEventListener("change", () => {
    chosen.isLog = input("log").checked;
    makeDiagram();
    update();
  });
}

/** Draw what does not follow the conditions: axes, and a target for each point. */
function makeDiagram() {
  const room = element("diagram");
  const width = Math.max(room.clientWidth, 280);
  const { velocities, loads } = extent();
  const { root, inside, frame } = axes(
    width,
    Math.round(Math.min(Math.max(0.72 * width, 300), 560)),
    {
      ...ends(velocities, chosen.isLog),
      label: "sliding velocity [m/s]",
    },
    {
      ...ends(loads, chosen.isLog),
      label: "normal load [N]",
    },
  );
  root.setAttribute("role", "group");
  root.setAttribute("aria-label", "Points of the sweep by velocity and load; arrow keys move");
  const shades = svg("g", { "aria-hidden": "true" });
  const lines = svg("g", { "aria-hidden": "true" });
  const { left, top, right, bottom } = frame;
  const size = { x: left, y: top, width: right - left, height: bottom - top };
  const viewBox = `${left} ${top} ${size.width} ${size.height}`;
  const view = svg("svg", { ...size, viewBox, class: "view" });
  view.append(shades, lines); // cut off where another wear rate has velocities beyond
  inside.append(view);
  const targets = sweep.loads.map((_load, i) =>
    sweep.velocities.map((_velocity, j) => target(frame, i, j)),
  );
  root.append(svg("g", {}, ...targets.flat()));
  room.replaceChildren(root, tip);
  diagram = { frame, shades, lines, targets };
  const { i, j } = chosen.point ?? nearest();
  targets[i][j].setAttribute("tabindex", "0");
}

/** Draw what follows the conditions. */
function drawDiagram() {
  if (!diagram) return;
  const { frame, shades, lines, targets } = diagram;
  shades.replaceChildren(...drawnShades(frame));
  const marks = drawnMarks(frame);
  lines.replaceChildren(...drawnLines(frame), ...marks, ...drawnMeasured(frame), ...drawnPlace(frame));
  targets.forEach((row, i) =>
    row.forEach((each, j) => {
      const x = frame.x(sweep.velocities[j]);
      const isThere = kindOf(i, j) && x >= frame.left && x <= frame.right;
      each.setAttribute("display", isThere ? "inline" : "none");
    }),
  );
}

/** Mild and severe regions, and the band over the surfaces. @param {Frame} frame */
function drawnShades(frame) {
  if (!isJudged() || Math.min(sweep.loads.length, sweep.velocities.length) < 2) return [];
  const { fine } = sweep.decisive(chosen.conditions);
  const [lowest, highest] = [sweep.loads[0], sweep.loads[sweep.loads.length - 1]];
  // What lies beyond the sweep is drawn to its end.
  const edgesAt = (/** @type {number} */ friction) =>
    sweep
      .drawn(chosen.surface, { ...chosen.conditions, friction })
      .map(({ loads }) => loads.map((load) => Math.min(Math.max(load, lowest), highest)));
  const edges = edgesAt(chosen.conditions.friction);
  const middle = edges[edges.length >> 1];
  const found = [];
  if (!content.chosen) {
    found.push(area(frame, fine, fine.map(() => lowest), middle, "mild"));
    found.push(area(frame, fine, middle, fine.map(() => highest), "severe"));
  }
  if (content.friction_band) {
    const [upper, lower] = content.friction_band.map(edgesAt).map((each) => each[each.length >> 1]);
    found.push(area(frame, fine, lower, upper, "friction"));
  }
  if (edges.length > 1) found.push(area(frame, fine, edges[0], edges[2], "band"));
  return found;
}

/** Area between two lines, where both are known and apart. */
function area(
  /** @type {Frame} */ frame,
  /** @type {number[]} */ x,
  /** @type {number[]} */ low,
  /** @type {number[]} */ high,
  /** @type {string} */ look,
) {
  // Between a value and the next; beyond the last there is nothing.
  const isApart = x.map((_, k) => Math.max(high[k] - low[k], high[k + 1] - low[k + 1]) > 0);
  let text = "";
  for (let k = 0; k < x.length; k++) {
    if (!isApart[k]) continue;
    let end = k;
    while (isApart[end]) end++;
    const there = x.slice(k, end + 1).map(frame.x);
    const up = high.slice(k, end + 1).map(frame.y);
    const down = low.slice(k, end + 1).map(frame.y);
    text += `${path([...there, ...there.slice().reverse()], [...up, ...down.reverse()])}Z`;
    k = end;
  }
  return svg("path", { class: look, d: text });
}

/** The boundary: on one surface, or the median over them. @param {Frame} frame */
function drawnLines(frame) {
  if (!isJudged()) return [];
  const { fine } = sweep.decisive(chosen.conditions);
  const edges = sweep.drawn(chosen.surface, chosen.conditions);
  const { loads, velocities } = edges[edges.length >> 1];
  const points = [
    ...fine.map((at, k) => [at, loads[k]]),
    ...sweep.loads.map((load, i) => [velocities[i], load]),
  ];
  const known = points.filter((at) => at.every(Number.isFinite)).sort((a, b) => a[0] - b[0]);
  if (known.length === 1) {
    const [[at, load]] = known;
    return [svg("circle", { cx: frame.x(at), cy: frame.y(load), r: 4 })];
  }
  const [x, y] = [0, 1].map((k) => known.map((at) => at[k]));
  return [svg("path", { class: "boundary", d: path(x.map(frame.x), y.map(frame.y)) })];
}

/** Marks of the points, ringed where they carry a warning. @param {Frame} frame */
function drawnMarks(frame) {
  const r = sweep.plane < 1500 ? 3.4 : 2;
  const found = [];
  for (let i = 0; i < sweep.loads.length; i++) {
    for (let j = 0; j < sweep.velocities.length; j++) {
      const kind = kindOf(i, j);
      if (!kind) continue;
      const [x, y] = [frame.x(sweep.velocities[j]), frame.y(sweep.loads[i])];
      if (hasWarning(i, j)) found.push(svg("circle", { class: "ring", cx: x, cy: y, r: r + 3 }));
      found.push(mark(kind, x, y, r));
    }
  }
  return found;
}

/** Measured transitions, each beside what is computed at its own friction. @param {Frame} frame */
function drawnMeasured(frame) {
  const found = [];
  for (const at of content.measured) {
    const [x, y] = [frame.x(at.velocity), frame.y(at.normal_load)];
    const expected = expectedVelocity(at);
    if (Number.isFinite(expected)) {
      const x2 = frame.x(expected);
      found.push(svg("line", { class: "own", x1: x, y1: y, x2, y2: y }));
      found.push(diamond(x2, y, 4.5, "expected"));
    }
    found.push(diamond(x, y, 6.5, "measured"));
  }
  return found;
}

/** The operating point. @param {Frame} frame */
function drawnPlace(frame) {
  if (!isInside()) return [];
  const [x, y] = [frame.x(chosen.velocity), frame.y(chosen.load)];
  return [svg("path", { class: "operating", d: `M${x - 9},${y}h18M${x},${y - 9}v18` })];
}

/** Signs of the diagram, in words. */
function showLegend() {
  const kinds = new Set();
  const several = surfaces().length > 1;
  let warned = false;
  for (let i = 0; i < sweep.loads.length; i++) {
    for (let j = 0; j < sweep.velocities.length; j++) {
      kinds.add(kindOf(i, j));
      warned = warned || hasWarning(i, j);
    }
  }
  /** @type {[string, SVGElement][]} */
  const signs = [];
  if (isJudged()) {
    const line = svg("path", { class: "boundary", d: "M0,7H26" });
    signs.push([several ? "transition, median" : "computed transition", line]);
    if (several) {
      const text = `${100 * BAND[0]} to ${100 * BAND[2]} % of ${surfaces().length}`;
      signs.push([text, svg("rect", { class: "band", width: 26, height: 14 })]);
    }
  }
  if (isJudged() && content.friction_band) {
    const span = content.friction_band.map((each) => shown(each)).join(" to ");
    signs.push([`transition at friction ${span}`, svg("rect", { class: "friction", width: 26, height: 14 })]);
  }
  for (const [kind, words] of KINDS) if (kinds.has(kind)) signs.push([words, mark(kind, 13, 7, 4)]);
  if (warned) signs.push(["carries a warning", svg("circle", { class: "ring", cx: 13, cy: 7, r: 6 })]);
  if (content.measured.length) {
    signs.push(["measured transition", diamond(13, 7, 6, "measured")]);
    if (isJudged()) signs.push(["computed at its own friction", diamond(13, 7, 5, "expected")]);
  }
  if (isInside()) signs.push(["operating point", svg("path", { class: "operating", d: "M5,7h16M13,-1v16" })]);
  element("legend").replaceChildren(
    ...signs.map(([words, sign]) =>
      html("li", {}, svg("svg", { "aria-hidden": "true", viewBox: "0 0 26 14" }, sign), words),
    ),
  );
}

/** @type {[string, string][]} */
const KINDS = [
  ["mild", "mild wear, computed"],
  ["severe", "severe wear, computed"],
  ["mixed", "severe on some"],
  ["unjudged", "computed"],
  ["failed", "failed"],
  ["pending", "pending"],
];
