/* Data of the page, and choices of its reader. All values are in SI; other units are for display. */

const ZERO_CELSIUS = 273.15;

/** @type {Content} */
const content = readContent();
const { SEVERAL } = content.codes;
const OUTSIDE = content.outcomes.velocity[content.outcomes.velocity.length - 1]; // a film carries too much
/** Computed planes by conditions. @type {Map<string, Float64Array>} */
const planes = new Map();
/** Choices of the reader. @type {{conditions: Conditions, point: Point | null, load: number, velocity:
 * number}} */
const chosen = { conditions: { ...content.conditions }, point: null, load: NaN, velocity: NaN };

/** Plane from the cache; `make` computes it first. @param {string} key @param {() => Float64Array} make */
function kept(key, make) {
  const made = planes.get(key) ?? make();
  if (planes.size > 50) planes.clear();
  planes.set(key, made);
  return made;
}

/** Contact temperature [K] that a rise at friction 1 makes. @param {number} rise */
function temperature(rise) {
  const { coldest, factor } = heatOf(chosen.conditions);
  return coldest + factor * rise;
}

/** Deciding temperature at a node [K]. @param {number} node */
function decidingTemperature(node) {
  return temperature(riseAt(node, chosen.conditions));
}

/** True if the stored fields hold for the chosen bulk temperatures. */
function isOwnBulk() {
  return heatOf(chosen.conditions).ratio === heatOf(content.conditions).ratio;
}

/** True if there is a critical temperature. */
function isJudged() {
  return chosen.conditions.critical_temperature !== null;
}
