/* Content of the page, and choices of its reader: in SI, with units on display only. */

const ZERO_CELSIUS = 273.15;

/** @type {Content} */
const content = readContent();
/** Planes by conditions. @type {Map<string, Float64Array>} */
const planes = new Map();
const hasShare = content.shares.length > 1;
const hasFrictionCurve = new Set(content.friction_factors).size > 1; // by velocity
/** Choices of the reader. @type {{conditions: Conditions, surface: number | null, point: Point | null,
 * load: number, velocity: number}} */
const chosen = {
  conditions: { ...content.conditions }, surface: content.missing.length > 1 ? null : 0,
  point: null, load: NaN, velocity: NaN,
};

/** Surfaces that count: the one that was picked, or all. */
function surfaces() {
  return chosen.surface === null ? content.missing.map((_, surface) => surface) : [chosen.surface];
}

/** A plane that is made but once. @param {string} key @param {() => Float64Array} make */
function kept(key, make) {
  const made = planes.get(key) ?? make();
  if (planes.size > 50) planes.clear();
  planes.set(key, made);
  return made;
}

/** Temperature of a rise at friction 1 [K]: the lowest whose friction gives it. @param {number} rise */
function temperature(rise) {
  const [, factors] = content.friction_by_temperature;
  const { coldest, factor, limitOf } = heatOf(chosen.conditions);
  let [low, high] = [coldest, coldest + factor * Math.max(...factors) * rise];
  for (let n = 0; n < 40 && factors.length > 1; n += 1) {
    const middle = (low + high) / 2;
    [low, high] = limitOf(middle) < rise ? [middle, high] : [low, middle];
  }
  return high;
}

/** Fields and course are those of the present bulk temperatures. */
function isOwnBulk() {
  return heatOf(chosen.conditions).ratio === heatOf(content.conditions).ratio;
}

/** There is a critical temperature to judge by. */
function isJudged() {
  return chosen.conditions.critical_temperature !== null;
}
