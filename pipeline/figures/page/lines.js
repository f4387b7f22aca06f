// @ts-check
"use strict";
/* Straight lines through tabulated values, and where they reach a limit. Nothing here knows a sweep. */

/**
 * @typedef {[number, number]} Ends least and greatest place that a transition may have
 * @typedef {{outcome: number, ends: Ends, computed: Ends, isBridged: boolean}} Transition
 *   isBridged where it is interpolated across points that are not done
 * @typedef {{low: number, middle: number, high: number, transitions: Transition[]}} Summary
 *   transitions on several surfaces, and their quantiles
 */

const [CROSSES, MILD, SEVERE, UNKNOWN, ABOVE, BELOW, SEVERAL] = [0, 1, 2, 3, 4, 5, 6];
const BAND = [0.1, 0.5, 0.9];

/** Index of the first entry above a value. @param {ArrayLike<number>} x ascending @param {number} value */
function above(x, value) {
  let low = 0;
  let high = x.length;
  while (low < high) {
    const middle = (low + high) >> 1;
    if (x[middle] > value) high = middle;
    else low = middle + 1;
  }
  return low;
}

/**
 * The entries beside a place and their weights, the nearer end alone beyond them.
 * @param {ArrayLike<number>} x ascending @param {number} place @returns {[number, number][]}
 */
function weights(x, place) {
  const last = x.length - 1;
  if (last < 1 || !(place > x[0])) return [[0, 1]];
  if (place >= x[last]) return [[last, 1]];
  const k = above(x, place);
  const weight = (place - x[k - 1]) / (x[k] - x[k - 1]);
  return weight === 0 ? [[k - 1, 1]] : [[k - 1, 1 - weight], [k, weight]];
}

/**
 * Value by straight lines, that of the nearer end beyond them.
 * @param {ArrayLike<number>} x ascending @param {ArrayLike<number>} y @param {number} place
 */
function linear(x, y, place) {
  return sum(weights(x, place).map(([k, weight]) => weight * y[k]));
}

/** @param {number[]} values */
function sum(values) {
  return values.reduce((total, value) => total + value, 0);
}

/**
 * Value at a place on the straight line through two points, of the logarithms where there are any.
 * @param {number} a @param {number} b @param {number} low @param {number} high @param {number} place
 */
function onLine(a, b, low, high, place) {
  if (a > 0 && low > 0 && high > 0) return low * (place / a) ** (Math.log(high / low) / Math.log(b / a));
  return low + ((place - a) / (b - a)) * (high - low);
}

/**
 * Value of a line at a place; NaN beyond its ends.
 * @param {number[]} x ascending @param {number[]} y @param {number} place
 */
function valueAt(x, y, place) {
  const k = above(x, place);
  if (x[k - 1] === place) return y[k - 1];
  return k === 0 || k === x.length ? NaN : onLine(x[k - 1], x[k], y[k - 1], y[k], place);
}

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
 * Transition along a line: where it first rises above a limit, or why it does not.
 * @param {number[]} x ascending @param {number[]} y NaN where not known @param {number} limit
 * @param {number[]} range of the sweep itself @param {(k: number) => boolean} isBridged by index
 * @returns {Transition}
 */
function transitionAlong(x, y, limit, range, isBridged = () => false) {
  const known = x.map((_, k) => k).filter((k) => !Number.isNaN(y[k]));
  const [low, high] = known.length ? [x[known[0]], x[known[known.length - 1]]] : [NaN, NaN];
  const result = (/** @type {number} */ outcome, /** @type {number} */ least, /** @type {number} */ most) =>
    /** @type {Transition} */ ({ outcome, ends: [least, most], computed: [low, high], isBridged: false });
  if (!known.length || Number.isNaN(limit)) return result(UNKNOWN, NaN, NaN);
  const n = known.findIndex((k) => y[k] >= limit);
  if (n < 0) return high >= range[1] ? result(MILD, Infinity, Infinity) : result(ABOVE, high, Infinity);
  const hot = known.findIndex((k) => y[k] > limit);
  if (hot >= 0 && known.slice(hot).some((k) => y[k] <= limit)) return result(SEVERAL, NaN, NaN);
  const [last, first] = [known[n - 1], known[n]];
  if (n === 0 && y[first] > limit) {
    return low <= range[0] ? result(SEVERE, -Infinity, -Infinity) : result(BELOW, -Infinity, low);
  }
  const place = y[first] === limit ? x[first] : onLine(y[last], y[first], x[last], x[first], limit);
  return { ...result(CROSSES, place, place), isBridged: isBridged(first) || (n > 0 && isBridged(last)) };
}

/** Quantiles of transitions on several surfaces. @param {Transition[]} transitions @returns {Summary} */
function summaryOf(transitions) {
  const ends = transitions.map((transition) => transition.ends);
  const [low, middle, high] = BAND.map((share) => quantileOfEnds(ends, share));
  return { low, middle, high, transitions };
}

/** Bytes of base64. @param {string} text */
function bytes(text) {
  return Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0)).buffer;
}
