"use strict";
/* The operating point: its form, and what is said of it. */

/** A place lies within a sweep. @param {{load: number, velocity: number}} place @param {{loads: number[],
 * velocities: number[]}} axes */
function isInside({ load, velocity }, { loads, velocities }) {
  const isOn = (/** @type {number} */ value, /** @type {number[]} */ all) =>
    value > 0 && value >= all[0] && value <= all[all.length - 1];
  return isOn(load, loads) && isOn(velocity, velocities);
}

/** Read the operating point as it is typed. @param {(load: number, velocity: number) => void} take */
function listenToOperatingPoint(take) {
  const form = element("operating");
  const read = (/** @type {string} */ id) => {
    const { value } = input(id);
    const isFault = value.trim() !== "" && Number.isNaN(typed(value));
    input(id).setAttribute("aria-invalid", `${isFault}`);
    return typed(value);
  };
  form.addEventListener("submit", (event) => event.preventDefault());
  form.addEventListener("input", () => take(read("at-load"), read("at-velocity")));
}

/** Show numbers of the operating point, or why there are none. @param {[string, string][] | string} rows */
function showMargin(rows) {
  const isHint = typeof rows === "string";
  element("operating").classList.toggle("is-used", !isHint);
  element("margin").replaceChildren(isHint ? html("p", { class: "hint" }, rows) : pairs(rows));
}

/** Reason why an operating point cannot be judged. @param {number} load @param {number} velocity @param
 * {number[]} loads @param {number[]} velocities */
function reasonAgainst(load, velocity, loads, velocities) {
  if (Number.isNaN(load) || Number.isNaN(velocity)) {
    return "Type a load and a velocity to see how safe they are.";
  }
  const [f, v] = [loads, velocities].map((all) => [all[0], all[all.length - 1]].map((end) => shown(end)));
  return `Outside the sweep, which has ${f[0]} to ${f[1]} N and ${v[0]} to ${v[1]} m/s.`;
}

/** Verdict and distances at the node nearest to the operating point. @returns {[string, string][] | string}
 * */
function marginRows() {
  const { load, velocity, conditions } = chosen;
  if (!isInside(chosen, sweep)) return reasonAgainst(load, velocity, sweep.loads, sweep.velocities);
  const [k, j] = sweep.nearest(chosen);
  const { rises, error, probabilities, verdict } = marginAt([k, j], conditions);
  if (rises.some(Number.isNaN)) return "Too few points about this place are done.";
  const temperatures = rises.map(temperature);
  const states = surfaces().map((surface) => sweep.state(surface, k, j));
  const isThere = states.every((state) => state === NODE_COMPUTED);
  const isBeyond = states.includes(NODE_BETWEEN) || states.includes(NODE_EXTRAPOLATED);
  const origin = isThere ? "computed there" : isBeyond ? "extrapolated" : "interpolated";
  const [f, v] = [sweep.fine.load[k], sweep.fine.velocity[j]];
  const place = `${shown(f)} N, ${shown(v)} m/s, ${origin}`;
  const decisive = banded(temperatures.map((kelvin) => kelvin - ZERO_CELSIUS), "°C");
  /** @type {[string, string][]} */
  const rows = [["nearest node", place], ["deciding temperature", decisive]];
  const critical = conditions.critical_temperature;
  if (critical === null) return rows;
  const [lowest, likely, highest] = probabilities.map(percent);
  const within = lowest === highest ? "" : ` (${lowest.replace(" %", "")} to ${highest})`;
  const kelvin = error * quantileOf(temperatures.map((one) => one - temperature(0)), 0.5);
  return [
    ["wear", content.misfit || verdict], ["severe wear is likely by", `${likely}${within}`], ...rows,
    ["its error", Number.isNaN(kelvin) ? "not known" : `± ${shown(kelvin, 2)} K`],
    ["distance to critical", banded(temperatures.map((one) => critical - one), "K", 3)],
    ["wear turns at this load", wayText("velocity", k, v, "m/s")],
    ["wear turns at this velocity", wayText("load", j, f, "N")],
    ["the model’s own error", modelError().words],
  ];
}

/** Nearest transitions along an axis through a node in words, and their ratio to the present value. @param
 * {AxisName} axis @param {number} node @param {number} now @param {string} unit */
function wayText(axis, node, now, unit) {
  const all = surfaces().map((surface) => sweep.transition(axis, surface, node, chosen.conditions));
  const places = nearestTurns(all, now);
  const words = outcomeText({ transitions: all }, unit);
  const ratio = quantileOf(places, 0.5) / now;
  if (!Number.isFinite(ratio) || !ratio) return words;
  const ranges = all.length === 1 && all[0].outcome === SEVERAL ? `; ${words}` : "";
  return `${banded(places.map((place) => place || Infinity), unit)}, ${shown(ratio, 3)} times${ranges}`;
}

/** Median, and the values that 80 % of the surfaces lie between. @param {number[]} values also infinite ones
 * @param {string} unit @param {number} [digits] */
function banded(values, unit, digits = 4) {
  const [low, middle, high] = BAND.map((share) => quantileOf(values, share)).map((value) =>
    Number.isFinite(value) ? `${shown(value, digits)} ${unit}` : "beyond the sweep",
  );
  return low === high ? middle : `${middle} (${low} to ${high})`;
}

/** A probability in words, which are no number where it is next to certain. @param {number} value */
function percent(value) {
  if (value < 1e-4) return "less than 0.01 %";
  if (value > 1 - 1e-4) return "more than 99.99 %";
  return `${shown(100 * value, value < 0.995 ? 2 : 4)} %`;
}

/** Names and texts as a table without heads. @param {[string, string][]} rows */
function pairs(rows) {
  const body = rows.map(([name, text]) => {
    const look = text === "mild" || text === "severe" ? `verdict-${text}` : "";
    return html("tr", {}, html("th", { scope: "row" }, name), html("td", { class: look }, text));
  });
  return html("table", {}, html("tbody", {}, ...body));
}
