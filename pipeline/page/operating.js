/* The operating point: its form, and its margin. */

/** True if a place is inside a sweep. @param {Place} place @param {Axes} axes */
function isInside({ load, velocity }, { loads, velocities }) {
  return load > 0 && velocity > 0 && load >= loads[0] && load <= loads[loads.length - 1] &&
    velocity >= velocities[0] && velocity <= velocities[velocities.length - 1];
}

/** Call `take` with each operating point typed. @param {(load: number, velocity: number) => void} take */
function listenToOperatingPoint(take) {
  const read = (/** @type {string} */ id) => {
    const value = typed(input(id).value);
    input(id).setAttribute("aria-invalid", `${input(id).value.trim() !== "" && Number.isNaN(value)}`);
    return value;
  };
  element("operating").addEventListener("change", () => take(read("at-load"), read("at-velocity")));
}

/** Show the operating point's margin, or why it has none. @param {[string, string][] | string} rows */
function showMargin(rows) {
  const isHint = typeof rows === "string";
  element("operating").classList.toggle("is-used", !isHint);
  element("margin").replaceChildren(isHint ? html("p", { class: "hint" }, rows) : table([], rows));
}

/** Rows with verdict and distances at the nearest node, or a hint. @returns {[string, string][] | string} */
function marginRows() {
  const { conditions } = chosen;
  if (!isInside(chosen, content)) return content.outside;
  const [k, j] = nearestNode(chosen);
  const { rises, error, probabilities, verdict } = marginAt([k, j], conditions);
  if (rises.some(Number.isNaN)) return "Too few points about this place are done.";
  const temperatures = rises.map(temperature);
  const states = surfaces().map((surface) => Number(content.state[indexOf(surface, k, j)]));
  const [f, v] = [content.fine.load[k], content.fine.velocity[j]];
  /** @type {[string, string][]} */
  const rows = [
    ["nearest node", `${shown(f)} N, ${shown(v)} m/s, ${content.origins[Math.max(...states)]}`],
    ["deciding temperature", banded(temperatures.map((kelvin) => kelvin - ZERO_CELSIUS), "°C")],
  ];
  const critical = conditions.critical_temperature;
  if (critical === null) return rows;
  const [lowest, likely, highest] = probabilities.map(percent);
  const within = lowest === highest ? "" : ` (${lowest.replace(" %", "")} to ${highest})`;
  const kelvin = temperature(quantileOf(rises, 0.5) * (1 + error)) - temperature(quantileOf(rises, 0.5));
  return [
    ["wear", content.misfit || verdict], ["severe wear is likely by", `${likely}${within}`], ...rows,
    ["its error", Number.isNaN(kelvin) ? "not known" : `± ${shown(kelvin, 2)} K`],
    ["distance to critical", banded(temperatures.map((one) => critical - one), "K", 3)],
    ["wear turns at this load", wayText("velocity", k, v, "m/s")],
    ["wear turns at this velocity", wayText("load", j, f, "N")],
    ["the model’s own error", modelError().words],
  ];
}

/** First transition along an axis through a node in words, with its ratio to the value `now`. @param
 * {AxisName} axis @param {number} node @param {number} now @param {string} unit */
function wayText(axis, node, now, unit) {
  const all = transitions(axis, node, chosen.conditions);
  const words = outcomeText({ transitions: all }, unit);
  const place = medianTurn(all, firstTurn) || Infinity;
  if (!Number.isFinite(place)) return words;
  const ranges = all.some(({ outcome }) => outcome === SEVERAL) ? `; ${words}` : "";
  return `${shown(place)} ${unit}, ${shown(place / now, 3)} times${ranges}`;
}

/** Median of the surfaces in words, with the range of 80 % of them. @param {number[]} values @param {string}
 * unit @param {number} [digits] */
function banded(values, unit, digits = 4) {
  const [low, middle, high] = BAND.map((share) => quantileOf(values, share)).map((value) =>
    (Number.isNaN(value) ? "not known" : `${shown(value, digits)} ${unit}`));
  return low === high ? middle : `${middle} (${low} to ${high})`;
}

/** A probability in words: a percentage, or "less than 0.01 %". @param {number} value */
function percent(value) {
  if (value < 1e-4) return "less than 0.01 %";
  if (value > 1 - 1e-4) return "more than 99.99 %";
  return `${shown(100 * value, value < 0.995 ? 2 : 4)} %`;
}
