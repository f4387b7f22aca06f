"use strict";
/* The verdict at a node: probability that the next run is severe, as pipeline.analysis.margin has it. */

/** Probability that the next run is severe, if all rises are larger by a factor. @param {number} k node
 * @param {number} j @param {Conditions} conditions @param {number} factor */
function likelihood(k, j, conditions, factor) {
  const [{ velocity }, { below }, limit] = [sweep.fine, modelError(), riseLimit(conditions) / factor];
  const share = (/** @type {number} */ place) => below(Math.log(place / velocity[j]));
  return sum(surfaces().flatMap((surface) => {
    const row = sweep.table("plane", conditions)[surface][k];
    const ranges = severeRanges(crossings(velocity, row, limit), beginsHot(row, limit));
    return ranges.map(([begin, end]) => share(end) - share(begin));
  })) / surfaces().length;
}

/** Verdict by the probabilities at the worst numerical errors. @param {number} lowest @param {number} highest
 * */
function verdictBetween(lowest, highest) {
  if (content.misfit) return "not decided";
  return highest <= content.decided[0] ? "mild" : lowest >= content.decided[1] ? "severe" : "not decided";
}

/** Nearest turns, infinite or 0 without any. @param {Transition[]} all @param {number} here */
function nearestTurns(all, here) {
  const away = (/** @type {number} */ place) => Math.abs(Math.log(place / here));
  return all.map(({ outcome, places }) => {
    if (outcome === MILD || outcome === ABOVE) return Infinity;
    if (outcome === SEVERE || outcome === BELOW) return 0;
    return places.reduce((one, other) => (away(other) < away(one) ? other : one), places[0] ?? NaN);
  });
}

/** What is known at a node. @param {[number, number]} node @param {Conditions} conditions */
function marginAt([k, j], conditions) {
  const rises = surfaces().map((surface) => sweep.table("plane", conditions)[surface][k][j]);
  const error = Math.max(...surfaces().map((surface) => sweep.errors[sweep.index(surface, k, j)]));
  const factors = [1 / (1 + error), 1, 1 + error];
  const [lowest, middle, highest] = factors.map((factor) => likelihood(k, j, conditions, factor));
  const probabilities = Number.isNaN(error) ? [0, middle, 1] : [lowest, middle, highest];
  return { rises, error, probabilities, verdict: verdictBetween(probabilities[0], probabilities[2]) };
}


/** Conditions of a test: friction and bulk of its own or of the scene, whatever the reader has set. A
 * friction of its own does not follow the scene's over velocity. @param {Measurement} test @returns
 * {Conditions} */
function conditionsOf({ friction, bulk_temperature: bulk }) {
  const { friction: usual, bulk_temperature, disk_temperature } = content.scene;
  const [pin, disk] = [bulk ?? bulk_temperature, bulk ?? disk_temperature];
  const at_one_friction = typeof friction === "number";
  const own = { ...chosen.conditions, friction: friction ?? usual, at_one_friction, bulk_temperature: pin };
  return disk_temperature === undefined ? own : { ...own, disk_temperature: disk };
}

/** A test has another transition than the boundary that is drawn. @param {Measurement} test */
function hasOwnConditions(test) {
  const own = conditionsOf(test);
  const [, j] = sweep.nearest(test);
  const factor = own.at_one_friction ? content.friction_factors[j] : 1;
  return Math.abs((riseLimit(own) / riseLimit(chosen.conditions)) * factor - 1) > 0.02;
}

/** Transitions at the load and the conditions of a test. @param {Measurement} test */
function transitionsOf(test) {
  const [k] = sweep.nearest(test);
  return surfaces().map((surface) => sweep.transition("velocity", surface, k, conditionsOf(test)));
}

/** Nearest velocity at which wear turns there. @param {Measurement} test */
function expectedVelocity(test) {
  return quantileOf(nearestTurns(transitionsOf(test), test.velocity), 0.5);
}

/** ln(measured/computed) of the tests that count, as pipeline.analysis.laboratory has them. */
function residuals() {
  const inside = content.measured.filter((test) => {
    const { critical_temperature, bulk_temperature: pin, disk_temperature: disk = pin } = conditionsOf(test);
    return (critical_temperature ?? 0) > Math.max(pin, disk) && isInside(test, sweep);
  });
  return inside.flatMap((test) => {
    const [[k, j], own] = [sweep.nearest(test), conditionsOf(test)];
    const hot = surfaces().filter((surface) => sweep.table("plane", own)[surface][k][j] > riseLimit(own));
    if (test.outcome && (test.outcome === "severe") === hot.length > surfaces().length / 2) return [];
    const computed = transitionsOf(test).map((one) => one.computed);
    const from = Math.min(...computed.map(([low]) => low));
    const to = Math.max(...computed.map(([, high]) => high));
    const critical = Math.min(Math.max(expectedVelocity(test), from), to); // or the end of the line
    return critical > 0 ? [Math.log(test.velocity / critical)] : [];
  });
}

/** The model's own error under the present conditions: its distribution, and in words. */
function modelError() {
  const { distances, below, base, weight, words } = content.model;
  const all = residuals();
  const n = all.length;
  const scale = Math.sqrt(base[n] + weight[n] * sum(all.map((one) => one * one)));
  return {
    below: (/** @type {number} */ distance) => linear(distances, below[n], distance / Math.max(scale, 1e-9)),
    words: n ? `± ${shown(100 * scale, 2)} % ${words[n]}` : words[0],
  };
}
