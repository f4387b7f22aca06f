/* How likely the next run is severe at a node: the severe ranges about it, by the model's own error. */

/** Each test at its own conditions, as the command has it; no distance where what lies beyond may agree. */
function judgedTests() {
  return content.measured.map((test) => {
    const [own, [k]] = [{ ...chosen.conditions, ...test.own }, test.node];
    const [all, limit] = [transitions("velocity", k, own), heatOf(own).limit];
    const toSevere = !test.outcome || test.run !== undefined;
    const expected = medianTurn(all, (one) => nearestTurn(one, test.velocity, toSevere));
    const [from, to] = [0, 1].map((end) => all.map(({ computed }) => computed[end]));
    const within = (/** @type {number} */ x) => Math.min(Math.max(x, Math.min(...from)), Math.max(...to));
    const [critical, velocity] = [within(expected), within(test.velocity)];
    const at = surfaces().map((one) => indexOf(one, ...nearestNode({ load: test.load, velocity })));
    const isHot = at.filter((node) => planeOf(own)[node] > limit).length > at.length / 2;
    const isRight = test.outcome && (test.outcome === "severe") === isHot;
    const mayTurn = (hasFrictionCurve && !own.strip_friction) || isHot === test.velocity < velocity;
    const isTold = isRight || (!test.outcome && expected > 0 && expected < Infinity) || !mayTurn;
    const isKnown = test.isInside && limit > Math.abs(heatOf(own).ratio) && critical > 0 &&
      (isTold || test.velocity === velocity);
    const distance = isKnown ? Math.log(test.velocity / critical) : NaN;
    return { expected, distance, isWrong: !isRight, outcome: test.outcome, run: test.run };
  });
}

/** Residuals of runs: in the middle of two outcomes, else of the worst test that is wrong. */
function residuals() {
  const known = judgedTests().filter(({ distance }) => !Number.isNaN(distance));
  return [...new Set(known.map((one) => one.run ?? one))].flatMap((key) => {
    const run = known.filter((one) => (one.run ?? one) === key);
    const [mild, severe] = ["mild", "severe"].map((outcome) =>
      run.filter((one) => one.outcome === outcome).map(({ distance }) => distance));
    if (mild.length && severe.length) return (Math.max(...mild) + Math.min(...severe)) / 2;
    const wrong = run.filter(({ isWrong }) => isWrong).map(({ distance }) => distance);
    return wrong.sort((a, b) => Math.abs(b) - Math.abs(a)).slice(0, 1);
  });
}

/** The model's own error under the present conditions: its distribution, and in words. */
function modelError() {
  const [all, { distances, below, base, weight, words }] = [residuals(), content.model];
  const n = all.length;
  const scale = Math.sqrt(base[n] + weight[n] * sum(all.map((one) => one * one)));
  return {
    below: (/** @type {number} */ distance) => linear(distances, below[n], distance / Math.max(scale, 1e-9)),
    words: n ? `± ${shown(100 * scale, 2)} % ${words[n]}` : words[0],
  };
}

/** What is known at a node: rises, their error, probabilities that the next run is severe, the verdict.
 * @param {[number, number]} node @param {Conditions} conditions */
function marginAt([k, j], conditions) {
  const [plane, { velocity }, { below }] = [planeOf(conditions), content.fine, modelError()];
  const places = surfaces().map((surface) => indexOf(surface, k, j));
  const error = Math.max(...places.map((place) => content.errors[place]));
  const share = (/** @type {number} */ place) => below(Math.log(place / velocity[j]));
  const [{ limitOf }, critical] = [heatOf(conditions), conditions.critical_temperature ?? NaN];
  const limits = content.critical_errors.map((kelvin) => limitOf(critical + kelvin));
  const probabilities = [1 / (1 + error), 1, 1 + error].map((factor) => sum(places.map((place) => {
    const row = plane.subarray(place - j, place - j + velocity.length);
    const severe = limits.flatMap((limit) => rangesAbove(velocity, row, limit / factor));
    const shares = severe.map(([begin, end]) => share(end) - share(begin));
    return sum(shares) / limits.length / places.length;
  })));
  const [lowest, likely, highest] = Number.isNaN(error) ? [0, probabilities[1], 1] : probabilities;
  const isMild = highest <= content.decided[0];
  const isDecided = !content.misfit && (isMild || lowest >= content.decided[1]);
  const verdict = isDecided ? (isMild ? "mild" : "severe") : "not decided";
  const rises = places.map((place) => plane[place]);
  return { rises, error, probabilities: [lowest, likely, highest], verdict };
}
