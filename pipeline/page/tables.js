/* Critical velocities and loads as tables and as CSV. */

/** Summaries of the transitions: along velocity for each load, along load for each velocity. */
function boundaries() {
  const over = (/** @type {AxisName} */ axis, /** @type {number} */ node) =>
    summaryOf(transitions(axis, node, chosen.conditions));
  return {
    velocity: content.nodes.load.map((node) => over("velocity", node)),
    load: content.nodes.velocity.map((node) => over("load", node)),
  };
}

/** Quantiles over surfaces of their transitions. @param {Transition[]} all @returns {Summary} */
function summaryOf(all) {
  const [low, middle, high] = BAND.map((share) => quantileOfEnds(all.map(endsOf), share));
  return { low, middle, high, transitions: all };
}

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

/** Ranges of severe wear in words. @param {Ends[]} severe @param {string} unit */
function rangesText(severe, unit) {
  const ranges = severe.map(([begin, end]) => end === Infinity ? `from ${shown(begin, 3)} ${unit} on`
    : `${begin ? `from ${shown(begin, 3)}` : "up"} to ${shown(end, 3)} ${unit}`);
  return `severe ${ranges.join(" and ")}`;
}

/** Outcome in words with the computed range, as in pipeline.analysis.transition. @param {Transition}
 * transition @param {"velocity" | "load"} along @param {string} unit */
function outcomeWords({ outcome, computed, severe }, along, unit) {
  if (outcome === SEVERAL) return rangesText(severe, unit);
  const [from, to] = computed.map((end) => `${shown(end)} ${unit}`);
  const reach = outcome === ABOVE ? ` (to ${to})` : outcome === BELOW ? ` (from ${from})` : "";
  return content.outcomes[along][outcome] + reach;
}

/** Outcomes in words, over all surfaces. @param {{transitions: Transition[]}} row @param {string} unit */
function outcomeText({ transitions }, unit) {
  const along = unit === "N" ? "load" : "velocity";
  const words = content.outcomes[along];
  if (transitions.length === 1) return outcomeWords(transitions[0], along, unit);
  const counts = words.map((_, code) => transitions.filter(({ outcome }) => outcome === code).length);
  const texts = counts.map((count, code) =>
    code === CROSSES ? `${count} of ${transitions.length} cross` : `${count} ${words[code]}`);
  return texts.filter((_, code) => counts[code]).join(", ");
}

/** Show critical values as a table, and offer it as CSV. @param {string} id @param {string}
 * head @param {number[]} places @param {string} title @param {string} unit @param {Summary[]} rows */
function showSide(id, head, places, title, unit, rows) {
  const isBand = surfaces().length > 1;
  const heads = isBand ? [`median [${unit}]`, "10 %", "90 %"] : [`${title} [${unit}]`];
  const cells = rows.map((row, k) => {
    const values = isBand ? [row.middle, row.low, row.high] : [row.middle];
    return [shown(places[k], 6), ...values.map((value) => shown(value)), outcomeText(row, unit)];
  });
  element(id).replaceChildren(table([head, ...heads, "outcome"], cells, 1));
  offerCsv(id, content.name);
}

/** Show both tables. */
function showTables() {
  const { velocity, load } = boundaries();
  showSide("velocities", "load [N]", content.loads, "critical velocity", "m/s", velocity);
  showSide("loads", "velocity [m/s]", content.velocities, "critical load", "N", load);
}

/** Offer a table, as shown, as CSV. @param {string} id @param {string} name */
function offerCsv(id, name) {
  const lines = [...element(id).querySelectorAll("tr")].map((row) =>
    [...row.cells].map(({ textContent }) => JSON.stringify(textContent)).join(","));
  const href = `data:text/csv;charset=utf-8,${encodeURIComponent(lines.join("\r\n"))}`;
  Object.assign(element(`${id}-csv`), { href, download: `${name || "sweep"}_critical_${id}.csv` });
}
