/* Probability that the next run is severe at a node: severe ranges weighed by the model's own error. */

/** Compare tests under their own conditions, as Python does; distance NaN if they may agree elsewhere. */
function judgedTests() {
  return content.measured.map((test) => {
    const [own, [k]] = [{ ...chosen.conditions, ...test.own }, test.node];
    const [all, limit] = [transitions("velocity", k, own), heatOf(own).limit];
    const turnOf = (/** @type {Transition} */ one) => nearestTurn(one, test.velocity, !test.outcome);
    const expected = medianTurn(all, turnOf);
    const whole = all.map((one, n) => (isFinite(turnOf(one)) ? one : goneOn(one, n, k, own)));
    const critical = medianTurn(whole, turnOf);
    const [from, to] = [0, 1].map((end) => all.map(({ computed }) => computed[end]));
    const velocity = Math.min(Math.max(test.velocity, Math.min(...from)), Math.max(...to));
    const at = surfaces().map((one) => indexOf(one, ...nearestNode({ load: test.load, velocity })));
    const isHot = at.filter((node) => planeOf(own)[node] > limit).length > at.length / 2;
    const isRight = test.outcome && (test.outcome === "severe") === isHot;
    const mayTurn = hasFrictionCurve(own) || isHot === test.velocity < velocity;
    const isTurn = !test.outcome && expected > 0 && expected < Infinity;
    const isKnown = test.isInside && limit > Math.abs(heatOf(own).ratio) && critical > 0 &&
      critical < Infinity && (isRight || isTurn || !mayTurn || test.velocity === velocity);
    const distance = isKnown ? Math.log(test.velocity / critical) : NaN;
    const side = isTurn ? "turn" : isRight ? "right" : distance > 0 ? "above" : "below";
    return { expected, distance, side, run: test.run };
  });
}

/** Add extrapolated changes of wear to a transition without any. @param {Transition} one @param
 * {number} surface @param {number} k of the load @param {Conditions} conditions @returns {Transition} */
function goneOn(one, surface, k, conditions) {
  const { velocity } = content.fine;
  const severe = rangesAbove(velocity, lineOf(surface, k, conditions), heatOf(conditions).limit);
  const places = severe.flat().filter((place) => place > 0 && place < Infinity);
  return places.length ? { ...one, severe, places } : one;
}

/** ln(measured/computed velocity) of transitions, and of wrong outcomes on either side: the farthest of each
 * run. */
function residuals() {
  const known = judgedTests().filter(({ distance }) => !Number.isNaN(distance));
  const farthest = (/** @type {string} */ side) => {
    const all = known.filter((one) => one.side === side);
    return [...new Set(all.map((one) => one.run ?? one))].map((key) =>
      all.filter((one) => (one.run ?? one) === key).map(({ distance }) => distance)
        .sort((a, b) => Math.abs(b) - Math.abs(a))[0]);
  };
  return { turn: farthest("turn"), below: farthest("below"), above: farthest("above"), known: known.length };
}

/** The model's own error under the chosen conditions: distribution function and words. */
function modelError() {
  const { distances, below, prior, worth, words, agreed } = content.model;
  const { turn, ...wrong } = residuals();
  const squares = (/** @type {number[]} */ of) => of.map((one) => one * one).sort((a, b) => b - a);
  const [told, degrees] = [worth * prior ** 2 + sum(squares(turn)), worth + turn.length];
  const scaleOf = (/** @type {number[]} */ others) => Math.sqrt(Math.max(...[0, ...others].map((_, k) =>
    (told + sum(squares(others).slice(0, k))) / (degrees + k))));
  const [low, high] = [scaleOf(wrong.below), scaleOf(wrong.above)];
  const [lower, upper] = [low, high].map((scale) => shown(100 * scale, 2));
  const size = lower === upper ? `± ${lower}` : `−${lower} to +${upper}`;
  const n = turn.length + wrong.below.length + wrong.above.length;
  return {
    below: (/** @type {number} */ distance) =>
      linear(distances, below[turn.length], distance / Math.max(distance > 0 ? low : high, 1e-9)),
    words: n ? `${size} % ${words[n]}` : wrong.known ? agreed : words[0],
  };
}

/** Margin at a node: rises, their error, probabilities that the next run is severe, and the verdict. The
 * error is the largest within some nodes, as it is smaller on a row of points than next to it.
 * @param {[number, number]} node @param {Conditions} conditions @param {{below: (way: number) => number}}
 * own the model's own error @param {number} beside number of nodes to each side */
function marginAt([k, j], conditions, { below } = modelError(), beside = 0) {
  const [plane, { velocity, load }] = [planeOf(conditions), content.fine];
  const lines = surfaces().map((surface) => lineOf(surface, k, conditions));
  const near = (/** @type {number} */ node, /** @type {number} */ first, /** @type {number} */ count) =>
    Array.from({ length: 2 * beside + 1 }, (_, n) => node + n - beside)
      .filter((other) => other >= first && other < first + count);
  const [rows, columns] = [near(k, 0, load.length), near(j, content.first, content.inner.length)];
  const error = Math.max(...surfaces().flatMap((surface) => rows.flatMap((row) =>
    columns.map((column) => content.errors[indexOf(surface, row, column)]))));
  const share = (/** @type {number} */ place) => below(Math.log(place / velocity[j]));
  const { limit } = heatOf(conditions);
  const probabilities = [1 / (1 + error), 1, 1 + error].map((factor) => sum(lines.map((line) => {
    const severe = rangesAbove(velocity, line, limit / factor);
    return sum(severe.map(([begin, end]) => share(end) - share(begin))) / lines.length;
  })));
  const [lowest, likely, highest] = Number.isNaN(error) ? [0, probabilities[1], 1] : probabilities;
  const isMild = highest <= content.decided[0];
  const isDecided = !content.misfit && (isMild || lowest >= content.decided[1]);
  const verdict = isDecided ? (isMild ? "mild" : "severe") : "not decided";
  const rises = surfaces().map((surface) => plane[indexOf(surface, k, j)]);
  return { rises, error, probabilities: [lowest, likely, highest], verdict };
}
