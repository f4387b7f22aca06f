/* How likely the next run is severe at a node, and the verdict: looked up in what tests say. */

/** Pairs of index and weight of the tables by critical temperature. @param {Conditions} conditions */
function criticalsOf(conditions) {
  return weights(content.criticals, conditions.critical_temperature ?? NaN);
}

/** Pairs of index and weight of the tables of probabilities, at a place. @param {Conditions} conditions
 * @param {Place} place @returns {[number, number][]} */
function beliefsAt(conditions, place) {
  const { load, velocity } = content.supports;
  const [loads, velocities] = [weights(load, place.load), weights(velocity, place.velocity)];
  return criticalsOf(conditions).flatMap(([row, part]) => loads.flatMap(([k, high]) =>
    velocities.map(([j, fast]) =>
      /** @type {[number, number]} */ ([
        (row * load.length + k) * velocity.length + j, part * high * fast]))));
}

/** Probability of severe wear at y. @param {number} y @param {[number, number][]} beliefs */
function likelyAt(y, beliefs) {
  if (Number.isNaN(y)) return NaN;
  const { ys, likely } = content;
  const near = weights(ys, y);
  return sum(beliefs.flatMap(([row, part]) =>
    near.map(([k, weight]) => part * weight * likely[row * ys.length + k])));
}

/** y at which severe wear is 5, 50 or 95 % likely, at a place. @param {Place} place @param {number} k */
function levelAt(place, k) {
  return sum(beliefsAt(chosen.conditions, place).map(([row, weight]) => weight * content.levels[row][k]));
}

/** Whether tests forbid mild and severe wear at a node. @param {[number, number]} node @param {Conditions}
 * conditions */
function forbiddenAt([k, j], conditions) {
  const { fine, friction_factors: factors, no_mild: noMild, no_severe: noSevere } = content;
  const [[row]] = criticalsOf(conditions);
  const { friction, bulk_temperature: pin, disk_temperature: disk = pin } = conditions;
  const here = [fine.load[k], fine.velocity[j], friction * factors[j], pin, disk];
  const dominated = (/** @type {"mild" | "severe"} */ outcome, /** @type {number} */ sign) =>
    content.measured.some((test) => {
      if (!test.isAlike || (test.outcome !== outcome && test.outcome !== null)) return false;
      const place = outcome === "severe" ? test.places[test.places.length - 1] : test.places[0];
      const there = [...place, test.friction, ...test.bulks];
      const ways = here.map((value, n) => sign * (value - there[n]));
      const isLoose = test.outcome === null && test.places.length === 1;
      return ways.every((way) => way >= 0) && (!isLoose || ways.some((way) => way > 0));
    });
  return [noMild[row] || dominated("severe", 1), noSevere[row] || dominated("mild", -1)];
}

/** Margin at a node: y, its error, probabilities that the next run is severe, and the verdict.
 * @param {[number, number]} node @param {Conditions} conditions */
function marginAt([k, j], conditions) {
  const place = { load: content.fine.load[k], velocity: content.fine.velocity[j] };
  const [node, beliefs] = [indexOf(k, j), beliefsAt(conditions, place)];
  const [y, error] = [planeOf(conditions)[node], content.errors[node]];
  const likely = likelyAt(y, beliefs);
  const ends = Number.isNaN(error) ? [0, 1] : [y - error, y + error].map((end) => likelyAt(end, beliefs));
  const [noMild, noSevere] = forbiddenAt([k, j], conditions);
  const isMild = ends[1] <= content.decided[0] && !noMild;
  const isSevere = ends[0] >= content.decided[1] && !noSevere;
  const verdict = isFilm(node) ? OUTSIDE : isMild ? "mild" : isSevere ? "severe" : "not decided";
  return { y, error, probabilities: [ends[0], likely, ends[1]], verdict };
}
