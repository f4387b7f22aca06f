// @ts-check
"use strict";
/*
 * Values close to a power law, and where they reach a limit, as pipeline.analysis.interpolation
 * has them: the logarithm of y over that of x by a cubic that is monotone between the points.
 */

/**
 * @typedef {{value: (at: number) => number}} Smooth
 * @typedef {{x: number[], y: number[], smooth: Smooth | null}} Line known values, ascending in x
 */

/**
 * Cubic through points that is monotone between them (PCHIP), as scipy's PchipInterpolator.
 * @param {number[]} x ascending, at least two
 * @param {number[]} y
 */
function pchip(x, y) {
  const n = x.length;
  /** @type {number[]} */
  const h = [];
  /** @type {number[]} */
  const m = [];
  for (let k = 0; k < n - 1; k++) {
    h.push(x[k + 1] - x[k]);
    m.push((y[k + 1] - y[k]) / h[k]);
  }
  /** @type {number[]} */
  const d = new Array(n);
  if (n === 2) {
    d[0] = d[1] = m[0];
  } else {
    for (let k = 1; k < n - 1; k++) {
      const before = m[k - 1];
      const after = m[k];
      if (before * after <= 0) {
        d[k] = 0;
      } else {
        const w1 = 2 * h[k] + h[k - 1];
        const w2 = h[k] + 2 * h[k - 1];
        d[k] = (w1 + w2) / (w1 / before + w2 / after);
      }
    }
    d[0] = endSlope(h[0], h[1], m[0], m[1]);
    d[n - 1] = endSlope(h[n - 2], h[n - 3], m[n - 2], m[n - 3]);
  }
  return {
    slope: d,
    /** @param {number} at */
    value(at) {
      const k = Math.min(Math.max(above(x, at) - 1, 0), n - 2);
      const s = at - x[k];
      const c = (3 * m[k] - 2 * d[k] - d[k + 1]) / h[k];
      const b = (d[k] - 2 * m[k] + d[k + 1]) / (h[k] * h[k]);
      return y[k] + s * (d[k] + s * (c + s * b));
    },
  };
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
 * Value at an abscissa by straight lines, that of the nearer end beyond them.
 * @param {ArrayLike<number>} x ascending @param {ArrayLike<number>} y @param {number} at
 */
function linear(x, y, at) {
  const last = x.length - 1;
  if (!(at > x[0])) return y[0];
  if (at >= x[last]) return y[last];
  const k = above(x, at);
  const weight = (at - x[k - 1]) / (x[k] - x[k - 1]);
  return (1 - weight) * y[k - 1] + weight * y[k];
}

/**
 * Interpolant of values close to a power law (pipeline.analysis.interpolation).
 * @param {number[]} x ascending, at least two @param {number[]} y @returns {Smooth}
 */
function interpolant(x, y) {
  const positive = (/** @type {number} */ value) => value > 0;
  if (x.every(positive) && y.every(positive)) {
    const cubic = pchip(x.map(Math.log), y.map(Math.log));
    return { value: (at) => Math.exp(cubic.value(Math.log(at))) };
  }
  if (x[0] === 0 && y[0] === 0 && x.length > 2 && y.slice(1).every(positive)) {
    // From the first point down to 0, the power law goes on with which the others begin.
    const first = x[1];
    const cubic = pchip(x.slice(1).map(Math.log), y.slice(1).map(Math.log));
    const exponent = cubic.slope[0];
    if (exponent > 0.25) {
      return {
        value: (at) =>
          at < first
            ? y[1] * (at / first) ** exponent
            : Math.exp(cubic.value(Math.log(Math.max(at, first)))),
      };
    }
  }
  return pchip(x, y);
}

/**
 * The points of a row that are known.
 * @param {number[]} x ascending @param {number[]} y NaN where not known @returns {Line}
 */
function lineOf(x, y) {
  const at = x.filter((_, k) => Number.isFinite(y[k]));
  const known = y.filter(Number.isFinite);
  return { x: at, y: known, smooth: at.length > 1 ? interpolant(at, known) : null };
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
  return root((at) => smooth.value(at) - limit, x[first - 1], x[first]);
}

/**
 * Root of a monotone function that is below 0 at `low` and above at `high`: by regula falsi, which
 * halves the weight of an end that stays, and by halving where that is slow.
 * @param {(at: number) => number} f @param {number} low @param {number} high
 */
function root(f, low, high) {
  let below = f(low);
  let over = f(high);
  // Within rounding of a point the interpolant may lie on the other side of the limit.
  if (below >= 0) return low;
  if (over <= 0) return high;
  let side = 0;
  for (let turn = 0; turn < 200; turn++) {
    const halve = turn % 4 === 3;
    const at = halve ? (low + high) / 2 : (low * over - high * below) / (over - below);
    if (!(at > low && at < high)) return at <= low ? low : high;
    const value = f(at);
    if (value === 0) return at;
    if (value < 0) {
      low = at;
      below = value;
      if (side < 0) over /= 2;
      side = halve ? 0 : -1;
    } else {
      high = at;
      over = value;
      if (side > 0) below /= 2;
      side = halve ? 0 : 1;
    }
    if (high - low <= 1e-15 * high) break;
  }
  return (low + high) / 2;
}

/**
 * Value of a line; NaN beyond its ends, or by the power law of its last two points.
 * @param {Line} line @param {number} at @param {boolean} [continued]
 */
function valueAt({ x, y, smooth }, at, continued = false) {
  const n = x.length;
  const same = x.indexOf(at);
  if (same >= 0) return y[same];
  if (!smooth) return NaN;
  if (at >= x[0] && at <= x[n - 1]) return smooth.value(at);
  if (!continued || !(at > 0) || [...x, ...y].some((value) => value <= 0)) return NaN;
  const [i, j] = at < x[0] ? [0, 1] : [n - 1, n - 2];
  return y[i] * (at / x[i]) ** (Math.log(y[i] / y[j]) / Math.log(x[i] / x[j]));
}

/**
 * A row through one more point, so that what follows from both agrees.
 * @param {number[]} x @param {number[]} y @param {number} at @param {number} value @returns {Line}
 */
function withPoint(x, y, at, value) {
  const others = x.map((each, k) => [each, y[k]]).filter(([each]) => each !== at);
  const all = [...others, [at, value]].sort((a, b) => a[0] - b[0]);
  return lineOf(all.map(([each]) => each), all.map(([, each]) => each));
}
