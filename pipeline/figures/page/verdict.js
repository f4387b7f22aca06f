// @ts-check
"use strict";
/* State of a point under the present conditions, in words. */

/**
 * @typedef {{surface: number, place: number, decisive: number, highest: number, time: number,
 *   failed: number, severe: boolean, temperatures: number[]}} Finding temperatures in kelvin, of
 *   which each quantile of the contact stays below one
 */

/** Findings on the surfaces that are done at a point. @param {number} i @param {number} j */
function findings(i, j) {
  const { critical_temperature } = chosen.conditions;
  const limit = riseLimit(chosen.conditions);
  /** @type {Finding[]} */
  const found = [];
  for (const surface of surfaces()) {
    const place = sweep.place(surface, i, j);
    const { rise, moment } = sweep.worst(place, chosen.conditions);
    if (moment < 0) continue;
    const row = sweep.rises.row(moment, bulkRatio(chosen.conditions));
    found.push({
      surface,
      place,
      temperatures: row.map(temperature),
      decisive: temperature(rise),
      highest: temperature(row[row.length - 1]),
      time: sweep.times[moment],
      failed: critical_temperature === null ? NaN : 1 - linear(row, sweep.quantiles, limit),
      severe: rise > limit,
    });
  }
  return found;
}

/** Kind of a point, as the diagram marks it. @param {number} i @param {number} j */
function kindOf(i, j) {
  const { rises } = sweep.decisive(chosen.conditions);
  const limit = riseLimit(chosen.conditions);
  let [hot, cold, failed, asked] = [false, false, false, false];
  for (const surface of surfaces()) {
    const place = sweep.place(surface, i, j);
    const rise = rises[surface][i][j];
    if (rise > limit) hot = true;
    else if (!Number.isNaN(rise)) cold = true;
    if (sweep.status[place] === POINT_FAILED) failed = true;
    if (sweep.asked[place]) asked = true;
  }
  if (hot || cold) {
    if (!isJudged()) return "unjudged";
    return hot && cold ? "mixed" : hot ? "severe" : "mild";
  }
  if (failed) return "failed";
  return asked ? "pending" : "";
}

/** Messages of a point on the surfaces that count, each once. @param {number} i @param {number} j */
function messagesOf(i, j) {
  const places = surfaces().map((surface) => String(sweep.place(surface, i, j)));
  return [...new Set(places.map((place) => content.messages[place]).filter(Boolean))];
}

/** @param {number} i @param {number} j */
function hasWarning(i, j) {
  return surfaces().some((surface) => {
    const place = sweep.place(surface, i, j);
    return sweep.status[place] === POINT_DONE && String(place) in content.messages;
  });
}

/**
 * From the lowest to the highest of some values, once if they are one.
 * @param {number[]} values @param {string} unit @param {number} [digits]
 */
function span(values, unit, digits = 4) {
  const known = values.filter(Number.isFinite);
  if (!known.length) return "–";
  const [low, high] = [Math.min(...known), Math.max(...known)].map((value) => shown(value, digits));
  return `${low === high ? low : `${low} to ${high}`} ${unit}`;
}

/**
 * Description of a point, as pairs of a name and a text.
 * @param {number} i @param {number} j @param {boolean} full @returns {[string, string][]}
 */
function told(i, j, full) {
  const found = findings(i, j);
  const share = `${shown(100 * chosen.conditions.failing_share)} % of the contact`;
  /** @type {[string, string][]} */
  const rows = [["wear", verdictOf(found, kindOf(i, j))]];
  if (found.length) {
    if (!hasShare() || chosen.conditions.failing_share > 0) {
      const decisive = found.map((each) => each.decisive - ZERO_CELSIUS);
      rows.push([hasShare() ? `exceeded on ${share}` : content.deciding, span(decisive, "°C")]);
    }
    rows.push(["highest temperature", span(found.map((each) => each.highest - ZERO_CELSIUS), "°C")]);
    if (isJudged()) {
      rows.push(["contact above critical", span(found.map((each) => 100 * each.failed), "%", 3)]);
    }
    for (const [label, name, factor, unit] of full ? NUMBERS : NUMBERS.slice(0, 1)) {
      const values = found.map((each) => factor * sweep.number(name, each.place));
      if (values.some(Number.isFinite)) rows.push([label, span(values, unit)]);
    }
    if (full) rows.push(["at its worst after", span(found.map((each) => each.time), "s")]);
  }
  for (const message of messagesOf(i, j)) rows.push([found.length ? "warning" : "message", message]);
  return rows;
}

/** Label, variable, factor and unit of the stored numbers. @type {[string, string, number, string][]} */
const NUMBERS = [
  ["contact width", "contact_width", 1e6, "µm"],
  ["contact area", "contact_fraction", 100, "% of the window"],
  ["mean pressure", "mean_pressure", 1e-9, "GPa"],
  ["highest pressure", "max_pressure", 1e-9, "GPa"],
  ["contact at the hardness", "saturated_fraction", 100, "%"],
  ["wear depth", "wear_depth_max", 1e6, "µm"],
  ["worn volume", "wear_volume", 1e9, "mm³"],
  ["pin’s share of the heat", "pin_heat_share", 100, "%"],
  ["sliding distance", "sliding_distance", 1, "m"],
  ["duration", "time", 1, "s"],
];

/** @param {Finding[]} found @param {string} kind */
function verdictOf(found, kind) {
  if (!found.length) return kind === "failed" ? "failed" : "not computed";
  if (!isJudged()) return "not known without a critical temperature";
  const severe = found.filter((each) => each.severe).length;
  if (found.length > 1) return `severe on ${severe} of ${found.length}`;
  return severe ? "severe" : "mild";
}

/** @param {number} i @param {number} j */
function nameOf(i, j) {
  return `${shown(sweep.loads[i], 6)} N, ${shown(sweep.velocities[j], 6)} m/s`;
}
