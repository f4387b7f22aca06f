// @ts-check
"use strict";
/* Critical velocities and loads: over the surfaces, as tables and as CSV. */

/**
 * @typedef {{middle: number[], low: number[], high: number[], mean: number[], spread: number[],
 *   crossing: number[], known: number[], outcome: number[][], computed: Ends[][]}} Side
 */

/**
 * Critical velocities and loads over the surfaces; on one, `middle` is its own.
 * @returns {{velocity: Side, load: Side, missing: number}}
 */
function summary() {
  const each = surfaces().map((surface) => sweep.boundary(surface, chosen.conditions));
  return {
    velocity: sideOf(each.map((one) => one.velocity)),
    load: sideOf(each.map((one) => one.load)),
    missing: each.reduce((sum, one) => sum + one.missing, 0),
  };
}

/** @param {Crossings[]} each @returns {Side} */
function sideOf(each) {
  const ends = each[0].at.map((_, k) => each.map((one) => one.ends[k]));
  // A transition that was not computed has no mean.
  const columns = ends.map((column) => column.map(([low, high]) => (low === high ? low : Infinity)));
  const all = ends.map((column, k) => columns[k].filter((_, n) => !Number.isNaN(column[n][0])));
  const isFinite = (/** @type {number[]} */ column) => column.every(Number.isFinite);
  const mean = all.map((column) =>
    column.length && isFinite(column) ? column.reduce((sum, x) => sum + x, 0) / column.length : NaN,
  );
  const outcome = each[0].outcome.map((_, k) => each.map((one) => one.outcome[k]));
  return {
    low: ends.map((column) => quantileOfEnds(column, BAND[0])),
    middle: ends.map((column) => quantileOfEnds(column, BAND[1])),
    high: ends.map((column) => quantileOfEnds(column, BAND[2])),
    mean,
    spread: all.map((column, k) =>
      column.length > 1 && isFinite(column)
        ? Math.sqrt(column.reduce((sum, x) => sum + (x - mean[k]) ** 2, 0) / (column.length - 1))
        : NaN,
    ),
    crossing: outcome.map((column) => column.filter((why) => why === CROSSES).length),
    known: outcome.map((column) => column.filter((why) => why < UNKNOWN).length),
    outcome,
    computed: each[0].at.map((_, k) => each.map((one) => one.computed[k])),
  };
}

/** A table of texts; columns of numbers stand to the right. */
function table(
  /** @type {string} */ caption,
  /** @type {string[]} */ heads,
  /** @type {string[][]} */ rows,
  /** @type {number} */ words = 0,
) {
  /** @returns {Object<string, string>} */
  const look = (/** @type {number} */ k) => (k < heads.length - words ? { class: "number" } : {});
  const cell = (/** @type {string} */ text, /** @type {number} */ k) =>
    k ? html("td", look(k), text) : html("th", { scope: "row", ...look(0) }, text);
  return html(
    "table",
    {},
    html("caption", {}, caption),
    html(
      "thead",
      {},
      html("tr", {}, ...heads.map((head, k) => html("th", { scope: "col", ...look(k) }, head))),
    ),
    html("tbody", {}, ...rows.map((row) => html("tr", {}, ...row.map(cell)))),
  );
}

/**
 * Count of crossings, and the reasons of the others.
 * @param {number[]} outcomes @param {Ends[]} computed @param {string} unit
 */
function outcomeText(outcomes, computed, unit) {
  const words = content.outcomes;
  if (outcomes.length === 1) {
    const span = [...new Set(computed[0])].map((end) => shown(end)).join(" to ");
    return words[outcomes[0]] + (outcomes[0] > UNKNOWN ? `: ${span} ${unit}` : "");
  }
  return words
    .map((_, why) => why)
    .map((why) => [outcomes.filter((each) => each === why).length, why])
    .filter(([count]) => count)
    .map(([count, why]) => `${count} ${why === CROSSES ? `of ${outcomes.length} cross` : words[why]}`)
    .join(", ");
}

/**
 * Film parameter at a load [N] and a velocity [m/s], which Python has tabulated over the bulk.
 * @param {Film} film @param {number} load @param {number} velocity
 */
function filmParameter(film, load, velocity) {
  if (!Number.isFinite(load * velocity)) return NaN;
  const { bulk_temperature, disk_temperature } = chosen.conditions;
  const bulk = (bulk_temperature + (disk_temperature ?? bulk_temperature)) / 2;
  const powers = [Math.log(load / film.load), Math.log(Math.abs(velocity) / film.velocity)];
  const oil = linear(film.temperatures, film.logarithms, bulk);
  return Math.exp(oil + film.powers[0] * powers[0] + film.powers[1] * powers[1]);
}

/** Show both tables; return what they say, in a sentence. */
function showTables() {
  const found = summary();
  /** @type {[string, number[], Side, string, string, string][]} */
  const sides = [
    ["velocities", sweep.loads, found.velocity, "load [N]", "critical velocity", "[m/s]"],
    ["loads", sweep.velocities, found.load, "velocity [m/s]", "critical load", "[N]"],
  ];
  for (const [id, at, side, head, what, unit] of sides) {
    const several = surfaces().length > 1;
    const heads = several
      ? [head, `median ${unit}`, "10 %", "90 %", "mean", "spread", "outcome"]
      : [head, `${what} ${unit}`, "outcome"];
    if (content.film) heads.splice(-1, 0, "film Λ");
    const rows = at.map((value, k) => {
      const values = several
        ? [side.middle, side.low, side.high, side.mean, side.spread].map((each) => shown(each[k]))
        : [shown(side.middle[k])];
      const outcome = outcomeText(side.outcome[k], side.computed[k], unit.slice(1, -1));
      const place = id === "velocities" ? [value, side.middle[k]] : [side.middle[k], value];
      const film = content.film ? [shown(filmParameter(content.film, place[0], place[1]), 2)] : [];
      return [shown(value, 6), ...values, ...film, outcome];
    });
    element(id).replaceChildren(table(conditionsText(), heads, rows, 1));
    const link = /** @type {HTMLAnchorElement} */ (element(`${id}-csv`));
    link.href = `data:text/csv;charset=utf-8,${encodeURIComponent(csv(at, side, head, `${what} ${unit}`))}`;
    link.download = `${content.name || "sweep"}_critical_${id}.csv`;
  }
  const missing = found.missing ? ` ${found.missing} points are pending or failed and left out.` : "";
  return `${conditionsText()}. ${crossingText(found.velocity)}${missing}`;
}

/** @param {Side} side */
function crossingText(side) {
  if (!isJudged()) return "Give a critical temperature to see where wear turns severe.";
  const known = sweep.loads.map((load, k) => [load, side.middle[k]]).filter(([, at]) => Number.isFinite(at));
  if (!known.length) {
    const isKnown = side.outcome.flat().every((why) => why < UNKNOWN);
    return isKnown
      ? "Wear does not turn severe within the sweep."
      : "The transition lies beyond what was computed.";
  }
  const named = known.length > 1 ? [known[0], known[known.length - 1]] : known;
  const places = named.map(([load, at]) => `${shown(at)} m/s at ${shown(load, 6)} N`);
  return `Wear turns severe at ${places.join(", at ")}.`;
}

/** One side of the boundary with its conditions, in full digits. */
function csv(
  /** @type {number[]} */ at,
  /** @type {Side} */ side,
  /** @type {string} */ head,
  /** @type {string} */ what,
) {
  const { friction, bulk_temperature, critical_temperature, failing_share } = chosen.conditions;
  const disk = chosen.conditions.disk_temperature ?? bulk_temperature;
  const criterion = content.conditions.criterion ?? "share";
  const temperatures = [bulk_temperature, disk, critical_temperature ?? ""];
  const conditions = [friction, ...temperatures, failing_share, criterion];
  const several = surfaces().length > 1;
  const heads = several
    ? [head, `${what} median`, `${what} 10 %`, `${what} 90 %`, "mean", "spread", "crossing", "known"]
    : [head, what, "outcome"];
  const rows = at.map((value, k) => {
    const number = (/** @type {number[]} */ each) => (Number.isFinite(each[k]) ? each[k] : "");
    const { middle, low, high, mean, spread } = side;
    const values = several
      ? [...[middle, low, high, mean, spread].map(number), side.crossing[k], side.known[k]]
      : [number(middle), content.outcomes[side.outcome[k][0]]];
    return [value, ...values, ...conditions];
  });
  const bulks = ["bulk temperature [K]", "bulk temperature of the disk [K]"];
  const of = ["friction", ...bulks, "critical temperature [K]", "failing share", "criterion"];
  return [[...heads, ...of], ...rows].map((row) => `${row.join(",")}\r\n`).join("");
}
