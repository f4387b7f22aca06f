"use strict";
/* Where values pass a limit, along a line and on a grid. Nothing here knows a sweep. */

const [CROSSES, MILD, SEVERE, UNKNOWN, ABOVE, BELOW, SEVERAL] = [0, 1, 2, 3, 4, 5, 6];
const BAND = [0.1, 0.5, 0.9];

/** The entries beside a place and their weights, the nearer end alone beyond them. @param {number[]} x
 * ascending @param {number} place @returns {[number, number][]} */
function weights(x, place) {
  const k = x.findIndex((value) => value > place);
  if (k < 1) return [[k < 0 ? x.length - 1 : 0, 1]];
  const weight = (place - x[k - 1]) / (x[k] - x[k - 1]);
  return weight === 0 ? [[k - 1, 1]] : [[k - 1, 1 - weight], [k, weight]];
}

/** Value at a place. @param {number[]} x ascending @param {ArrayLike<number>} y @param {number} place */
function linear(x, y, place) {
  return sum(weights(x, place).map(([k, weight]) => weight * y[k]));
}

/** @param {number[]} values */
function sum(values) {
  return values.reduce((total, value) => total + value, 0);
}

/** Index of the nearest value. @param {number[]} x @param {number} place */
function nearest(x, place) {
  const away = x.map((value) => Math.abs(value - place));
  return away.indexOf(Math.min(...away));
}

/** Value that a share of all stays below; NaN is left out. @param {number[]} values @param {number} share */
function quantileOf(values, share) {
  const ranked = values.filter((value) => !Number.isNaN(value)).sort((a, b) => a - b);
  const rank = share * (ranked.length - 1);
  const [low, high] = [ranked[Math.floor(rank)] ?? NaN, ranked[Math.ceil(rank)] ?? NaN];
  if (!Number.isFinite(low) || !Number.isFinite(high)) return low + high;
  return low + (rank - Math.floor(rank)) * (high - low);
}

/** The same; NaN where it depends on those that are not known. @param {Ends[]} ends @param {number} share */
function quantileOfEnds(ends, share) {
  const [low, high] = [0, 1].map((k) => quantileOf(ends.map((pair) => pair[k]), share));
  return low === high ? low : NaN;
}

/** Places at which values pass a limit. @param {number[]} x @param {number[]} y @param {number} limit */
function crossings(x, y, limit) {
  const known = x.map((_, k) => k).filter((k) => !Number.isNaN(y[k]));
  const turns = known.slice(1).map((k, n) => [known[n], k]).filter(([a, b]) => y[a] > limit !== y[b] > limit);
  const last = known[known.length - 1];
  if (!turns.length && y[last] === limit) return [x[last]];
  return turns.map(([a, b]) => x[a] * (x[b] / x[a]) ** (Math.log(limit / y[a]) / Math.log(y[b] / y[a])));
}

/** Values begin above a limit. @param {number[]} y @param {number} limit */
function beginsHot(y, limit) {
  return (y.find((value) => !Number.isNaN(value)) ?? NaN) > limit;
}

/** Ranges in which wear is severe. @param {number[]} places @param {boolean} isHot */
function severeRanges(places, isHot) {
  const all = isHot ? [0, ...places] : places;
  return all.flatMap((begin, k) => (k % 2 ? [] : [[begin, all[k + 1] ?? Infinity]]));
}

/** Transition along a line, as pipeline.analysis.transition has it. @param {number[]} x @param {number[]} y
 * NaN where not known @param {number} limit @param {Ends} range of the sweep itself @returns {Transition} */
function transitionAlong(x, y, limit, range) {
  const done = x.filter((_, k) => !Number.isNaN(y[k]));
  const [places, isHot] = [crossings(x, y, limit), beginsHot(y, limit)];
  const [from, to] = [done[0] ?? NaN, done[done.length - 1] ?? NaN];
  let outcome = isHot ? (from <= range[0] ? SEVERE : BELOW) : to >= range[1] ? MILD : ABOVE;
  if (places.length) outcome = places.length > 1 || isHot ? SEVERAL : CROSSES;
  if (!done.length || Number.isNaN(limit)) outcome = UNKNOWN;
  /** @type {Ends[]} by outcome */
  const ends = [
    [places[0], places[0]], [Infinity, Infinity], [-Infinity, -Infinity], [NaN, NaN],
    [to, Infinity], [-Infinity, from], [NaN, NaN],
  ];
  return { places, isHot, outcome, computed: [from, to], ends: ends[outcome] };
}


/** Path of the part of a grid where all of several values are positive, or along which one is 0. @param
 * {number[]} x @param {number[]} y [px] @param {number[][][]} grids values by y and x, or NaN @param
 * {boolean} isLine */
function contour(x, y, grids, isLine = false) {
  const cells = y.slice(1).flatMap((_top, i) => x.slice(1).map((_right, j) =>
    [[i, j], [i, j + 1], [i + 1, j + 1], [i + 1, j]].map(([k, l]) =>
      [x[l], y[k], ...grids.map((grid) => grid[k][l])])));
  return cells.filter((corners) => !corners.flat().some(Number.isNaN)).flatMap((corners) => {
    const part = grids.reduce((rest, _, n) => clipped(rest, n + 2, isLine), corners);
    return isLine ? [part.slice(0, 2), part.slice(2)] : [part]; // a saddle has two lines
  }).map((part) => {
    const text = part.map(([across, down]) => `${across.toFixed(2)},${down.toFixed(2)}`).join("L");
    return text && `M${text}${isLine ? "" : "Z"}`;
  }).join("");
}

/** The corners of a polygon at which a value is positive, and the places at which it turns; or these alone.
 * @param {number[][]} corners @param {number} value its index in each @param {boolean} isLine */
function clipped(corners, value, isLine) {
  return corners.flatMap((corner, k) => {
    const next = corners[(k + 1) % corners.length];
    const [here, there] = [corner[value], next[value]];
    const kept = here > 0 && !isLine ? [corner] : [];
    if (here > 0 === there > 0) return kept;
    return [...kept, corner.map((own, n) => own + (here / (here - there)) * (next[n] - own))];
  });
}
