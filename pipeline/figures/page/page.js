// @ts-check
"use strict";
/* The page as a whole: what is shown once, and what again whenever the reader sets something. */

/** Entries of nested data as pairs of a path and a text. @returns {[string, string][]} */
function flat(/** @type {any} */ data, /** @type {string} */ name = "") {
  const isList = Array.isArray(data) && data.every((each) => typeof each !== "object");
  if (data === null || typeof data !== "object" || isList) {
    return [[name, isList ? data.join(", ") : String(data)]];
  }
  return Object.keys(data).flatMap((key) => flat(data[key], name ? `${name}.${key}` : key));
}

function showRecord() {
  const own = content.conditions;
  const drawn = Object.keys(content.surfaces?.inputs ?? {});
  element("samples-note").hidden = !drawn.some((path) => /^(friction|temperature)\./.test(path));
  const inputs = flat(content.surfaces?.inputs ?? {});
  const rows = [...flat({ conditions: own, ...content.record }), ...inputs];
  const sizes = `${sweep.loads.length} loads, ${sweep.velocities.length} velocities`;
  const what = content.surfaces?.axis === "sample" ? "samples" : "surfaces";
  const several = content.surfaces ? `, ${sweep.surfaces} ${what}` : "";
  element("record").replaceChildren(
    table(`The scene as it was stored, in SI: ${sizes}${several}, ${content.done} points done.`,
      ["entry", "value"], rows, 2),
  );
}

/** @type {number | undefined} */
let waiting;

/** Do what a moving slider need not wait for once it rests. @param {() => void} work */
function onceAtRest(work) {
  clearTimeout(waiting);
  waiting = setTimeout(work, 200);
}

/** Show all that follows from what the reader has set. */
function update() {
  hideTip();
  drawDiagram();
  showLegend();
  const found = showTables();
  showMeasured();
  showMargin();
  showPoint();
  element("conditions-record").textContent = `Shown: ${conditionsText()}.`;
  onceAtRest(() => {
    element("summary").textContent = found;
    labelPoints();
  });
}

function begin() {
  makeConditions();
  makeOperating();
  makeScaleChoice();
  makeDiagram();
  showRecord();
  update();
  let width = element("diagram").clientWidth;
  new ResizeObserver(() => {
    if (element("diagram").clientWidth === width) return;
    width = element("diagram").clientWidth;
    makeDiagram();
    update();
  }).observe(element("diagram"));
}

begin();
