/* The fine plane of the deciding rise that Python has tabulated, and where it passes a limit. */

const [POINT_DONE, POINT_FAILED] = ["1", "2"];
/** State of nodes between loads, one of which goes on beyond its points; before it are those within. */
const NODE_BETWEEN = "3";
const [CROSSES, MILD, SEVERE, UNKNOWN, ABOVE, BELOW, SEVERAL] = [0, 1, 2, 3, 4, 5, 6];

/** Number of a node. @param {number} surface @param {number} k of the load @param {number} j */
function indexOf(surface, k, j) {
  return (surface * content.fine.load.length + k) * content.fine.velocity.length + j;
}

/** Node nearest to a place. @param {Place} place @returns {[number, number]} */
function nearestNode({ load, velocity }) {
  return [nearest(content.fine.load, load), content.first + nearest(content.inner, velocity)];
}

/** Entries of a row by bulk ratio and a last axis, and their weights. @param {Conditions} conditions @param
 * {number} width @param {[number, number][]} last */
function picksOf(conditions, width, last) {
  return weights(content.bulk_ratios, heatOf(conditions).ratio).flatMap(([b, share]) =>
    last.map(([k, weight]) => [b * width + k, share * weight]));
}

/** Deciding rise at the nodes of all surfaces [K]. @param {Conditions} conditions */
function planeOf(conditions) {
  const { plane, shares, bulk_ratios, friction_factors: factors, state } = content;
  const { failing_share, strip_friction } = conditions;
  const picks = picksOf(conditions, shares.length, weights(shares, failing_share));
  return kept(JSON.stringify([picks, strip_friction]), () => Float64Array.from(state, (_, node) => {
    const begin = node * shares.length * bulk_ratios.length;
    const rise = sum(picks.map(([k, weight]) => weight * plane[begin + k]));
    return strip_friction ? rise / factors[node % factors.length] : rise;
  }));
}

/** The same, NaN where not known: beyond points, or between loads at one of which wear does not turn within
 * them. @param {Conditions} conditions */
function knownPlane(conditions) {
  const [{ state, beside, fine }, plane, limit] = [content, planeOf(conditions), heatOf(conditions).limit];
  const across = fine.velocity.length;
  const isWithin = (/** @type {number} */ node) => state[node] < NODE_BETWEEN;
  const isTurning = (/** @type {number} */ row) => {
    const nodes = fine.velocity.map((_, j) => row * across + j).filter(isWithin);
    return new Set(nodes.map((node) => plane[node] > limit)).size > 1;
  };
  return kept(JSON.stringify(conditions), () => {
    const rows = state.includes(NODE_BETWEEN) ? plane.length / across : 0;
    const turns = Array.from({ length: rows }, (_, row) => isTurning(row));
    return plane.map((rise, node) => {
      if (isWithin(node)) return rise;
      const row = Math.floor(node / across);
      const isBridged = beside[row % beside.length].every((own) => turns[row - row % beside.length + own]);
      return state[node] === NODE_BETWEEN && isBridged ? rise : NaN;
    });
  });
}

/** Ranges in which values are above a limit, with ends between two nodes. @param {number[]} x @param
 * {ArrayLike<number>} y NaN where not known @param {number} limit @returns {Ends[]} */
function rangesAbove(x, y, limit) {
  const known = x.map((_, k) => k).filter((k) => !Number.isNaN(y[k]));
  const turns = known.slice(1).map((b, n) => [known[n], b]).filter(([a, b]) => y[a] > limit !== y[b] > limit)
    .map(([a, b]) => x[a] * (x[b] / x[a]) ** (Math.log(limit / y[a]) / Math.log(y[b] / y[a])));
  return rangesBetween(turns, y[known[0]] > limit);
}

/** Ranges of severe wear. @param {number[]} turns @param {boolean} isHot below them @returns {Ends[]} */
function rangesBetween(turns, isHot) {
  const all = isHot ? [0, ...turns] : turns;
  return all.flatMap((begin, k) => (k % 2 ? [] : [[begin, all[k + 1] ?? Infinity]]));
}

/** Transition on each surface along velocity at a node of load, or along load at one of velocity. @param
 * {AxisName} axis @param {number} node @param {Conditions} conditions @returns {Transition[]} */
function transitions(axis, node, conditions) {
  const [known, { limit }] = [knownPlane(conditions), heatOf(conditions)];
  const { fine, range, columns } = content;
  const turnsBack = axis === "velocity" && hasFrictionCurve && !conditions.strip_friction;
  return surfaces().map((surface) => {
    const own = axis === "load" ? columns[`${surface} ${node}`] : undefined;
    const y = fine[axis].map((_, n) => known[own !== undefined ? own + n
      : axis === "load" ? indexOf(surface, n, node) : indexOf(surface, node, n)]);
    const x = fine[axis].filter((_, n) => !Number.isNaN(y[n]));
    const [from, to] = [x[0] ?? NaN, x[x.length - 1] ?? NaN];
    const severe = rangesAbove(fine[axis], y, limit);
    const places = severe.flat().filter((place) => place > 0 && place < Infinity);
    const [isHot, isFirst, isLast] = [severe[0]?.[0] === 0, from <= range[axis][0], to >= range[axis][1]];
    const isWhole = turnsBack ? isFirst && isLast : isHot ? isFirst : isLast;
    let outcome = isHot ? (isWhole ? SEVERE : BELOW) : isWhole ? MILD : ABOVE;
    if (places.length) outcome = places.length > 1 || isHot ? SEVERAL : CROSSES;
    if (Number.isNaN(from + limit)) outcome = UNKNOWN;
    return { severe, places, outcome, computed: [from, to] };
  });
}

/** Least and greatest place that a transition may have. @param {Transition} transition @returns {Ends} */
function endsOf({ severe, outcome, computed: [from, to] }) {
  if (outcome === UNKNOWN) return [NaN, NaN];
  const first = severe.map(([begin]) => begin).find((begin) => begin > 0); // turn to severe wear
  if (outcome === CROSSES || outcome === SEVERAL) return [first ?? -Infinity, first ?? Infinity];
  if (outcome === MILD || outcome === ABOVE) return [outcome === MILD ? Infinity : to, Infinity];
  return [-Infinity, outcome === SEVERE ? -Infinity : from];
}

/** Turns of half of the surfaces, and if it begins severe. @param {Transition[]} all @returns {[number[],
 * boolean]} */
function halfTurns(all) {
  const turns = all.flatMap(({ severe }) => severe.flatMap(([begin, end]) => [[begin, 2], [end, -2]]));
  const begins = sum(turns.map(([place, step]) => (place === 0 ? step : 0))) - all.length;
  let [more, side, tied] = [begins, Math.sign(begins), NaN]; // of severe surfaces than of mild ones
  const places = turns.sort(([a], [b]) => a - b).flatMap(([place, step]) => {
    if (place === 0 || place === Infinity) return [];
    more += step;
    const [before, from] = [side, Number.isNaN(tied) ? place : tied];
    tied = more ? NaN : place;
    if (more) side = Math.sign(more);
    return before && side !== before ? [(from + place) / 2] : [];
  });
  return [places, (begins || side) >= 0];
}

/** Nearest of these turns, or one to severe wear; infinite or 0 without any. @param {Transition[]} all @param
 * {number} here @param {boolean} toSevere */
function nearestTurn(all, here, toSevere = false) {
  if (all.some(({ outcome }) => outcome === UNKNOWN)) return NaN;
  const [half, isHot] = halfTurns(all);
  const places = half.filter((_, k) => !toSevere || k % 2 === Number(isHot));
  const away = (/** @type {number} */ place) => Math.abs(Math.log(place / here));
  return places.sort((a, b) => away(a) - away(b))[0] ?? (isHot ? 0 : Infinity);
}
