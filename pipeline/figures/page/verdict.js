// @ts-check
"use strict";
/* State of a point under the present conditions, in words. */

/**
 * @typedef {{place: number, decisive: number, failed: number, isSevere: boolean,
 *   temperatures: number[]}} Verdict temperatures in kelvin, of which each quantile of the contact
 *   stays below one
 */

/** Verdicts on the surfaces on which a point is done. @param {number} i @param {number} j */
function verdicts(i, j) {
  const limit = riseLimit(chosen.conditions);
  return surfaces().flatMap((surface) => {
    const place = sweep.place(surface, i, j);
    const rise = sweep.rise(surface, i, j, chosen.conditions);
    if (Number.isNaN(rise)) return [];
    const row = sweep.quantiles(place, chosen.conditions);
    return /** @type {Verdict[]} */ ([{
      place,
      temperatures: row.map(temperature),
      decisive: temperature(rise),
      failed: isJudged() ? 1 - linear(row, content.quantiles, limit) : NaN,
      isSevere: rise > limit,
    }]);
  });
}

/** Kind of a point, as the diagram marks it. @param {number} i @param {number} j */
function kindOf(i, j) {
  const rises = surfaces().map((surface) => sweep.rise(surface, i, j, chosen.conditions));
  const places = surfaces().map((surface) => sweep.place(surface, i, j));
  const done = rises.filter((rise) => !Number.isNaN(rise));
  if (done.length) {
    if (!isJudged()) return "unjudged";
    const severe = done.filter((rise) => rise > riseLimit(chosen.conditions)).length;
    return severe === 0 ? "mild" : severe < done.length ? "mixed" : "severe";
  }
  if (places.some((place) => sweep.status[place] === POINT_FAILED)) return "failed";
  return places.some((place) => sweep.asked[place]) ? "pending" : "";
}

/** Messages of a point on the surfaces that count, each once. @param {number} i @param {number} j */
function messagesOf(i, j) {
  const texts = surfaces().map((surface) => content.messages[sweep.place(surface, i, j)]);
  return [...new Set(texts.filter(Boolean))];
}

/** @param {number} i @param {number} j */
function hasWarning(i, j) {
  return !["failed", "pending", ""].includes(kindOf(i, j)) && messagesOf(i, j).length > 0;
}

/**
 * Description of a point, as pairs of a name and a text.
 * @param {number} i @param {number} j @param {boolean} isFull @returns {[string, string][]}
 */
function description(i, j, isFull) {
  const all = verdicts(i, j);
  const { failing_share } = chosen.conditions;
  /** @type {[string, string][]} */
  const rows = [["wear", wearOf(all, kindOf(i, j))]];
  if (all.length) {
    if (!hasShare || failing_share > 0) {
      const share = `exceeded on ${shown(100 * failing_share)} % of the contact`;
      const decisive = banded(all.map((verdict) => verdict.decisive - ZERO_CELSIUS), "°C");
      rows.push([hasShare ? share : content.deciding, decisive]);
    }
    const highest = all.map(({ temperatures }) => Math.max(...temperatures) - ZERO_CELSIUS);
    rows.push(["highest temperature", banded(highest, "°C")]);
    if (isJudged()) {
      rows.push(["contact above critical", banded(all.map(({ failed }) => 100 * failed), "%", 3)]);
    }
    const numbers = isFull ? content.numbers : content.numbers.slice(0, 1);
    numbers.forEach(({ label, unit }, k) => {
      const values = all.map(({ place }) => sweep.numbers[k][place]);
      if (values.some(Number.isFinite)) rows.push([label, banded(values, unit)]);
    });
    if (isFull) rows.push(["at its worst after", banded(all.map(({ place }) => sweep.times[place]), "s")]);
  }
  for (const message of messagesOf(i, j)) rows.push([all.length ? "warning" : "message", message]);
  return rows;
}

/** Kind of wear in words. @param {Verdict[]} all @param {string} kind */
function wearOf(all, kind) {
  if (!all.length) return kind === "failed" ? "failed" : "not computed";
  if (!isJudged()) return "not known without a critical temperature";
  return verdictsText(all.map(({ isSevere }) => (isSevere ? "severe" : "mild")));
}

/** @param {number} i @param {number} j */
function nameOf(i, j) {
  return `${shown(sweep.loads[i], 6)} N, ${shown(sweep.velocities[j], 6)} m/s`;
}
