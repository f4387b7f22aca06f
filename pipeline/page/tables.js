/* Critical velocities and loads as tables and as CSV. */

/** HTML table of texts; numbers are aligned right. @param {string[]} heads @param {string[][]} rows @param
 * {number} words number of last columns with words */
function table(heads, rows, words = 0) {
  const look = (/** @type {number} */ k) => (k < heads.length - words ? "number" : "");
  const cell = (/** @type {string} */ text, /** @type {number} */ k) =>
    (k ? html("td", { class: look(k) || `verdict-${text.replaceAll(" ", "-")}` }, text)
      : html("th", { scope: "row", class: look(0) }, text));
  const top = heads.map((head, k) => html("th", { scope: "col", class: look(k) }, head));
  const body = rows.map((row) => html("tr", {}, ...row.map(cell)));
  return html("table", {}, html("thead", {}, html("tr", {}, ...top)), html("tbody", {}, ...body));
}

/** Outcome along an axis in words. @param {AxisName} axis @param {number} at on the other axis */
function outcomeText(axis, at) {
  return isJudged() ? content.outcomes[axis][turnAt(axis, at, chosen.conditions).outcome] : "not known";
}

/** Critical velocities at the loads: computed, then 50, 5 and 95 % likely with tests. */
function criticalVelocities() {
  const turn = (/** @type {number} */ load, /** @type {number} */ level) =>
    turnAt("velocity", load, chosen.conditions, level).place;
  return content.loads.map((load) => {
    const computed = turn(load, isJudged() ? 0 : NaN);
    const near = Number.isNaN(computed) ? content.supports.velocity[0] : computed;
    const tested = [1, 0, 2].map((k) => {
      const found = turn(load, isJudged() ? levelAt({ load, velocity: near }, k) : NaN);
      return Number.isNaN(found) ? found : turn(load, levelAt({ load, velocity: found }, k));
    });
    return [computed, ...tested];
  });
}

/** Show critical values as a table, and offer it as CSV. @param {string} id @param {string[]} heads
 * @param {string[][]} rows */
function showSide(id, heads, rows) {
  element(id).replaceChildren(table([...heads, "outcome"], rows, 1));
  offerCsv(id, content.name);
}

/** Show both tables. */
function showTables() {
  const { loads, velocities } = content;
  const heads = ["load [N]", "critical velocity [m/s]", "with tests [m/s]", "5 % [m/s]", "95 % [m/s]"];
  showSide("velocities", heads, criticalVelocities().map((values, i) =>
    [shown(loads[i], 6), ...values.map((value) => shown(value)), outcomeText("velocity", loads[i])]));
  showSide("loads", ["velocity [m/s]", "critical load [N]"], velocities.map((velocity) =>
    [shown(velocity, 6), shown(turnAt("load", velocity, chosen.conditions).place),
      outcomeText("load", velocity)]));
}

/** Offer a table, as shown, as CSV. @param {string} id @param {string} name */
function offerCsv(id, name) {
  const lines = [...element(id).querySelectorAll("tr")].map((row) =>
    [...row.cells].map(({ textContent }) => JSON.stringify(textContent)).join(","));
  const href = `data:text/csv;charset=utf-8,${encodeURIComponent(lines.join("\r\n"))}`;
  Object.assign(element(`${id}-csv`), { href, download: `${name || "sweep"}_critical_${id}.csv` });
}
