"use strict";
/* The fine plane of the deciding rise that Python has tabulated, and where it passes a limit. */

const [POINT_DONE, POINT_FAILED] = ["1", "2"];
/** State of nodes between loads, one of which goes on beyond its points; before it are those within. */
const NODE_BETWEEN = "3";
const [CROSSES, MILD, SEVERE, UNKNOWN, ABOVE, BELOW, SEVERAL] = [0, 1, 2, 3, 4, 5, 6];

/** Number of a point. @param {number} surface @param {number} i of the load @param {number} j */
function placeOf(surface, i, j) {
  return (surface * content.loads.length + i) * content.velocities.length + j;
}

/** Number of a node. @param {number} surface @param {number} k of the load @param {number} j */
function indexOf(surface, k, j) {
  return (surface * content.fine.load.length + k) * content.fine.velocity.length + j;
}

/** Node of a velocity of the sweep. @param {number} j */
function nodeOf(j) {
  return content.first + j * content.parts.velocity;
}

/** Node nearest to a place. @param {{load: number, velocity: number}} place @returns {[number, number]} */
function nearestNode({ load, velocity }) {
  return [nearest(content.fine.load, load), content.first + nearest(inner(), velocity)];
}

/** Velocities of the nodes within the sweep; the others lie far beyond. */
function inner() {
  return content.fine.velocity.slice(content.first, nodeOf(content.velocities.length - 1) + 1);
}

/** Tables by bulk ratio and a last axis, weighed for the present ones. @param {Float32Array} table @param
 * {number} row @param {Conditions} conditions @param {number} width @param {[number, number][]} last */
function weighed(table, row, conditions, width, last) {
  const begin = row * width * content.bulk_ratios.length;
  return sum(weights(content.bulk_ratios, bulkRatio(conditions)).flatMap(([b, share]) =>
    last.map(([k, weight]) => share * weight * table[begin + b * width + k])));
}

/** Deciding rise at the nodes of all surfaces [K]. @param {Conditions} conditions */
function planeOf(conditions) {
  const { shares, friction_factors: factors, state } = content;
  const { failing_share, at_one_friction } = conditions;
  const last = weights(shares, failing_share);
  return kept(`${failing_share} ${bulkRatio(conditions)} ${at_one_friction}`, () =>
    Float64Array.from(state, (_, node) => weighed(tables.plane, node, conditions, shares.length, last) /
      (at_one_friction ? factors[node % factors.length] : 1)));
}

/** The same, NaN where not known: beyond points, or between loads at one of which wear does not turn within
 * them. @param {Conditions} conditions */
function knownPlane(conditions) {
  const [{ state, parts, fine }, plane, limit] = [content, planeOf(conditions), riseLimit(conditions)];
  const across = fine.velocity.length;
  const isTurning = (/** @type {number} */ row) => {
    const hot = fine.velocity.map((_, j) => row * across + j).filter((node) => state[node] < NODE_BETWEEN)
      .map((node) => plane[node] > limit);
    return hot.includes(true) && hot.includes(false);
  };
  return kept(JSON.stringify(conditions), () => {
    const turns = Array.from({ length: plane.length / across }, (_, row) => isTurning(row));
    return plane.map((rise, node) => {
      const row = Math.floor(node / across);
      const over = (row % fine.load.length) % parts.load;
      const isBridged = state[node] === NODE_BETWEEN && turns[row - over] && turns[row - over + parts.load];
      return isBridged || state[node] < NODE_BETWEEN ? rise : NaN;
    });
  });
}

/** Ranges in which values are above a limit, with ends between two nodes. @param {number[]} x @param
 * {ArrayLike<number>} y NaN where not known @param {number} limit @returns {Ends[]} */
function rangesAbove(x, y, limit) {
  const known = x.map((_, k) => k).filter((k) => !Number.isNaN(y[k]));
  const turns = known.slice(1).map((b, n) => [known[n], b]).filter(([a, b]) => y[a] > limit !== y[b] > limit)
    .map(([a, b]) => x[a] * (x[b] / x[a]) ** (Math.log(limit / y[a]) / Math.log(y[b] / y[a])));
  const all = y[known[0]] > limit ? [0, ...turns] : turns;
  return all.flatMap((begin, k) => (k % 2 ? [] : [[begin, all[k + 1] ?? Infinity]]));
}

/** Transition on each surface along velocity at a node of load, or along load at one of velocity; as
 * pipeline.analysis.transition has it. @param {AxisName} axis @param {number} node @param {Conditions}
 * conditions @returns {Transition[]} */
function transitions(axis, node, conditions) {
  const [known, limit] = [knownPlane(conditions), riseLimit(conditions)];
  const { fine, first, parts, range, columns, velocities } = content;
  return surfaces().map((surface) => {
    const own = columns[surface * velocities.length + (node - first) / parts.velocity] ?? NaN;
    const y = fine[axis].map((_, n) => known[
      axis === "velocity" ? indexOf(surface, node, n) : own >= 0 ? own + n : indexOf(surface, n, node)]);
    const x = fine[axis].filter((_, n) => !Number.isNaN(y[n]));
    const [from, to] = [x[0] ?? NaN, x[x.length - 1] ?? NaN];
    const severe = rangesAbove(fine[axis], y, limit);
    const places = severe.flat().filter((place) => place > 0 && place < Infinity);
    const isHot = severe[0]?.[0] === 0;
    let outcome = isHot ? (from <= range[axis][0] ? SEVERE : BELOW) : to >= range[axis][1] ? MILD : ABOVE;
    if (places.length) outcome = places.length > 1 || isHot ? SEVERAL : CROSSES;
    if (Number.isNaN(from + limit)) outcome = UNKNOWN;
    const none = outcome === UNKNOWN || outcome === SEVERAL;
    const least = none ? NaN : places[0] ?? (isHot ? -Infinity : outcome === ABOVE ? to : Infinity);
    const most = none ? NaN : places[0] ?? (isHot ? (outcome === BELOW ? from : -Infinity) : Infinity);
    return { severe, places, outcome, computed: [from, to], ends: [least, most] };
  });
}

/** Median over surfaces of the turns nearest to a place: infinite or 0 without any. @param {Transition[]} all
 * @param {number} here */
function nearestTurn(all, here) {
  const away = (/** @type {number} */ place) => Math.abs(Math.log(place / here));
  return quantileOf(all.map(({ places, severe, outcome }) =>
    [...places].sort((one, other) => away(one) - away(other))[0] ??
      (outcome === UNKNOWN ? NaN : severe.length ? 0 : Infinity)), 0.5);
}
