/* The page of a plane: show all parts, and again whenever the reader changes something. */

/** Show all parts that depend on the reader's choices. */
function update() {
  document.body.classList.toggle("is-changed", Object.keys(changes()).length > 0);
  element("whole").toggleAttribute("hidden", !("low" in view.x));
  drawDiagram();
  showNow();
  showLegend();
  showTables();
  showMargin();
  showPoint();
}

/** Conditions that the reader has changed. */
function changes() {
  const own = new Map(Object.entries(content.conditions));
  const all = Object.entries(chosen.conditions);
  return Object.fromEntries(all.filter(([name, value]) => value !== own.get(name)));
}

readAddress();
listenToScene();
listenToConditions();
listenToView();
element("operating").addEventListener("change", choosePlace);
update();
new ResizeObserver(update).observe(element("diagram"));
setInterval(keepAddress, 1000); // at each step of a slider browsers would refuse it
