/* The page of samples: probabilities of severe wear, tabulated by Python. */

/** @type {Samples} */
const samples = readContent();
/** The operating point. */
const operating = { load: NaN, velocity: NaN };

/** Probability of severe wear, by the table. @param {number} load @param {number} velocity */
function probabilityAt(load, velocity) {
  const { loads, velocities, probability } = samples;
  const n = velocities.length;
  const rows = loads.map((_, i) => linear(velocities, probability.subarray(i * n, (i + 1) * n), velocity));
  return linear(loads, rows, load);
}

/** Velocities at a probability. @param {number} share @param {number} load @returns {[string, string]} */
function turnsRow(share, load) {
  const { velocities } = samples;
  const over = velocities.map((velocity) => probabilityAt(load, velocity) - share);
  const places = velocities.slice(1).flatMap((next, k) => (over[k] > 0 === over[k + 1] > 0 ? []
    : [next - (over[k + 1] / (over[k + 1] - over[k])) * (next - velocities[k])]));
  const ends = [velocities[0], velocities[over.length - 1]];
  const [low, high, ...turns] = [...ends, ...places].map((one) => shown(one, 3));
  const text = turns.join(", ") || (over[0] > 0 ? `below ${low}` : `above ${high}`);
  return [`${shown(100 * share)} % at this load`, `${text} m/s`];
}

/** Draw the probability as colours, with lines at 5, 50 and 95 %. @param {Frame} frame */
function drawnBand(frame) {
  const { loads, velocities, probability, picture, shares } = samples;
  const [x, y, n] = [velocities.map(frame.x), loads.map(frame.y), velocities.length];
  const size = { x: x[0], y: y[y.length - 1], width: x[n - 1] - x[0], height: y[0] - y[y.length - 1] };
  const lines = shares.map((share, k) => {
    const over = loads.map((_, i) => [...probability.subarray(i * n, (i + 1) * n)].map((p) => p - share));
    return svg("path", { class: k === 1 ? "boundary" : "own", d: contour(x, y, [over], true) });
  });
  const look = { preserveAspectRatio: "none", href: `data:image/png;base64,${picture}` };
  return [svg("image", { class: "probability", ...size, ...look }), ...lines];
}

/** Draw the diagram, and show the probability at the pointer. */
function drawSamples() {
  const { loads, velocities, measured } = samples;
  const { root, inside, frame } = planeAxes(velocities, loads, measured);
  inside.append(...drawnBand(frame));
  inside.append(...measured.map((test) => sign(test.sign, frame.x(test.velocity), frame.y(test.load))));
  if (isInside(operating, samples)) inside.append(cross(frame, operating));
  root.addEventListener("pointerleave", () => tip.toggleAttribute("hidden", true));
  root.addEventListener("pointermove", (event) => {
    const { left, top } = root.getBoundingClientRect();
    showTip(frame, frame.load(event.clientY - top), frame.velocity(event.clientX - left));
  });
  element("diagram").replaceChildren(root, tip);
  showLegend();
}

/** Show the probability at a place. @param {Frame} frame @param {number} load @param {number} velocity */
function showTip(frame, load, velocity) {
  tip.hidden = !isInside({ load, velocity }, samples);
  if (tip.hidden) return;
  const text = `severe with a probability of ${percent(probabilityAt(load, velocity))}`;
  const title = `${shown(load, 3)} N, ${shown(velocity, 3)} m/s`;
  placeTip(frame, [frame.x(velocity), frame.y(load)], title, [text]);
}

/** Take an operating point, and show its probability. @param {number} load @param {number} velocity */
function judge(load, velocity) {
  Object.assign(operating, { load, velocity });
  drawSamples();
  if (!isInside(operating, samples)) return showMargin(samples.outside);
  showMargin([
    ...samples.misfit, ["probability of severe wear", percent(probabilityAt(load, velocity))],
    ...samples.shares.map((share) => turnsRow(share, load)),
  ]);
}

takeScene(() => ({}));
listenToOperatingPoint(judge);
judge(NaN, NaN);
offerCsv("velocities", samples.name);
new ResizeObserver(drawSamples).observe(element("diagram"));
