"use strict";
/* The points of the diagram, by pointer and by keyboard: their numbers, and the one that is kept. */

const tip = html("div", { class: "tip", role: "status", id: "tip", hidden: "" });
const REACH = 14; // [px] about a point
/** Point at which pointer or keyboard are. @type {{i: number, j: number} | null} */
let pointed = null;

/** Take pointer and keyboard on the diagram. @param {SVGElement} root */
function listenToPoints(root) {
  root.addEventListener("pointermove", (event) => pointTo(pointAt(event)));
  root.addEventListener("pointerleave", () => pointTo(null));
  root.addEventListener("blur", () => pointTo(null));
  root.addEventListener("focus", () => pointTo(pointed ?? chosen.point ?? middle()));
  root.addEventListener("click", (event) => {
    const point = pointAt(event);
    if (point) choosePoint(point.i, point.j);
  });
  root.addEventListener("keydown", pressed);
}

/** Point of the sweep under a pointer. @param {MouseEvent} event */
function pointAt(event) {
  const { frame, root } = diagram;
  const { left, top } = root.getBoundingClientRect();
  const [x, y] = [event.clientX - left, event.clientY - top];
  const near = everyPoint()
    .map(({ i, j }) => [i, j, frame.x(content.velocities[j]) - x, frame.y(content.loads[i]) - y])
    .map(([i, j, across, down]) => ({ i, j, away: Math.hypot(across, down) }))
    .reduce((one, other) => (other.away < one.away ? other : one));
  return near.away < REACH && isShown(near.i, near.j) ? near : null;
}

/** A point has anything to tell, and lies within the frame. @param {number} i @param {number} j */
function isShown(i, j) {
  const { left, right, x } = diagram.frame;
  const across = x(content.velocities[j]);
  return kindOf(i, j) !== "" && across >= left && across <= right;
}

/** Point with which to begin. */
function middle() {
  return { i: content.loads.length >> 1, j: content.velocities.length >> 1 };
}

/** Move with the arrow keys, keep a point with Enter or Space. @param {KeyboardEvent} event */
function pressed(event) {
  /** @type {Object<string, [number, number]>} */
  const ways = { ArrowUp: [1, 0], ArrowDown: [-1, 0], ArrowLeft: [0, -1], ArrowRight: [0, 1] };
  const { i, j } = pointed ?? middle();
  if (event.key === "Enter" || event.key === " ") choosePoint(i, j);
  else if (event.key === "Escape") pointTo(null);
  else if (ways[event.key]) pointTo(next(i, j, ways[event.key]));
  else return;
  event.preventDefault();
}

/** Next point in a direction that has anything to tell; the same one if there is none. @param {number} i
 * @param {number} j @param {[number, number]} way */
function next(i, j, [up, right]) {
  const isInside = () => k >= 0 && k < content.loads.length && l >= 0 && l < content.velocities.length;
  let [k, l] = [i + up, j + right];
  while (isInside() && !isShown(k, l)) [k, l] = [k + up, l + right];
  return isInside() ? { i: k, j: l } : { i, j };
}

/** Show the numbers of a point beside it, or of none. @param {{i: number, j: number} | null} point */
function pointTo(point) {
  pointed = point;
  tip.hidden = !point;
  ring(diagram.pointer, point);
  if (!point) return;
  const { i, j } = point;
  const rows = description(i, j, false).map(([name, text]) => html("div", {}, `${name}: ${text}`));
  tip.replaceChildren(html("b", {}, nameOf(i, j)), ...rows);
  placeTip(diagram.frame, content.loads[i], content.velocities[j]);
}

/** Put the tip beside a place. @param {Frame} frame @param {number} load @param {number} velocity */
function placeTip(frame, load, velocity) {
  const [x, y] = [frame.x(velocity), frame.y(load)];
  tip.style.left = `${Math.max(Math.min(x + 14, frame.right - tip.offsetWidth), 0)}px`;
  const isUnder = y + 14 + tip.offsetHeight < frame.bottom;
  tip.style.top = `${isUnder ? y + 14 : Math.max(y - 14 - tip.offsetHeight, 0)}px`;
}

/** Put a ring about a point. @param {SVGElement} circle @param {{i: number, j: number} | null} point */
function ring(circle, point) {
  const isThere = point !== null && isShown(point.i, point.j);
  circle.setAttribute("display", isThere ? "inline" : "none");
  if (!isThere) return;
  circle.setAttribute("cx", String(diagram.frame.x(content.velocities[point.j])));
  circle.setAttribute("cy", String(diagram.frame.y(content.loads[point.i])));
}

/** @param {number} i @param {number} j */
function choosePoint(i, j) {
  if (!kindOf(i, j)) return;
  chosen.point = { i, j };
  ring(diagram.choice, chosen.point);
  showPoint();
}


/** Quantiles of the rise at a point [K]. @param {number} place */
function quantilesAt(place) {
  const { quantiles } = content;
  return quantiles.map((_, q) => weighed(tables.rises, place, chosen.conditions, quantiles.length, [[q, 1]]));
}

/** Deciding rise of a point that is done [K]. @param {number} surface @param {number} i @param {number} j */
function riseAt(surface, i, j) {
  const isDone = content.status[placeOf(surface, i, j)] === POINT_DONE;
  return isDone ? planeOf(chosen.conditions)[indexOf(surface, i * content.parts.load, nodeOf(j))] : NaN;
}

/** Verdicts on the surfaces on which a point is done. @param {number} i @param {number} j */
function verdicts(i, j) {
  const limit = riseLimit(chosen.conditions);
  return surfaces().flatMap((surface) => {
    const place = placeOf(surface, i, j);
    const rise = riseAt(surface, i, j);
    if (Number.isNaN(rise)) return [];
    const row = quantilesAt(place);
    return /** @type {Verdict[]} */ ([{
      place,
      temperatures: row.map(temperature),
      decisive: temperature(rise),
      failed: isJudged() ? 1 - linear(row, content.quantiles, limit) : NaN,
      isSevere: rise > limit,
    }]);
  });
}

/** Kind of a point, as the diagram marks it. @param {number} i @param {number} j */
function kindOf(i, j) {
  const rises = surfaces().map((surface) => riseAt(surface, i, j));
  const places = surfaces().map((surface) => placeOf(surface, i, j));
  const done = rises.filter((rise) => !Number.isNaN(rise));
  if (done.length) {
    if (!isJudged()) return "unjudged";
    const severe = done.filter((rise) => rise > riseLimit(chosen.conditions)).length;
    return severe === 0 ? "mild" : severe < done.length ? "mixed" : "severe";
  }
  if (places.some((place) => content.status[place] === POINT_FAILED)) return "failed";
  return places.some((place) => content.asked[place] === "1") ? "pending" : "";
}

/** Messages of a point on the surfaces that count, each once. @param {number} i @param {number} j */
function messagesOf(i, j) {
  const texts = surfaces().map((surface) => content.messages[placeOf(surface, i, j)]);
  return [...new Set(texts.filter(Boolean))];
}

/** @param {number} i @param {number} j */
function hasWarning(i, j) {
  return !["failed", "pending", ""].includes(kindOf(i, j)) && messagesOf(i, j).length > 0;
}

/** Description of a point, as pairs of a name and a text. @param {number} i @param {number} j @param
 * {boolean} isFull @returns {[string, string][]} */
function description(i, j, isFull) {
  const all = verdicts(i, j);
  const { failing_share } = chosen.conditions;
  /** @type {[string, string][]} */
  const rows = [["wear", wearOf(all, kindOf(i, j))]];
  if (all.length) {
    if (!hasShare || failing_share > 0) {
      const share = `exceeded on ${shown(100 * failing_share)} % of the contact`;
      const decisive = banded(all.map((verdict) => verdict.decisive - ZERO_CELSIUS), "°C");
      rows.push([hasShare ? share : content.deciding, decisive]);
    }
    const highest = all.map(({ temperatures }) => Math.max(...temperatures) - ZERO_CELSIUS);
    rows.push(["highest temperature", banded(highest, "°C")]);
    if (isJudged()) {
      rows.push(["contact above critical", banded(all.map(({ failed }) => 100 * failed), "%", 3)]);
    }
    const numbers = isFull ? content.numbers : content.numbers.slice(0, 1);
    numbers.forEach(({ label, unit }, k) => {
      const values = all.map(({ place }) => tables.numbers[k][place]);
      if (values.some(Number.isFinite)) rows.push([label, banded(values, unit)]);
    });
    if (isFull) rows.push(["at its worst after", banded(all.map(({ place }) => tables.times[place]), "s")]);
  }
  for (const message of messagesOf(i, j)) rows.push([all.length ? "warning" : "message", message]);
  return rows;
}

/** Kind of wear in words. @param {Verdict[]} all @param {string} kind */
function wearOf(all, kind) {
  if (!all.length) return kind === "failed" ? "failed" : "not computed";
  if (!isJudged()) return "not known without a critical temperature";
  const severe = all.filter(({ isSevere }) => isSevere).length;
  return all.length > 1 ? `severe on ${severe} of ${all.length}` : severe ? "severe" : "mild";
}

/** @param {number} i @param {number} j */
function nameOf(i, j) {
  return `${shown(content.loads[i], 6)} N, ${shown(content.velocities[j], 6)} m/s`;
}


function showPoint() {
  if (!chosen.point) return;
  const { i, j } = chosen.point;
  element("point-section").hidden = false;
  element("point").replaceChildren(html("h3", {}, nameOf(i, j)), pairs(description(i, j, true)));
  showDistribution(verdicts(i, j).map(({ temperatures }) => temperatures));
  showCourse(i, j);
  showFields(i, j);
}

/** Show the share of the contact that is hotter than each temperature. @param {number[][]} rows temperatures
 * by surface */
function showDistribution(rows) {
  const room = element("distribution");
  const critical = chosen.conditions.critical_temperature;
  const share = 100 * chosen.conditions.failing_share;
  const degrees = `${shown((critical ?? NaN) - ZERO_CELSIUS, 6)} °C`;
  const rule = critical === null || !hasShare ? "" : " Wear is severe where the curve passes above the " +
    `crossing of the dashed lines: more than ${shown(share)} % hotter than ${degrees}.`;
  const text = `Distribution of the temperature over the contact.${rule}`;
  element("distribution-caption").textContent = rows.length ? text : "";
  room.replaceChildren();
  if (!rows.length) return;
  const curves = rows.map((row) => row.map((kelvin) => kelvin - ZERO_CELSIUS));
  const limits = critical === null ? [] : [critical - ZERO_CELSIUS];
  const width = Math.max(room.clientWidth, 260);
  const height = Math.round(Math.min(0.6 * width, 300));
  const x = { ...ends([...curves.flat(), ...limits]), label: "temperature [°C]" };
  const y = { low: 0, high: 100, label: "contact that is hotter [%]" };
  const { root, inside, frame } = axes(width, height, x, y);
  const shares = content.quantiles.map((quantile) => frame.y(100 * (1 - quantile)));
  const look = curves.length > 1 ? "faint" : "curve";
  const guides = limits.map((limit) => `M${frame.x(limit)},${frame.top}V${frame.bottom}`);
  if (hasShare) guides.push(`M${frame.left},${frame.y(share)}H${frame.right}`);
  inside.append(
    ...curves.map((curve) => svg("path", { class: look, d: path(curve.map(frame.x), shares) })),
    svg("path", { class: "guide", d: guides.join("") }),
  );
  root.setAttribute("role", "img");
  root.setAttribute("aria-label", text);
  room.append(root);
}

/** Show the fields of a point, as Python has drawn them. @param {number} i @param {number} j */
function showFields(i, j) {
  const places = surfaces().map((surface) => placeOf(surface, i, j));
  const place = places.find((number) => String(number) in content.fields.points);
  const isOwn = bulkRatio(chosen.conditions) === bulkRatio(content.conditions);
  if (place === undefined || !isOwn) {
    element("fields").replaceChildren();
    element("fields-note").textContent = content.fields.stored
      ? `The page does not hold the fields of this point${isOwn ? "" : " under these conditions"}.`
      : "The sweep holds no fields; store them with fields = true under [sweep] in the scene.";
    return;
  }
  const [pressure, low, high, wear, ...pictures] = content.fields.points[place];
  const [coldest, hottest] = [low, high].map((rise) => temperature(rise) - ZERO_CELSIUS);
  element("fields").replaceChildren(
    field("contact pressure [GPa]", [0, 1e-9 * pressure], pictures, 0),
    field("contact temperature [°C]", [coldest, hottest], pictures, 1),
    field("wear depth of the pin [µm]", [0, 1e6 * wear], pictures, 2),
  );
  const number = content.surfaces?.[Math.floor(place / placeOf(1, 0, 0))];
  const surface = number === undefined ? "" : ` on surface ${number}`;
  element("fields-note").textContent = `At the end of the point${surface}: ${content.fields.note}`;
}

/** A field as a picture with its scale. @param {string} label @param {[number, number]} ends @param
 * {string[]} pictures @param {number} k */
function field(label, ends, pictures, k) {
  const [low, high] = ends.map((end) => shown(end));
  const { aspect, scales } = content.fields;
  const drawn = (/** @type {string} */ held) => ({ src: `data:image/png;base64,${held}` });
  const picture = html("img", { ...drawn(pictures[k]), alt: `${label}, from ${low} to ${high}` });
  picture.style.aspectRatio = String(aspect);
  const bar = html("img", { ...drawn(scales[k]), class: "scale", alt: "" });
  const words = html("div", { class: "ends" }, html("span", {}, low), html("span", {}, high));
  return html("figure", {}, html("figcaption", {}, label), picture, bar, words);
}
