// @ts-check
"use strict";
/* The transition along a line of points, by the same rule as pipeline.analysis.transition. */

const CROSSES = 0;
const MILD = 1;
const SEVERE = 2;
const UNKNOWN = 3;
const ABOVE = 4;
const BELOW = 5;

/**
 * Value that a share of all stays below, linear between them; infinite if beyond the finite ones.
 * @param {number[]} values also infinite ones; NaN is left out @param {number} share
 */
function quantileOf(values, share) {
  const ranked = values.filter((value) => !Number.isNaN(value)).sort((a, b) => a - b);
  if (!ranked.length) return NaN;
  const place = share * (ranked.length - 1);
  const low = ranked[Math.floor(place)];
  const high = ranked[Math.ceil(place)];
  if (!Number.isFinite(low) || !Number.isFinite(high)) return low + high;
  return low + (place - Math.floor(place)) * (high - low);
}

/**
 * The same of transitions; NaN where it depends on where those lie that were not computed.
 * @param {Ends[]} ends @param {number} share
 */
function quantileOfEnds(ends, share) {
  const [low, high] = [0, 1].map((end) => quantileOf(ends.map((each) => each[end]), share));
  return low === high ? low : NaN;
}

/**
 * Transitions along lines of points.
 * @param {Line[]} lines @param {number} limit @param {[number, number]} range of the sweep itself
 * @returns {Crossings}
 */
function crossings(lines, limit, range) {
  const at = lines.map((line) => crossing(line, limit));
  const outcome = at.map((value, k) => outcomeOf(lines[k], value, limit, range));
  return {
    at,
    outcome,
    ends: at.map((value, k) => endsOf(lines[k], value, outcome[k])),
    computed: lines.map(({ x }) => (x.length ? [x[0], x[x.length - 1]] : [NaN, NaN])),
  };
}

/**
 * Transition along a line that goes on where it is certain, else along its computed points.
 * @param {Line[]} lines both @param {number} limit @param {[number, number]} range
 */
function transition([computed, going], limit, range) {
  const found = crossings([going], limit, range);
  return found.outcome[0] === CROSSES ? found : crossings([computed], limit, range);
}

/**
 * Outcome along a line (pipeline.analysis.transition).
 * @param {Line} line @param {number} found @param {number} limit @param {[number, number]} range
 */
function outcomeOf({ x, y }, found, limit, range) {
  if (Number.isFinite(found)) return CROSSES;
  if (!y.length || Number.isNaN(limit)) return UNKNOWN;
  if (y[0] > limit) return x[0] <= range[0] ? SEVERE : BELOW;
  return x[x.length - 1] >= range[1] ? MILD : ABOVE;
}

/**
 * Least and greatest place that a transition may have.
 * @param {Line} line @param {number} at @param {number} outcome @returns {Ends}
 */
function endsOf({ x }, at, outcome) {
  if (outcome === MILD) return [Infinity, Infinity];
  if (outcome === SEVERE) return [-Infinity, -Infinity];
  if (outcome === ABOVE) return [x[x.length - 1], Infinity];
  if (outcome === BELOW) return [-Infinity, x[0]];
  return [at, at];
}

/**
 * Value of a line, and beyond its ends by its power law where that leaves the kind of wear as it is.
 * @param {Line} line @param {number} at @param {number} limit
 */
function certainAt(line, at, limit) {
  const { x, y } = line;
  const last = x.length - 1;
  if (last < 0 || (at >= x[0] && at <= x[last])) return valueAt(line, at);
  if (at < x[0]) return y[0] <= limit ? Math.min(valueAt(line, at, true), y[0]) : NaN;
  return y[last] > limit ? Math.max(valueAt(line, at, true), y[last]) : NaN;
}
