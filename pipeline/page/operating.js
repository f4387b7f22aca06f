/* The operating point: its form, and its margin. */

/** True if a place is inside a sweep. @param {Place} place @param {Axes} axes */
function isInside({ load, velocity }, { loads, velocities }) {
  return load > 0 && velocity > 0 && load >= loads[0] && load <= loads[loads.length - 1] &&
    velocity >= velocities[0] && velocity <= velocities[velocities.length - 1];
}

/** Number in a field, which is marked if it is none. @param {string} id */
function typedIn(id) {
  const value = typed(input(id).value);
  input(id).setAttribute("aria-invalid", `${input(id).value.trim() !== "" && Number.isNaN(value)}`);
  return value;
}

/** Take the operating point in the fields. */
function choosePlace() {
  Object.assign(chosen, { load: typedIn("at-load"), velocity: typedIn("at-velocity") });
  update();
}

/** Show the operating point's margin, or why it has none. */
function showMargin() {
  const rows = marginRows();
  const isHint = typeof rows === "string";
  element("operating").classList.toggle("is-used", !isHint);
  element("margin").replaceChildren(isHint ? html("p", { class: "hint" }, rows) : table([], rows));
}

/** Rows with verdict and distances at the nearest node, or a hint. @returns {[string, string][] | string} */
function marginRows() {
  const { conditions } = chosen;
  if (!isInside(chosen, content)) return content.outside;
  const [k, j] = nearestNode(chosen);
  const node = indexOf(k, j);
  const deciding = decidingTemperature(node);
  if (Number.isNaN(deciding)) return "Too few points about this place are done.";
  const [f, v] = [content.fine.load[k], content.fine.velocity[j]];
  /** @type {[string, string][]} */
  const rows = [
    ["nearest node", `${shown(f)} N, ${shown(v)} m/s, ${content.origins[Number(content.state[node])]}`],
    ["deciding temperature", `${shown(deciding - ZERO_CELSIUS)} °C`],
  ];
  const critical = conditions.critical_temperature;
  if (critical === null) return rows;
  const { error, probabilities, verdict } = marginAt([k, j], conditions);
  const [lowest, likely, highest] = probabilities.map(percent);
  const [isLow, isHigh] = [lowest, highest].map((end) => end.includes("than"));
  const ends = isLow ? `at most ${highest}` : isHigh ? `at least ${lowest}` : `${lowest} to ${highest}`;
  const within = lowest === highest ? "" : isLow && isHigh ? " (0 to 100 %)" : ` (${ends})`;
  const rise = deciding - heatOf(conditions).coldest;
  const [kelvin, surface] = [error, content.surface_errors[node]].map((part) => rise * Math.expm1(part));
  if (verdict === OUTSIDE) return [["wear", verdict], ...rows];
  return [
    ["wear", verdict], ["severe wear is likely by", `${likely}${within}`], ...rows,
    ["its error", Number.isNaN(kelvin) ? "not known"
      : `± ${shown(kelvin, 2)} K, surface ${shown(surface, 2)} K`],
    ["distance to critical", `${shown(critical - deciding, 3)} K`],
    ["wear turns at this load", wayText("velocity", f, v, "m/s")],
    ["wear turns at this velocity", wayText("load", v, f, "N")],
  ];
}

/** First transition along an axis in words, with its ratio to the value `now`. @param {AxisName} axis
 * @param {number} at on the other axis @param {number} now @param {string} unit */
function wayText(axis, at, now, unit) {
  const { place, outcome } = turnAt(axis, at, chosen.conditions);
  if (!Number.isFinite(place)) return content.outcomes[axis][outcome];
  const more = outcome === content.several ? `; ${content.outcomes[axis][outcome]}` : "";
  return `${shown(place)} ${unit}, ${shown(place / now, 3)} times${more}`;
}

/** A probability in words: a percentage, or "less than 1 %". @param {number} value */
function percent(value) {
  if (value < 0.01) return "less than 1 %";
  if (value > 0.99) return "more than 99 %";
  return `${shown(100 * value, 2)} %`;
}
