// @ts-check
"use strict";
/* The page as a whole: what is shown once, and what again whenever the reader sets something. */

function showRecord() {
  const sizes = `${sweep.loads.length} loads, ${sweep.velocities.length} velocities`;
  const several = content.surfaces ? `, ${sweep.surfaces} surfaces` : "";
  element("record").replaceChildren(
    table(`The scene as it was stored: ${sizes}${several}, ${content.done} points done.`,
      ["entry", "value"], Object.entries(content.record), 2),
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
  if (sweep.takeWearRate(chosen.conditions.wear_rate)) makeDiagram();
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
