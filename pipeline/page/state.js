/* Data of the page, and choices of its reader. All values are in SI; other units are for display. */

const ZERO_CELSIUS = 273.15;

/** @type {Content} */
const content = readContent();
const OUTSIDE = content.outcomes.velocity[content.outcomes.velocity.length - 1]; // the last
/** Planes of `planeOf` by conditions. @type {Map<string, Float64Array>} */
const planes = new Map();
/** Conditions and operating point of the reader. @type {Place & {conditions: Conditions}} */
const chosen = { conditions: { ...content.conditions }, load: NaN, velocity: NaN };

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
