"use strict";
/* Content of the page, and choices of its reader: in SI, with units on display only. */

const ZERO_CELSIUS = 273.15;

/** @type {Content} */
const content = JSON.parse(element("content").textContent ?? "");
const sweep = new Sweep(content);
const hasShare = content.shares.length > 1;
/** Choices of the reader. @type {{conditions: Conditions, surface: number | null, point: {i: number, j:
 * number} | null, load: number, velocity: number}} */
const chosen = {
  conditions: { ...content.conditions }, surface: sweep.surfaces > 1 ? null : 0,
  point: null, load: NaN, velocity: NaN,
};

/** Surfaces that count: the one that was picked, or all. */
function surfaces() {
  if (chosen.surface !== null) return [chosen.surface];
  return Array.from({ length: sweep.surfaces }, (_, k) => k);
}

/** Temperature of a rise at friction 1 [K]. @param {number} rise */
function temperature(rise) {
  return coldestBulk(chosen.conditions) + riseFactor(chosen.conditions) * rise;
}

/** There is a critical temperature to judge by. */
function isJudged() {
  return chosen.conditions.critical_temperature !== null;
}
