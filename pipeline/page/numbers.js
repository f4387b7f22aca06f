/* Functions on lists of numbers, independent of sweeps. */

/** Pairs of index and weight for linear interpolation; beyond the ends the end alone. @param
 * {number[]} x ascending @param {number} place @returns {[number, number][]} */
function weights(x, place) {
  const k = x.findIndex((value) => value > place);
  if (k < 1) return [[k < 0 ? x.length - 1 : 0, 1]];
  const weight = (place - x[k - 1]) / (x[k] - x[k - 1]);
  return weight === 0 ? [[k - 1, 1]] : [[k - 1, 1 - weight], [k, weight]];
}

/** Linear interpolation. @param {number[]} x ascending @param {ArrayLike<number>} y @param {number} place */
function linear(x, y, place) {
  return sum(weights(x, place).map(([k, weight]) => weight * y[k]));
}

/** Sum of the values. @param {number[]} values */
function sum(values) {
  return values.reduce((total, value) => total + value, 0);
}

/** Index of the nearest value. @param {number[]} x @param {number} place */
function nearest(x, place) {
  const away = x.map((value) => Math.abs(value - place));
  return away.indexOf(Math.min(...away));
}
