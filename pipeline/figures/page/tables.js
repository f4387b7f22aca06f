// @ts-check
"use strict";
/* Critical velocities and loads: over the surfaces, as tables and as CSV. */

/**
 * @typedef {{id: string, places: number[], rows: Summary[], head: string, title: string,
 *   unit: string}} Side critical velocities by load, or critical loads by velocity
 */

/** The boundary under the present conditions. */
function summary() {
  return sweep.boundary(surfaces(), chosen.conditions);
}

/**
 * Number of loads at which a transition at any of these frictions lies beyond what was computed.
 * @param {number[]} frictions
 */
function loadsBeyond(frictions) {
  const rows = frictions.map(
    (friction) => sweep.boundary(surfaces(), { ...chosen.conditions, friction }).velocity,
  );
  return sweep.loads.filter((_, i) =>
    rows.some((row) => row[i].transitions.some(({ outcome }) => [ABOVE, BELOW].includes(outcome))),
  ).length;
}

/** Crossings that are interpolated across points that are not done. @param {Transition[]} transitions */
function bridged(transitions) {
  return transitions.filter(({ isBridged }) => isBridged).length;
}

/** The same in words. @param {Transition[]} transitions */
function bridgedText(transitions) {
  const count = bridged(transitions);
  if (!count) return "";
  return `, ${transitions.length > 1 ? `${count} of them ` : ""}across points not done`;
}

/** Loads with such a crossing, in words. */
function bridgedLoads() {
  const rows = summary().velocity.filter(({ transitions }) => bridged(transitions));
  return rows.length ? `, across points not done at ${rows.length} of ${sweep.loads.length} loads` : "";
}

/** Both sides of the boundary as they are shown. @returns {Side[]} */
function sides() {
  const { loads, velocities } = sweep;
  const { velocity, load } = summary();
  const byLoad = { places: loads, rows: velocity, head: "load [N]", title: "critical velocity", unit: "m/s" };
  const byVelocity = { places: velocities, rows: load, head: "velocity [m/s]", title: "critical load" };
  return [{ id: "velocities", ...byLoad }, { id: "loads", ...byVelocity, unit: "N" }];
}

/**
 * A table of texts; columns of numbers stand to the right.
 * @param {string[]} heads @param {string[][]} rows @param {number} words number of columns of them
 */
function table(heads, rows, words = 0) {
  const look = (/** @type {number} */ k) => (k < heads.length - words ? "number" : "");
  const cell = (/** @type {string} */ text, /** @type {number} */ k) =>
    k ? html("td", { class: look(k) }, text) : html("th", { scope: "row", class: look(0) }, text);
  const top = heads.map((head, k) => html("th", { scope: "col", class: look(k) }, head));
  return html(
    "table",
    {},
    html("thead", {}, html("tr", {}, ...top)),
    html("tbody", {}, ...rows.map((row) => html("tr", {}, ...row.map(cell)))),
  );
}

/**
 * Outcome in words, with how far was computed, as pipeline.analysis.transition has it.
 * @param {Transition} transition @param {"velocity" | "load"} along @param {string} unit
 */
function outcomeWords({ outcome, computed }, along, unit) {
  const [from, to] = computed.map((end) => `${shown(end)} ${unit}`);
  const reach = outcome === ABOVE ? ` (to ${to})` : outcome === BELOW ? ` (from ${from})` : "";
  return content.outcomes[along][outcome] + reach;
}

/** Count of crossings, and the reasons of the others. @param {Summary} row @param {string} unit */
function outcomeText({ transitions }, unit) {
  const along = unit === "N" ? "load" : "velocity";
  const words = content.outcomes[along];
  if (transitions.length === 1) {
    return outcomeWords(transitions[0], along, unit) + bridgedText(transitions);
  }
  const counts = words.map((_, code) => transitions.filter(({ outcome }) => outcome === code).length);
  const texts = counts.map((count, code) =>
    code === CROSSES ? `${count} of ${transitions.length} cross` : `${count} ${words[code]}`,
  );
  return texts.filter((_, code) => counts[code]).join(", ") + bridgedText(transitions);
}

/**
 * Film parameter at a load [N] and a velocity [m/s], which Python has tabulated over the bulk.
 * @param {Film} film @param {number} load @param {number} velocity
 */
function filmParameter(film, load, velocity) {
  if (!Number.isFinite(load * velocity)) return NaN;
  const { bulk_temperature, disk_temperature } = chosen.conditions;
  const bulk = (bulk_temperature + (disk_temperature ?? bulk_temperature)) / 2;
  const powers = [Math.log(load / film.load), Math.log(Math.abs(velocity) / film.velocity)];
  const oil = linear(film.temperatures, film.logarithms, bulk);
  return Math.exp(oil + film.powers[0] * powers[0] + film.powers[1] * powers[1]);
}

/** Show one side of the boundary as a table, and offer it as CSV. @param {Side} side */
function showSide(side) {
  const { id, places, rows, head, title, unit } = side;
  const film = content.film;
  const heads =
    surfaces().length > 1
      ? [head, `median [${unit}]`, "10 %", "90 %"]
      : [head, `${title} [${unit}]`];
  const cells = rows.map((row, k) => {
    const { middle, low, high } = row;
    const values = surfaces().length > 1 ? [middle, low, high] : [middle];
    const [load, velocity] = id === "velocities" ? [places[k], middle] : [middle, places[k]];
    const parameter = film ? [shown(filmParameter(film, load, velocity), 2)] : [];
    const numbers = values.map((value) => shown(value));
    return [shown(places[k], 6), ...numbers, ...parameter, outcomeText(row, unit)];
  });
  const last = film ? ["film Λ", "outcome"] : ["outcome"];
  element(id).replaceChildren(table([...heads, ...last], cells, 1));
  const link = /** @type {HTMLAnchorElement} */ (element(`${id}-csv`));
  link.href = `data:text/csv;charset=utf-8,${encodeURIComponent(csv(side))}`;
  link.download = `${content.name || "sweep"}_critical_${id}.csv`;
}

/** Show both tables; the answer in a sentence. */
function showTables() {
  sides().forEach(showSide);
  const { velocity } = summary();
  const missing = sum(surfaces().map((surface) => content.missing[surface]));
  const note = missing ? ` ${missing} points are pending or failed and left out.` : "";
  return crossingText(velocity) + note;
}

/** @param {Summary[]} rows by load */
function crossingText(rows) {
  if (!isJudged()) return "Give a critical temperature to see where wear turns severe.";
  const places = rows
    .map(({ middle }, i) => ({ middle, load: sweep.loads[i] }))
    .filter(({ middle }) => Number.isFinite(middle))
    .map(({ middle, load }) => `${shown(middle)} m/s at ${shown(load, 6)} N`);
  if (!places.length) {
    const outcomes = rows.flatMap(({ transitions }) => transitions.map(({ outcome }) => outcome));
    return outcomes.every((outcome) => outcome < UNKNOWN)
      ? "Wear does not turn severe within the sweep."
      : "The transition lies beyond what was computed.";
  }
  return `Wear turns severe at ${[...new Set([places[0], places[places.length - 1]])].join(", at ")}.`;
}

/** One side of the boundary with its conditions, in full digits. @param {Side} side */
function csv({ places, rows, head, title, unit }) {
  const { friction, bulk_temperature, critical_temperature, failing_share } = chosen.conditions;
  const disk = chosen.conditions.disk_temperature ?? bulk_temperature;
  const temperatures = [bulk_temperature, disk, critical_temperature ?? ""];
  const conditions = [friction, ...temperatures, failing_share, content.conditions.criterion ?? "share"];
  const name = `${title} [${unit}]`;
  const isBand = surfaces().length > 1;
  const heads = isBand
    ? [head, `${name} median`, `${name} 10 %`, `${name} 90 %`, "crossing", "known"]
    : [head, name, "outcome"];
  heads.push("across points not done");
  const lines = rows.map(({ middle, low, high, transitions }, k) => {
    const outcomes = transitions.map(({ outcome }) => outcome);
    const counts = [CROSSES + 1, UNKNOWN].map((end) => outcomes.filter((outcome) => outcome < end).length);
    const values = (isBand ? [middle, low, high] : [middle]).map((value) =>
      Number.isFinite(value) ? value : "",
    );
    const along = unit === "N" ? "load" : "velocity";
    const last = isBand ? counts : [content.outcomes[along][outcomes[0]]];
    return [places[k], ...values, ...last, bridged(transitions), ...conditions];
  });
  const bulks = ["bulk temperature [K]", "bulk temperature of the disk [K]"];
  const others = ["friction", ...bulks, "critical temperature [K]", "failing share", "criterion"];
  return [[...heads, ...others], ...lines].map((line) => `${line.join(",")}\r\n`).join("");
}
