/* The deciding rise on a fine grid, tabulated by Python, and where it crosses a limit. */

const [POINT_DONE, POINT_FAILED, NODE_EXTRAPOLATED] = ["1", "2", "3"]; // other nodes are below "3"

/** Index in a table, by load k, velocity j. @param {number} surface @param {number} k @param {number} j */
function indexOf(surface, k, j) {
  return (surface * content.fine.load.length + k) * content.fine.velocity.length + j;
}

/** Indices of the load and velocity nearest to a place. @param {Place} place @returns {[number, number]} */
function nearestNode({ load, velocity }) {
  return [nearest(content.fine.load, load), content.first + nearest(content.inner, velocity)];
}

/** Pairs of index and weight that interpolate a node's values between bulk ratios. @param {Conditions}
 * conditions @param {number} width values by ratio @param {[number, number][]} last pairs within them */
function picksOf(conditions, width, last) {
  return weights(content.bulk_ratios, heatOf(conditions).ratio).flatMap(([b, share]) =>
    last.map(([k, weight]) => [b * width + k, share * weight]));
}

/** Deciding rise [K] along velocity at load number k. @param {number} surface @param {number} k
 * @param {Conditions} conditions */
function lineOf(surface, k, conditions) {
  const begin = indexOf(surface, k, 0);
  return planeOf(conditions).subarray(begin, begin + content.fine.velocity.length);
}

/** Deciding rise [K] at all nodes, by `indexOf`. @param {Conditions} conditions */
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

/** `planeOf`, but NaN beyond the computed points, unless wear is certain at both loads beside the node: below
 * a lowest velocity at which it is mild, or above a highest at which it is severe.
 * @param {Conditions} conditions */
function knownPlane(conditions) {
  const [{ state, beside, fine }, plane, limit] = [content, planeOf(conditions), heatOf(conditions).limit];
  const across = fine.velocity.length;
  const isWithin = (/** @type {number} */ node) => state[node] < NODE_EXTRAPOLATED;
  const isCertain = (/** @type {number} */ row) => {
    const nodes = fine.velocity.map((_, j) => row * across + j);
    const [first, last] = [nodes.find(isWithin) ?? NaN, nodes.filter(isWithin).pop() ?? NaN];
    return nodes.map((node) => isWithin(node) || (last > first && // a single point tells of itself alone
      ((node < first && plane[first] <= limit) || (node > last && plane[last] > limit))));
  };
  return kept(JSON.stringify(conditions), () => {
    const rows = beside.map((_, row) => isCertain(row));
    return plane.map((rise, node) => {
      const [row, j] = [Math.floor(node / across), node % across];
      const isEnclosed = !hasFrictionCurve(conditions) && row < rows.length &&
        beside[row].every((own) => rows[own][j]);
      return isWithin(node) || isEnclosed ? rise : NaN;
    });
  });
}

/** Ranges in which values are above a limit; ends are interpolated. @param {number[]} x @param
 * {ArrayLike<number>} y NaN if unknown @param {number} limit @returns {Ends[]} */
function rangesAbove(x, y, limit) {
  const known = x.map((_, k) => k).filter((k) => !Number.isNaN(y[k]));
  const turns = known.slice(1).map((b, n) => [known[n], b]).filter(([a, b]) => y[a] > limit !== y[b] > limit)
    .map(([a, b]) => x[a] * (x[b] / x[a]) ** (Math.log(limit / y[a]) / Math.log(y[b] / y[a])));
  const all = y[known[0]] > limit ? [0, ...turns] : turns;
  return all.flatMap((begin, k) => (k % 2 ? [] : [[begin, all[k + 1] ?? Infinity]]));
}

/** Transitions of each surface along velocity at a load of the grid, or the reverse. @param
 * {AxisName} axis @param {number} node @param {Conditions} conditions @returns {Transition[]} */
function transitions(axis, node, conditions) {
  const [known, { limit }] = [knownPlane(conditions), heatOf(conditions)];
  const { fine, range, columns } = content;
  const turnsBack = axis === "velocity" && hasFrictionCurve(conditions);
  return surfaces().map((surface) => {
    const own = axis === "load" ? columns[`${surface} ${node}`] : undefined;
    const nodes = fine[axis].map((_, n) => own !== undefined ? own + n
      : axis === "load" ? indexOf(surface, n, node) : indexOf(surface, node, n));
    const y = nodes.map((place) => known[place]);
    const x = fine[axis].filter((_, n) => content.state[nodes[n]] < NODE_EXTRAPOLATED);
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

/** Lowest and highest possible value of a transition. @param {Transition} transition @returns {Ends} */
function endsOf({ severe, outcome, computed: [from, to] }) {
  if (outcome === UNKNOWN) return [NaN, NaN];
  if (outcome === MILD || outcome === ABOVE) return [outcome === MILD ? Infinity : to, Infinity];
  const [first] = severe[0];
  if (first) return [first, first];
  return [-Infinity, outcome === SEVERE ? -Infinity : from]; // severe at the lowest computed place
}

/** Lowest value at which wear turns severe; -Infinity if it is severe at the lowest, Infinity if never.
 * @param {Transition} transition */
function firstTurn({ severe }) {
  return severe.length ? severe[0][0] || -Infinity : Infinity;
}

/** Change of wear nearest to `here` by ratio, only to severe if `toSevere`; without one as `firstTurn`.
 * @param {Transition} transition @param {number} here @param {boolean} toSevere */
function nearestTurn(transition, here, toSevere) {
  const first = firstTurn(transition);
  const counted = transition.places.filter((_, k) => !toSevere || k % 2 === Number(first === -Infinity));
  const away = (/** @type {number} */ place) => Math.abs(Math.log(place / here));
  return counted.sort((a, b) => away(a) - away(b))[0] ?? first;
}

/** Median over surfaces of the value that `pick` finds; Infinity or 0 if half have none.
 * @param {Transition[]} all @param {(transition: Transition) => number} pick */
function medianTurn(all, pick) {
  if (all.some(({ outcome }) => outcome === UNKNOWN)) return NaN;
  return Math.max(quantileOf(all.map(pick), 0.5), 0) || 0; // NaN between infinite values of both signs
}
