"use strict";
/* One point in detail: its numbers, its temperature over the contact, its fields. */

function showPoint() {
  if (!chosen.point) return;
  const { i, j } = chosen.point;
  element("point-section").hidden = false;
  element("point").replaceChildren(html("h3", {}, nameOf(i, j)), pairs(description(i, j, true)));
  showDistribution(verdicts(i, j).map(({ temperatures }) => temperatures));
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
  const places = surfaces().map((surface) => sweep.place(surface, i, j));
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
  const number = content.surfaces?.[Math.floor(place / sweep.place(1, 0, 0))];
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
