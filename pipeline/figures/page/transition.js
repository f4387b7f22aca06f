// @ts-check
"use strict";
/* The transition along a line of points, by the same rule as pipeline.analysis.transition. */

/**
 * @typedef {[number, number]} Ends least and greatest place that a transition may have
 * @typedef {{place: number, outcome: number, ends: Ends, computed: Ends, bridged: number}} Transition
 *   bridged are the points not done that it is interpolated across
 * @typedef {{low: number, middle: number, high: number, mean: number, spread: number,
 *   transitions: Transition[]}} Summary transitions on several surfaces, and their quantiles
 */

const [CROSSES, MILD, SEVERE, UNKNOWN, ABOVE, BELOW] = [0, 1, 2, 3, 4, 5];
const BAND = [0.1, 0.5, 0.9];

/**
 * Value that a share of all stays below, linear between them; infinite if beyond the finite ones.
 * @param {number[]} values also infinite ones; NaN is left out @param {number} share
 */
function quantileOf(values, share) {
  const ranked = values.filter((value) => !Number.isNaN(value)).sort((a, b) => a - b);
  if (!ranked.length) return NaN;
  const rank = share * (ranked.length - 1);
  const [low, high] = [ranked[Math.floor(rank)], ranked[Math.ceil(rank)]];
  if (!Number.isFinite(low) || !Number.isFinite(high)) return low + high;
  return low + (rank - Math.floor(rank)) * (high - low);
}

/**
 * The same of transitions; NaN where it depends on the places of those that were not computed.
 * @param {Ends[]} ends @param {number} share
 */
function quantileOfEnds(ends, share) {
  const [low, high] = [0, 1].map((k) => quantileOf(ends.map((pair) => pair[k]), share));
  return low === high ? low : NaN;
}

/**
 * Transition along a line.
 * @param {Line} line @param {number} limit @param {Ends} range of the sweep itself
 * @param {number[]} gaps places of points that were asked for and are not done
 * @param {number[]} done places of points that are done
 * @returns {Transition}
 */
function transitionAlong(line, limit, range, gaps = [], done = line.x) {
  const { x, y } = line;
  const [low, high] = x.length ? [x[0], x[x.length - 1]] : [NaN, NaN];
  const place = crossing(line, limit);
  const result = (/** @type {number} */ outcome, /** @type {number} */ least, /** @type {number} */ most) =>
    /** @type {Transition} */ ({ place, outcome, ends: [least, most], computed: [low, high], bridged: 0 });
  if (Number.isFinite(place)) {
    return { ...result(CROSSES, place, place), bridged: bridgedAt(place, gaps, done) };
  }
  if (!x.length || Number.isNaN(limit)) return result(UNKNOWN, NaN, NaN);
  if (y[0] > limit) {
    return low <= range[0] ? result(SEVERE, -Infinity, -Infinity) : result(BELOW, -Infinity, low);
  }
  return high >= range[1] ? result(MILD, Infinity, Infinity) : result(ABOVE, high, Infinity);
}

/**
 * Number of gaps between the two points done next to a place.
 * @param {number} place @param {number[]} gaps @param {number[]} done ascending
 */
function bridgedAt(place, gaps, done) {
  const whole = done.filter((other) => !gaps.includes(other));
  const next = whole.find((other) => other >= place) ?? -Infinity;
  const last = whole[above(whole, place) - 1] ?? Infinity;
  return gaps.filter((gap) => gap > last && gap < next).length;
}

/** Points that crossings are interpolated across, in words. @param {Transition[]} transitions */
function bridgedText(transitions) {
  const counts = transitions.map(({ bridged }) => bridged).filter(Boolean);
  if (!counts.length) return "";
  if (transitions.length > 1) return `, ${counts.length} of them across points not done`;
  return `, across ${counts[0]} point${counts[0] > 1 ? "s" : ""} not done`;
}

/** Quantiles, mean and spread of transitions on several surfaces. @param {Transition[]} transitions */
function summaryOf(transitions) {
  const ends = transitions.map((transition) => transition.ends);
  const [low, middle, high] = BAND.map((share) => quantileOfEnds(ends, share));
  // A transition that was not computed has no mean.
  const places = ends
    .filter((pair) => !Number.isNaN(pair[0]))
    .map(([least, most]) => (least === most ? least : Infinity));
  const hasMean = places.length > 0 && places.every(Number.isFinite);
  const mean = hasMean ? sum(places) / places.length : NaN;
  const variance = sum(places.map((place) => (place - mean) ** 2)) / (places.length - 1);
  const spread = hasMean && places.length > 1 ? Math.sqrt(variance) : NaN;
  return { low, middle, high, mean, spread, transitions };
}

/** @param {number[]} values */
function sum(values) {
  return values.reduce((total, value) => total + value, 0);
}

/**
 * Value of a line, and beyond its ends by its power law where that leaves the kind of wear as it is.
 * @param {Line} line @param {number} place @param {number} limit
 */
function certainAt(line, place, limit) {
  const { x, y } = line;
  const last = x.length - 1;
  if (last < 0 || (place >= x[0] && place <= x[last])) return valueAt(line, place);
  if (place < x[0]) return y[0] <= limit ? Math.min(valueAt(line, place, true), y[0]) : NaN;
  return y[last] > limit ? Math.max(valueAt(line, place, true), y[last]) : NaN;
}
