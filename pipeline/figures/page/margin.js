// @ts-check
"use strict";
/* Measured transitions and tests, and the margin of an operating point. */

/**
 * Conditions of a test: friction and bulk of its own or of the scene, whatever the reader has set.
 * A friction of its own does not follow the scene's over velocity.
 * @param {Measurement} test
 * @returns {Conditions}
 */
function conditionsOf({ friction, bulk_temperature: bulk }) {
  const { friction: usual, bulk_temperature, disk_temperature } = content.conditions;
  const [pin, disk] = [bulk ?? bulk_temperature, bulk ?? disk_temperature];
  const at_one_friction = typeof friction === "number";
  const own = { ...chosen.conditions, friction: friction ?? usual, at_one_friction, bulk_temperature: pin };
  return disk_temperature === undefined ? own : { ...own, disk_temperature: disk };
}

/** A test was made at the bulk temperature that the diagram is drawn for. @param {Measurement} test */
function hasDrawnBulk(test) {
  return Math.abs(conditionsOf(test).bulk_temperature - chosen.conditions.bulk_temperature) <= 1;
}

/** A test has another transition than the boundary that is drawn. @param {Measurement} test */
function hasOwnConditions(test) {
  const own = conditionsOf(test);
  const { fine, content: { friction_factors } } = sweep;
  const factor = own.at_one_friction ? linear(fine.velocity, friction_factors, test.velocity) : 1;
  return Math.abs((riseLimit(own) / riseLimit(chosen.conditions)) * factor - 1) > 0.02;
}

/** Margin on each surface at the place and the conditions of a test. @param {Measurement} test */
function marginsOf(test) {
  const { normal_load, velocity } = test;
  return surfaces().map((surface) => sweep.margin(surface, normal_load, velocity, conditionsOf(test)));
}

/** Velocity of the transition computed at the load and the conditions of a test. @param {Measurement} test */
function expectedVelocity(test) {
  return quantileOfEnds(marginsOf(test).map((margin) => margin.velocity.ends), 0.5);
}

/** What is computed at a test, and whether it agrees. @param {Measurement} test */
function comparison(test) {
  const { normal_load: load, velocity, outcome } = test;
  if (!isJudged() || !isOn(load, sweep.loads)) return ["not known", "not known"];
  if (!outcome) {
    const expected = expectedVelocity(test);
    const difference = 100 * (expected / velocity - 1);
    if (!Number.isFinite(difference)) return ["beyond the sweep", "not known"];
    return [`at ${shown(expected)} m/s`, `${difference > 0 ? "+" : ""}${difference.toFixed(1)} %`];
  }
  if (!isOn(velocity, sweep.velocities)) return ["not known", "not known"];
  const own = conditionsOf(test);
  const kinds = marginsOf(test).map(({ rise }, k) => {
    const error = errorAt(surfaces()[k], load, velocity) * rise;
    return verdictOf(riseLimit(own) - rise, error);
  });
  const kind = verdictsText(kinds);
  return [kind, kind === outcome ? "yes" : ["mild", "severe"].includes(kind) ? "no" : "not decided"];
}

function showMeasured() {
  element("measured-section").hidden = !content.measured.length;
  const rows = content.measured.map((test) => {
    const { normal_load, velocity, outcome } = test;
    const { friction, bulk_temperature: bulk } = conditionsOf(test);
    const own = [shown(friction), shown(bulk - ZERO_CELSIUS)];
    return [outcome ?? "transition", shown(normal_load, 6), shown(velocity), ...own, ...comparison(test)];
  });
  const heads = ["test", "load [N]", "velocity [m/s]", "friction", "bulk [°C]", "computed", "agrees"];
  element("measured").replaceChildren(table(heads, rows, 2));
}

/** A positive value lies on an axis. @param {number} value @param {number[]} all */
function isOn(value, all) {
  return value > 0 && value >= all[0] && value <= all[all.length - 1];
}

/**
 * A place lies within a sweep.
 * @param {{load: number, velocity: number}} place @param {{loads: number[], velocities: number[]}} axes
 */
function isInside({ load, velocity }, { loads, velocities }) {
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

/**
 * Distance of the operating point to the boundary, or why there is none; irg margin says how sure.
 * @returns {[string, string][] | string}
 */
function marginRows() {
  const { load, velocity, conditions } = chosen;
  if (!isInside(chosen, sweep)) return reasonAgainst(load, velocity, sweep.loads, sweep.velocities);
  const margins = surfaces()
    .map((surface) => ({
      ...sweep.margin(surface, load, velocity, conditions),
      share: errorAt(surface, load, velocity),
    }))
    .filter(({ rise }) => Number.isFinite(rise));
  if (!margins.length) return "Too few points about this place are done.";
  const temperatures = margins.map(({ rise }) => temperature(rise));
  /** @type {[string, string][]} */
  const rows = [["deciding temperature", banded(temperatures.map((kelvin) => kelvin - ZERO_CELSIUS), "°C")]];
  if (isJudged()) {
    const critical = conditions.critical_temperature ?? NaN;
    const errors = margins.map(({ share }, k) => share * (temperatures[k] - temperature(0)));
    const isOpen = margins.map((one) => one.velocity.outcome === SEVERAL || one.load.outcome === SEVERAL);
    const kinds = temperatures.map((kelvin, k) => verdictOf(critical - kelvin, isOpen[k] ? NaN : errors[k]));
    rows.unshift(["wear", verdictsText(kinds)]);
    const largest = Math.max(...errors);
    rows.push(["its error", Number.isNaN(largest) ? "not known" : `± ${shown(largest, 2)} K`]);
    rows.push(["distance to critical", banded(temperatures.map((kelvin) => critical - kelvin), "K", 3)]);
    rows.push(["severe at this load", wayText(margins, "velocity", velocity, "m/s")]);
    rows.push(["severe at this velocity", wayText(margins, "load", load, "N")]);
  }
  return rows;
}

/**
 * Relative error of the rise at a place, which Python has tabulated; NaN where it is not known.
 * @param {number} surface @param {number} load @param {number} velocity
 */
function errorAt(surface, load, velocity) {
  const { loads, velocities, errors } = sweep;
  const slot = (/** @type {number[]} */ x, /** @type {number} */ value) =>
    x.includes(value) ? 2 * x.indexOf(value) : 2 * above(x, value) - 1;
  const row = surface * (2 * loads.length - 1) + slot(loads, load);
  return errors[row * (2 * velocities.length - 1) + slot(velocities, velocity)];
}

/**
 * Kind of wear beyond the error of the temperature, as pipeline.Margin.verdict.
 * @param {number} distance critical less deciding temperature @param {number} error NaN if unknown
 */
function verdictOf(distance, error) {
  if (!(Math.abs(distance) > error)) return "not decided";
  return distance < 0 ? "severe" : "mild";
}

/** Kinds of wear on several surfaces in words. @param {string[]} kinds */
function verdictsText(kinds) {
  if (kinds.length === 1) return kinds[0];
  const count = (/** @type {string} */ kind) => kinds.filter((other) => other === kind).length;
  const open = count("not decided");
  return `severe on ${count("severe")} of ${kinds.length}${open ? `, not decided on ${open}` : ""}`;
}

/**
 * Reason why an operating point cannot be judged.
 * @param {number} load @param {number} velocity @param {number[]} loads @param {number[]} velocities
 */
function reasonAgainst(load, velocity, loads, velocities) {
  if (Number.isNaN(load) || Number.isNaN(velocity)) {
    return "Type a load and a velocity to see how safe they are.";
  }
  const [f, v] = [loads, velocities].map((all) => [all[0], all[all.length - 1]].map((end) => shown(end)));
  return `Outside the sweep, which has ${f[0]} to ${f[1]} N and ${v[0]} to ${v[1]} m/s.`;
}

/**
 * Median, and the values that 80 % of the surfaces lie between.
 * @param {number[]} values also infinite ones @param {string} unit @param {number} [digits]
 */
function banded(values, unit, digits) {
  return bandedText(BAND.map((share) => quantileOf(values, share)), unit, digits);
}

/**
 * Lower end, median and upper end in words.
 * @param {number[]} quantiles @param {string} unit @param {number} [digits]
 */
function bandedText(quantiles, unit, digits = 4) {
  const [low, middle, high] = quantiles.map((value) =>
    Number.isFinite(value) ? `${shown(value, digits)} ${unit}` : "beyond the sweep",
  );
  return low === high ? middle : `${middle} (${low} to ${high})`;
}

/**
 * Transitions along one axis in words, and their ratio to the present value.
 * @param {{velocity: Transition, load: Transition}[]} margins @param {AxisName} along
 * @param {number} now @param {string} unit
 */
function wayText(margins, along, now, unit) {
  const transitions = margins.map((margin) => margin[along]);
  const ends = transitions.map((transition) => transition.ends);
  const codes = new Set(transitions.map(({ outcome }) => outcome));
  if (codes.size === 1 && !codes.has(CROSSES)) return outcomeWords(transitions[0], along, unit);
  const quantiles = BAND.map((share) => quantileOfEnds(ends, share));
  const times = Number.isFinite(quantiles[1]) ? `, ${shown(quantiles[1] / now, 3)} times` : "";
  return `${bandedText(quantiles, unit)}${times}${bridgedText(transitions)}`;
}

/** Names and texts as a table without heads. @param {[string, string][]} rows */
function pairs(rows) {
  const body = rows.map(([name, text]) => {
    const look = text === "mild" || text === "severe" ? `verdict-${text}` : "";
    return html("tr", {}, html("th", { scope: "row" }, name), html("td", { class: look }, text));
  });
  return html("table", {}, html("tbody", {}, ...body));
}
