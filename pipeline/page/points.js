/* Points of the diagram by pointer and keyboard: their values, and the selected point. */

const tip = html("div", { class: "tip", role: "status", id: "tip", hidden: "" });
const REACH = 14; // [px] around a point within which the pointer is on it
const WEAR = new Map([
  ["unjudged", "not known without a critical temperature"], ["pending", "not computed"],
]);
/** Point under the pointer or the keyboard cursor. @type {Point | null} */
let pointed = null;

/** Listen to pointer and keyboard on the diagram. @param {SVGElement} root */
function listenToPoints(root) {
  root.addEventListener("pointermove", (event) => pointTo(pointAt(event)));
  root.addEventListener("pointerleave", () => pointTo(null));
  root.addEventListener("blur", () => pointTo(null));
  root.addEventListener("focus", () => pointTo(pointed ?? chosenPoint() ?? middle()));
  root.addEventListener("click", (event) => choosePoint(pointAt(event)));
  root.addEventListener("keydown", pressed);
}

/** Place of a point on the screen [px]. @param {Point} point @returns {[number, number]} */
function onScreen({ i, j }) {
  return [diagram.frame.x(content.velocities[j]), diagram.frame.y(content.loads[i])];
}

/** Point under the pointer; null if there is none, or it was not asked for. @param {MouseEvent} event */
function pointAt(event) {
  const { left, top } = diagram.root.getBoundingClientRect();
  const [across, down] = [event.clientX - left, event.clientY - top];
  const i = nearest(content.loads.map(diagram.frame.y), down);
  const j = nearest(content.velocities.map(diagram.frame.x), across);
  const [x, y] = onScreen({ i, j });
  return Math.hypot(x - across, y - down) < REACH && kindOf({ i, j }) ? { i, j } : null;
}

/** Point at which the keyboard begins. */
function middle() {
  return { i: content.loads.length >> 1, j: content.velocities.length >> 1 };
}

/** Move with the arrow keys; select a point with Enter or Space. @param {KeyboardEvent} event */
function pressed(event) {
  /** @type {Object<string, [number, number]>} */
  const ways = { ArrowUp: [1, 0], ArrowDown: [-1, 0], ArrowLeft: [0, -1], ArrowRight: [0, 1] };
  const here = pointed ?? middle();
  if (event.key === "Enter" || event.key === " ") choosePoint(here);
  else if (event.key === "Escape") pointTo(null);
  else if (ways[event.key]) pointTo(next(here, ways[event.key]));
  else return;
  event.preventDefault();
}

/** Next point in a direction, without those not asked for; the same point at the end. @param {Point} here
 * @param {[number, number]} way @returns {Point} */
function next(here, [up, right]) {
  const isThere = (/** @type {Point} */ { i, j }) => i in content.loads && j in content.velocities;
  let point = { i: here.i + up, j: here.j + right };
  while (isThere(point) && !kindOf(point)) point = { i: point.i + up, j: point.j + right };
  return isThere(point) ? point : here;
}

/** Show the values of a point next to it; hide them if null. @param {Point | null} point */
function pointTo(point) {
  pointed = point;
  tip.hidden = !point;
  const [cx, cy] = point ? onScreen(point) : [0, 0];
  filled(diagram.pointer, { cx, cy, display: point && kindOf(point) ? "inline" : "none" }, []);
  if (!point) return;
  const texts = description(point, false).map(([name, text]) => `${name}: ${text}`);
  placeTip(diagram.frame, onScreen(point), nameOf(point), texts);
}

/** Show texts next to a place [px]. @param {Frame} frame @param {[number, number]} place @param {string}
 * title @param {string[]} texts */
function placeTip(frame, [x, y], title, texts) {
  tip.replaceChildren(html("b", {}, title), ...texts.map((text) => html("div", {}, text)));
  tip.style.left = `${Math.max(Math.min(x + 14, frame.right - tip.offsetWidth), 0)}px`;
  const isUnder = y + 14 + tip.offsetHeight < frame.bottom;
  tip.style.top = `${isUnder ? y + 14 : Math.max(y - 14 - tip.offsetHeight, 0)}px`;
}

/** Take a point as the operating point. @param {Point | null} point */
function choosePoint(point) {
  if (!point || !kindOf(point)) return;
  input("at-load").value = String(content.loads[point.i]);
  input("at-velocity").value = String(content.velocities[point.j]);
  choosePlace();
}

/** Point at the operating point; null if there is none. @returns {Point | null} */
function chosenPoint() {
  const [i, j] = [content.loads.indexOf(chosen.load), content.velocities.indexOf(chosen.velocity)];
  return i >= 0 && j >= 0 && kindOf({ i, j }) ? { i, j } : null;
}

/** Index of a point in the lists of points, of the first surface. @param {Point} point */
function placeOf({ i, j }) {
  return i * content.velocities.length + j;
}

/** Node of a point. @param {Point} point */
function nodeOf({ i, j }) {
  return indexOf(content.nodes.load[i], content.nodes.velocity[j]);
}

/** True if a point is done. @param {Point} point */
function isDone(point) {
  return content.state[nodeOf(point)] === COMPUTED;
}

/** Kind of a point, which is its mark in the diagram. @param {Point} point */
function kindOf(point) {
  if (isDone(point)) {
    if (!isJudged()) return "unjudged";
    return planeOf(chosen.conditions)[nodeOf(point)] > 0 ? "severe" : "mild";
  }
  const place = placeOf(point);
  if (content.status[place] === POINT_FAILED) return "failed";
  return content.asked[place] === "1" ? "pending" : "";
}

/** Quantiles of the contact temperature at a point [°C]. @param {number} place */
function quantilesAt(place) {
  const { quantiles: { length }, bulk_ratios, rises } = content;
  return content.quantiles.map((_, q) => temperature(sum(tablesOf(chosen.conditions).map(([ratio, weight]) =>
    weight * rises[(place * bulk_ratios.length + ratio) * length + q]))) - ZERO_CELSIUS);
}

/** Description of a point: pairs of a name and a text. @param {Point} point @param {boolean} isFull
 * @returns {[string, string][]} */
function description(point, isFull) {
  const place = placeOf(point);
  const { critical_temperature } = chosen.conditions;
  const kind = kindOf(point) || "pending";
  /** @type {[string, string][]} */
  const rows = [["wear", isFilm(nodeOf(point)) ? OUTSIDE : WEAR.get(kind) ?? kind]];
  const message = content.messages[place];
  if (isDone(point)) {
    const curve = quantilesAt(place);
    rows.push([content.deciding, `${shown(decidingTemperature(nodeOf(point)) - ZERO_CELSIUS)} °C`]);
    rows.push(["highest temperature", `${shown(Math.max(...curve))} °C`]);
    if (critical_temperature !== null) {
      const above = 100 * (1 - linear(curve, content.quantiles, critical_temperature - ZERO_CELSIUS));
      rows.push(["contact above critical", `${shown(above, 3)} %`]);
    }
    for (const { label, unit, values } of content.numbers.slice(0, isFull ? undefined : 1)) {
      if (Number.isFinite(values[place])) rows.push([label, `${shown(values[place])} ${unit}`]);
    }
    if (isFull) rows.push(["at its worst after", `${shown(content.times[place])} s`]);
  }
  if (message) rows.push([isDone(point) ? "warning" : "message", message]);
  return rows;
}

/** Load and velocity of a point in words. @param {Point} point */
function nameOf({ i, j }) {
  return `${shown(content.loads[i], 6)} N, ${shown(content.velocities[j], 6)} m/s`;
}

/** Show the numbers, temperatures and fields of a computed point at the operating point. */
function showPoint() {
  const point = chosenPoint();
  element("point-section").hidden = !point;
  if (!point) return;
  element("point").replaceChildren(html("h3", {}, nameOf(point)), table([], description(point, true)));
  element("temperatures").hidden = !isDone(point);
  if (isDone(point)) showDistribution(quantilesAt(placeOf(point)));
  showFields(content.fields.points[placeOf(point)]);
}

/** Show the share of the contact above each temperature. @param {number[]} curve [°C] */
function showDistribution(curve) {
  const { critical_temperature: critical, failing_share, criterion } = chosen.conditions;
  const [share, limits] = [100 * failing_share, critical === null ? [] : [critical - ZERO_CELSIUS]];
  const hasShare = criterion === "share";
  const rule = !limits.length || !hasShare ? "" : " Wear is severe where the curve passes above the " +
    `crossing of the dashed lines: more than ${shown(share)} % hotter than ${shown(limits[0], 6)} °C.`;
  const text = `Distribution of the temperature over the contact.${rule}`;
  const x = { ...ends([...curve, ...limits], false), label: "temperature [°C]" };
  const y = { low: 0, high: 100, label: "contact that is hotter [%]" };
  const width = Math.max(element("distribution").clientWidth, 260);
  const { root, inside, frame } = axes(width, Math.round(Math.min(0.6 * width, 300)), x, y);
  const corners = curve.map((one, q) => `${frame.x(one)},${frame.y(100 * (1 - content.quantiles[q]))}`);
  const guides = limits.map((limit) => `M${frame.x(limit)},${frame.top}V${frame.bottom}`);
  if (hasShare) guides.push(`M${frame.left},${frame.y(share)}H${frame.right}`);
  inside.append(svg("path", { class: "curve", d: `M${corners.join("L")}` }),
    svg("path", { class: "guide", d: guides.join("") }));
  element("distribution").replaceChildren(filled(root, { role: "img", "aria-label": text }, []));
  element("distribution-caption").textContent = text;
}

/** Show the pictures of a point's fields, drawn by Python. @param {Packed | undefined} packed */
function showFields(packed) {
  const isThere = packed && isOwnBulk();
  element("fields-note").textContent = isThere ? content.fields.note : "";
  element("fields").replaceChildren();
  if (!isThere) return;
  const [pressure, low, high, wear, ...pictures] = packed;
  const [coldest, hottest] = [low, high].map((rise) => temperature(rise) - ZERO_CELSIUS);
  element("fields").append(
    field("contact pressure [GPa]", [0, 1e-9 * pressure], pictures, 0),
    field("contact temperature [°C]", [coldest, hottest], pictures, 1),
    field("wear depth of the pin [µm]", [0, 1e6 * wear], pictures, 2),
  );
}

/** HTML figure of a field with its colour scale. @param {string} label @param {[number, number]} range @param
 * {string[]} pictures @param {number} k */
function field(label, range, pictures, k) {
  const [low, high] = range.map((end) => shown(end));
  const { aspect, scales } = content.fields;
  const drawn = (/** @type {string} */ held) => ({ src: `data:image/png;base64,${held}` });
  const picture = html("img", { ...drawn(pictures[k]), alt: `${label}, from ${low} to ${high}` });
  picture.style.aspectRatio = String(aspect);
  const bar = html("img", { ...drawn(scales[k]), class: "scale", alt: "" });
  const words = html("div", { class: "ends" }, html("span", {}, low), html("span", {}, high));
  return html("figure", {}, html("figcaption", {}, label), picture, bar, words);
}
