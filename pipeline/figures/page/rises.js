// @ts-check
"use strict";
/* Tables of rises that Python has made, by wear rate, bulk ratio, and share or quantile. */

/**
 * Rises at a wear rate, of those at several: by the power law between these.
 * @param {Float64Array | Float32Array} values by moment, wear rate and the rest
 * @param {number[]} rates ascending @param {number} rate @param {number} rest number of values
 * @returns {ArrayLike<number>}
 */
function atWearRate(values, rates, rate, rest) {
  if (rates.length < 2) return values;
  const found = new Float64Array(values.length / rates.length);
  for (let k = 0; k < found.length; k++) {
    const moment = Math.floor(k / rest);
    const begin = moment * rates.length * rest + (k % rest);
    found[k] = valueAt(lineOf(rates, rates.map((_, at) => values[begin + at * rest])), rate);
  }
  return found;
}

/** Rises above the colder body by moment, bulk ratio and column [K]. */
class Table {
  /** @param {ArrayLike<number>} values @param {number[]} ratios ascending @param {number} width */
  constructor(values, ratios, width) {
    this.values = values;
    this.ratios = ratios;
    this.width = width;
  }

  /** Row of a moment, linear between the bulk ratios. @param {number} moment @param {number} ratio */
  row(moment, ratio) {
    const { values, ratios, width } = this;
    const high = Math.min(above(ratios, ratio), ratios.length - 1);
    const low = Math.max(high - 1, 0);
    const weight = high > low ? (ratio - ratios[low]) / (ratios[high] - ratios[low]) : 0;
    const value = (/** @type {number} */ at, /** @type {number} */ k) =>
      values[(moment * ratios.length + at) * width + k];
    return Array.from({ length: width }, (_, k) =>
      weight === 0 ? value(low, k) : (1 - weight) * value(low, k) + weight * value(high, k),
    );
  }
}
