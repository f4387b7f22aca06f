"use strict";
/* The limit of the rise under conditions, as pipeline.sweep.severity has it; the rises are Python's. */

/** Bulk temperature of the disk less that of the pin [K]. @param {Conditions} conditions */
function bulkDifference({ bulk_temperature, disk_temperature = bulk_temperature }) {
  return disk_temperature - bulk_temperature;
}

/** Factor of the rise at friction 1: the friction. Without friction unequal bulk temperatures still warm one
 * of the bodies; then it is so small that their ratio to it is the largest one that is kept. @param
 * {Conditions} conditions */
function riseFactor(conditions) {
  const largest = Math.max(...content.bulk_ratios, 1);
  return Math.max(conditions.friction, Math.abs(bulkDifference(conditions)) / largest);
}

/** Difference of the bulk temperatures over the factor of the rise [K]. @param {Conditions} conditions */
function bulkRatio(conditions) {
  const difference = bulkDifference(conditions);
  return difference === 0 ? 0 : difference / riseFactor(conditions);
}

/** Bulk temperature of the colder body [K]. @param {Conditions} conditions */
function coldestBulk(conditions) {
  return conditions.bulk_temperature + Math.min(0, bulkDifference(conditions));
}

/** Rise at friction 1 above which wear is severe [K]; infinite without friction. @param {Conditions}
 * conditions */
function riseLimit(conditions) {
  const { critical_temperature } = conditions;
  if (critical_temperature === null) return NaN;
  const factor = riseFactor(conditions);
  return factor === 0 ? Infinity : (critical_temperature - coldestBulk(conditions)) / factor;
}
