// @ts-check
"use strict";
/* The page as a whole: the parts that are shown once, and again whenever the reader sets something. */

/** @type {number | undefined} */
let waiting;

/** Show all that follows from the choices of the reader. */
function update() {
  pointTo(null);
  if (sweep.takeWearRate(chosen.conditions.wear_rate)) makeDiagram();
  drawDiagram();
  showLegend();
  const answer = showTables();
  showMeasured();
  showMargin();
  showPoint();
  clearTimeout(waiting);
  waiting = setTimeout(() => { // a screen reader is told once a moving slider rests
    element("summary").textContent = answer;
  }, 200);
}

/** Conditions that the reader has changed. */
function changes() {
  const own = new Map(Object.entries(content.conditions));
  const all = Object.entries(chosen.conditions);
  return Object.fromEntries(all.filter(([name, value]) => value !== own.get(name)));
}

function begin() {
  Object.assign(chosen.conditions, takeScene(changes));
  listenToConditions();
  listenToOperatingPoint(takeOperatingPoint);
  makeDiagram();
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
