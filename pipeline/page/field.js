/* ln(rise) on a fine grid, and where it passes each ln(limit): tables of Python, looked up. */

const [POINT_FAILED, COMPUTED] = ["2", "1"];

/** Index in a table, by load k and velocity j. @param {number} k @param {number} j */
function indexOf(k, j) {
  return k * content.fine.velocity.length + j;
}

/** True if a film carries too much at a node. @param {number} node */
function isFilm(node) {
  return content.film[node] === "1";
}

/** Indices of the load and velocity nearest to a place. @param {Place} place @returns {[number, number]} */
function nearestNode({ load, velocity }) {
  return [nearest(content.fine.load, load), nearest(content.fine.velocity, velocity)];
}

/** Pairs of index and weight of the tables by bulk ratio that conditions lie between. @param {Conditions}
 * conditions @returns {[number, number][]} */
function tablesOf(conditions) {
  return weights(content.bulk_ratios, heatOf(conditions).ratio);
}

/** Deciding rise at friction 1 at a node [K]. @param {number} node @param {Conditions} conditions */
function riseAt(node, conditions) {
  const { state: { length }, plane } = content;
  return sum(tablesOf(conditions).map(([table, weight]) => weight * Math.exp(plane[table * length + node])));
}

/** y = ln(rise/limit) at all nodes, by `indexOf`. @param {Conditions} conditions */
function planeOf(conditions) {
  const [key, limit] = [JSON.stringify(conditions), logLimit(conditions)];
  const plane = planes.get(key) ??
    Float64Array.from(content.state, (_, node) => Math.log(riseAt(node, conditions)) - limit);
  if (planes.size > 50) planes.clear();
  planes.set(key, plane);
  return plane;
}

/** ln of the rise above which wear is severe, at most a large number. @param {Conditions} conditions */
function logLimit(conditions) {
  return Math.min(Math.log(heatOf(conditions).limit), 99);
}

/** First place along an axis at which y passes a level, NaN without, and the outcome's code.
 * @param {AxisName} axis @param {number} at load or velocity on the other axis @param {Conditions}
 * conditions @param {number} [level] */
function turnAt(axis, at, conditions, level = 0) {
  const { targets, loads, velocities } = content;
  const { places, codes } = content.turns[axis];
  const rows = axis === "velocity" ? loads : velocities;
  const [target, beside] = [logLimit(conditions) + level, weights(rows, at)];
  const [near, tables] = [weights(targets, target), tablesOf(conditions)];
  const indices = tables.flatMap(([table, part]) => beside.flatMap(([row, share]) =>
    near.map(([k, weight]) => ({
      index: (table * rows.length + row) * targets.length + k, weight: part * share * weight,
    }))));
  const isBeyond = target < targets[0] || target > targets[targets.length - 1];
  const found = sum(indices.map(({ index, weight }) => weight * Math.log(places[index])));
  const place = isBeyond ? NaN : Math.exp(found);
  // A neighbour without a place says why there is none.
  const like = indices.filter(({ index }) => Number.isNaN(places[index]) === Number.isNaN(place));
  const [main] = (like.length ? like : indices).sort((a, b) => b.weight - a.weight);
  return { place, outcome: Number(codes[main.index]) };
}
