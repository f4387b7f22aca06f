// @ts-check
"use strict";
/* Measured transitions, and the margin of an operating point. */

/** Velocity computed at the load and the friction of a measurement. @param {Measurement} at */
function expectedVelocity(at) {
  const conditions = { ...chosen.conditions, friction: at.friction ?? chosen.conditions.friction };
  const limit = riseLimit(conditions);
  const found = surfaces().map((surface) => {
    const { across } = sweep.decisive(conditions);
    const row = lineOf(sweep.velocities, across[surface].map((line) => valueAt(line, at.normal_load)));
    const velocity = crossing(row, limit);
    return endsOf(row, velocity, outcomeOf(row, velocity, limit, sweep.range.velocity));
  });
  return quantileOfEnds(found, 0.5);
}

function showMeasured() {
  element("measured-section").hidden = !content.measured.length;
  const rows = content.measured.map((at) => {
    const expected = expectedVelocity(at);
    const difference = 100 * (expected / at.velocity - 1);
    const sign = difference > 0 ? "+" : "";
    return [
      shown(at.normal_load, 6),
      at.friction === null ? `${shown(chosen.conditions.friction)} (set above)` : shown(at.friction),
      shown(at.velocity),
      shown(expected),
      Number.isFinite(difference) ? `${sign}${difference.toFixed(1)} %` : "–",
    ];
  });
  const heads = ["load [N]", "friction", "measured [m/s]", "computed [m/s]", "difference"];
  const how = "computed at the friction that was measured, and the temperatures and share set above";
  element("measured").replaceChildren(table(how, heads, rows));
}

/** The operating point lies within the sweep. */
function isInside() {
  const within = (/** @type {number} */ value, /** @type {number[]} */ all) =>
    value > 0 && value >= all[0] && value <= all[all.length - 1];
  return within(chosen.load, sweep.loads) && within(chosen.velocity, sweep.velocities);
}

function makeOperating() {
  const form = element("operating");
  form.addEventListener("submit", (event) => event.preventDefault());
  form.addEventListener("input", () => {
    const read = (/** @type {string} */ id) => {
      const { value } = input(id);
      const isFault = value.trim() !== "" && Number.isNaN(typed(value));
      input(id).setAttribute("aria-invalid", `${isFault}`);
      return typed(value);
    };
    chosen.load = read("at-load");
    chosen.velocity = read("at-velocity");
    form.classList.toggle("is-used", isInside());
    update();
  });
}

/** Distance of the operating point to the boundary, as irg margin gives it. */
function showMargin() {
  const { load, velocity, conditions } = chosen;
  const box = element("margin");
  const say = (/** @type {string} */ text) => box.replaceChildren(html("p", { class: "hint" }, text));
  if (Number.isNaN(load) || Number.isNaN(velocity)) {
    const fault = ["at-load", "at-velocity"].map((id) => commaFault(input(id).value)).find(Boolean);
    if (fault) return say(`${fault[0].toUpperCase()}${fault.slice(1)}.`);
    return say("Type a load and a velocity for the margin to severe wear.");
  }
  if (!isInside()) {
    const [f, v] = [sweep.loads, sweep.velocities].map((all) => [all[0], all[all.length - 1]]);
    return say(`Outside the sweep, which has ${f[0]} to ${f[1]} N and ${v[0]} to ${v[1]} m/s.`);
  }
  const limit = riseLimit(conditions);
  const found = surfaces().map((surface) => {
    const { rise, isWithin, ...along } = sweep.lines(surface, load, velocity, conditions);
    return {
      rise,
      isWithin,
      velocity: wayTo(along.alongVelocity, limit, sweep.range.velocity),
      load: wayTo(along.alongLoad, limit, sweep.range.load),
    };
  });
  const known = found.filter(({ rise }) => Number.isFinite(rise));
  if (!known.length) return say("Too few points about this place are done to tell.");
  const rises = known.map(({ rise }) => temperature(rise));
  /** @type {[string, string][]} */
  const rows = [["deciding temperature", banded(rises.map((x) => x - ZERO_CELSIUS), "°C")]];
  const severe = known.filter(({ rise }) => rise > limit).length;
  const verdict = known.length > 1 ? `severe on ${severe} of ${known.length}` : severe ? "severe" : "mild";
  if (isJudged()) {
    const critical = conditions.critical_temperature ?? NaN;
    rows.unshift(["wear", verdict]);
    rows.push(["distance to critical", banded(rises.map((x) => critical - x), "K", 3)]);
    rows.push(["severe at this load", wayText(known.map((each) => each.velocity), velocity, "m/s")]);
    rows.push(["severe at this velocity", wayText(known.map((each) => each.load), load, "N")]);
  }
  if (!known.every(({ isWithin }) => isWithin)) {
    rows.push(["note", "the temperature is continued beyond the computed points"]);
  }
  box.replaceChildren(pairs(rows));
}

/**
 * Crossing along a line, or the places that it may have beyond it.
 * @param {Line[]} lines @param {number} limit @param {[number, number]} range
 */
function wayTo(lines, limit, range) {
  return transition(lines, limit, range).ends[0];
}

/**
 * Median, and what 80 % of the surfaces lie between.
 * @param {number[]} values also infinite ones @param {string} unit @param {number} [digits]
 */
function banded(values, unit, digits = 4) {
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
  if (low === high) return middle;
  return `${middle} (${low} to ${high})`;
}

/** Transition in words, and its ratio to the present value. */
function wayText(
  /** @type {Ends[]} */ found,
  /** @type {number} */ now,
  /** @type {string} */ unit,
) {
  const along = unit === "N" ? "load" : "velocity";
  const all = (/** @type {(ends: Ends) => boolean} */ holds) => found.every(holds);
  if (all(([low]) => low === Infinity)) return `at no ${along} computed`;
  if (all(([, high]) => high === -Infinity)) return `at every ${along} computed`;
  if (all(([low]) => Number.isNaN(low))) return "not known";
  if (all(([low, high]) => high === Infinity && low < high)) return "above what was computed";
  if (all(([low, high]) => low === -Infinity && low < high)) return "below what was computed";
  const middle = quantileOfEnds(found, 0.5);
  const times = Number.isFinite(middle) ? `, ${shown(middle / now, 3)} times` : "";
  return `${bandedText(BAND.map((share) => quantileOfEnds(found, share)), unit)}${times}`;
}

/** Names and texts as a table without heads. @param {[string, string][]} rows */
function pairs(rows) {
  const looks = { mild: "verdict-mild", severe: "verdict-severe" };
  const body = rows.map(([name, text]) => {
    const cell = html("td", {}, text);
    if (text in looks) cell.className = looks[/** @type {keyof typeof looks} */ (text)];
    return html("tr", {}, html("th", { scope: "row" }, name), cell);
  });
  return html("table", {}, html("tbody", {}, ...body));
}
