// @ts-check
"use strict";
/*
 * Values close to a power law, and where they reach a limit, as pipeline.analysis.interpolation
 * has them: the logarithm of y over that of x by a cubic that is monotone between the points.
 */

/**
 * @typedef {(x: number) => number} Smooth
 * @typedef {{x: number[], y: number[], smooth: Smooth | null}} Line finite values, ascending in x
 */

/**
 * Slopes at the points of a cubic that is monotone between them (PCHIP), as SciPy's.
 * @param {number[]} h widths of the intervals @param {number[]} m their mean slopes
 */
function slopes(h, m) {
  const n = h.length;
  if (n === 1) return [m[0], m[0]];
  const inner = m.slice(1).map((after, k) => {
    if (m[k] * after <= 0) return 0;
    const [w1, w2] = [2 * h[k + 1] + h[k], h[k + 1] + 2 * h[k]];
    return (w1 + w2) / (w1 / m[k] + w2 / after);
  });
  const [first, last] = [endSlope(h[0], h[1], m[0], m[1]), endSlope(h[n - 1], h[n - 2], m[n - 1], m[n - 2])];
  return [first, ...inner, last];
}

/**
 * Slope at an end, of three points.
 * @param {number} h0 @param {number} h1 @param {number} m0 @param {number} m1
 */
function endSlope(h0, h1, m0, m1) {
  const d = ((2 * h0 + h1) * m0 - h0 * m1) / (h0 + h1);
  if (Math.sign(d) !== Math.sign(m0)) return 0;
  if (Math.sign(m0) !== Math.sign(m1) && Math.abs(d) > 3 * Math.abs(m0)) return 3 * m0;
  return d;
}

/**
 * Cubic through points, and its slope at the first of them.
 * @param {number[]} x ascending, at least two @param {number[]} y
 * @returns {{value: Smooth, slope: number}}
 */
function pchip(x, y) {
  const h = x.slice(1).map((end, k) => end - x[k]);
  const m = h.map((width, k) => (y[k + 1] - y[k]) / width);
  const d = slopes(h, m);
  const value = (/** @type {number} */ place) => {
    const k = Math.min(Math.max(above(x, place) - 1, 0), h.length - 1);
    const s = place - x[k];
    const c = (3 * m[k] - 2 * d[k] - d[k + 1]) / h[k];
    const b = (d[k] - 2 * m[k] + d[k + 1]) / (h[k] * h[k]);
    return y[k] + s * (d[k] + s * (c + s * b));
  };
  return { value, slope: d[0] };
}

/**
 * Index of the first entry above a value.
 * @param {ArrayLike<number>} x ascending @param {number} value
 */
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
 * Index of a place on an axis, or of the two that it lies between.
 * @param {number[]} x ascending @param {number} place
 */
function beside(x, place) {
  const next = above(x, place);
  return x[next - 1] === place ? [next - 1] : [next - 1, next];
}

/**
 * Value by straight lines, that of the nearer end beyond them.
 * @param {ArrayLike<number>} x ascending @param {ArrayLike<number>} y @param {number} place
 */
function linear(x, y, place) {
  const last = x.length - 1;
  if (!(place > x[0])) return y[0];
  if (place >= x[last]) return y[last];
  const k = above(x, place);
  const weight = (place - x[k - 1]) / (x[k] - x[k - 1]);
  return (1 - weight) * y[k - 1] + weight * y[k];
}

/**
 * Interpolant of values close to a power law.
 * @param {number[]} x ascending, at least two @param {number[]} y @returns {Smooth}
 */
function interpolant(x, y) {
  const isPositive = (/** @type {number} */ value) => value > 0;
  if (x.every(isPositive) && y.every(isPositive)) {
    const cubic = pchip(x.map(Math.log), y.map(Math.log));
    return (place) => Math.exp(cubic.value(Math.log(place)));
  }
  if (x[0] === 0 && y[0] === 0 && x.length > 2 && y.slice(1).every(isPositive)) {
    // From the first point down to 0, the power law goes on with which the others begin.
    const cubic = pchip(x.slice(1).map(Math.log), y.slice(1).map(Math.log));
    if (cubic.slope > 0.25) {
      return (place) =>
        place < x[1] ? y[1] * (place / x[1]) ** cubic.slope : Math.exp(cubic.value(Math.log(place)));
    }
  }
  return pchip(x, y).value;
}

/**
 * Line through the finite values of a row.
 * @param {number[]} x ascending @param {number[]} y @returns {Line}
 */
function lineOf(x, y) {
  const places = x.filter((_, k) => Number.isFinite(y[k]));
  const values = y.filter(Number.isFinite);
  return { x: places, y: values, smooth: places.length > 1 ? interpolant(places, values) : null };
}

/**
 * First place at which a line goes from below to above a limit; NaN if there is none.
 * @param {Line} line @param {number} limit
 */
function crossing({ x, y, smooth }, limit) {
  const first = y.findIndex((value) => value >= limit);
  if (first < 0) return NaN;
  if (y[first] === limit) return x[first];
  if (first === 0 || !smooth) return NaN;
  let [low, high] = [x[first - 1], x[first]];
  while (high - low > 1e-12 * high) {
    const middle = (low + high) / 2;
    if (smooth(middle) < limit) low = middle;
    else high = middle;
  }
  return (low + high) / 2;
}

/**
 * Value of a line; NaN beyond its ends, or by the power law of its last two points.
 * @param {Line} line @param {number} place @param {boolean} [isContinued]
 */
function valueAt({ x, y, smooth }, place, isContinued = false) {
  const last = x.length - 1;
  const same = x.indexOf(place);
  if (same >= 0) return y[same];
  if (!smooth) return NaN;
  if (place >= x[0] && place <= x[last]) return smooth(place);
  if (!isContinued || !(place > 0) || [...x, ...y].some((value) => value <= 0)) return NaN;
  const [i, j] = place < x[0] ? [0, 1] : [last, last - 1];
  return y[i] * (place / x[i]) ** (Math.log(y[i] / y[j]) / Math.log(x[i] / x[j]));
}

/**
 * A row through one more point, so that what follows from both agrees.
 * @param {number[]} x @param {number[]} y @param {number} place @param {number} value @returns {Line}
 */
function withPoint(x, y, place, value) {
  const end = above(x, place);
  const begin = x[end - 1] === place ? end - 1 : end;
  const insert = (/** @type {number[]} */ row, /** @type {number} */ entry) =>
    [...row.slice(0, begin), entry, ...row.slice(end)];
  return lineOf(insert(x, place), insert(y, value));
}
