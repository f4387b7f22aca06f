// @ts-check
"use strict";
/* The transition along a line of points, by the same rule as pipeline.analysis.transition. */

/**
 * @typedef {[number, number]} Ends least and greatest place that a transition may have
 * @typedef {{place: number, outcome: number, ends: Ends, computed: Ends}} Transition
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
 * @returns {Transition}
 */
function transitionAlong(line, limit, range) {
  const { x, y } = line;
  const [low, high] = x.length ? [x[0], x[x.length - 1]] : [NaN, NaN];
  const place = crossing(line, limit);
  const result = (/** @type {number} */ outcome, /** @type {number} */ least, /** @type {number} */ most) =>
    /** @type {Transition} */ ({ place, outcome, ends: [least, most], computed: [low, high] });
  if (Number.isFinite(place)) return result(CROSSES, place, place);
  if (!x.length || Number.isNaN(limit)) return result(UNKNOWN, NaN, NaN);
  if (y[0] > limit) {
    return low <= range[0] ? result(SEVERE, -Infinity, -Infinity) : result(BELOW, -Infinity, low);
  }
  return high >= range[1] ? result(MILD, Infinity, Infinity) : result(ABOVE, high, Infinity);
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
