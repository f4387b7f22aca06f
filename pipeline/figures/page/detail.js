// @ts-check
"use strict";
/* One point in detail: its numbers, its temperature over the contact, its fields. */

/** Levels of the fields that were unpacked, by place. @type {Map<number, Uint8Array>} */
const opened = new Map();

function showPoint() {
  if (!chosen.point) return;
  const { i, j } = chosen.point;
  element("point").replaceChildren(html("h3", {}, nameOf(i, j)), pairs(description(i, j, true)));
  showDistribution(verdicts(i, j).map(({ temperatures }) => temperatures));
  showFields(i, j);
}

/**
 * Show the share of the contact that is hotter than each temperature.
 * @param {number[][]} rows temperatures by surface
 */
function showDistribution(rows) {
  const room = element("distribution");
  const critical = chosen.conditions.critical_temperature;
  const share = 100 * chosen.conditions.failing_share;
  const text =
    critical === null || !hasShare()
      ? "Distribution of the temperature over the contact."
      : "Distribution of the temperature over the contact. Wear is severe where the curve passes above " +
        `the crossing of the dashed lines: more than ${shown(share)} % hotter than ${celsius(critical, 6)}.`;
  element("distribution-caption").textContent = rows.length ? text : "";
  room.replaceChildren();
  if (!rows.length) return;
  const curves = rows.map((row) => row.map((kelvin) => kelvin - ZERO_CELSIUS));
  const limits = critical === null ? [] : [critical - ZERO_CELSIUS];
  const width = Math.max(room.clientWidth, 260);
  const { root, inside, frame } = axes(
    width,
    Math.round(Math.min(0.6 * width, 300)),
    { ...ends([...curves.flat(), ...limits]), label: "temperature [°C]" },
    { low: 0, high: 100, label: "contact that is hotter [%]" },
  );
  const shares = content.quantiles.map((quantile) => frame.y(100 * (1 - quantile)));
  const look = curves.length > 1 ? "faint" : "curve";
  const guides = limits.map((limit) => `M${frame.x(limit)},${frame.top}V${frame.bottom}`);
  if (hasShare()) guides.push(`M${frame.left},${frame.y(share)}H${frame.right}`);
  inside.append(
    ...curves.map((curve) => svg("path", { class: look, d: path(curve.map(frame.x), shares) })),
    svg("path", { class: "guide", d: guides.join("") }),
  );
  root.setAttribute("role", "img");
  root.setAttribute("aria-label", text);
  room.append(root);
}

/** Unpack the fields of a point, and show them. @param {number} i @param {number} j */
function showFields(i, j) {
  const isOwn = sweep.rateRatio === 1;
  const places = surfaces().map((surface) => sweep.place(surface, i, j));
  const place = places.find((number) => isOwn && String(number) in content.fields.points);
  if (place === undefined) {
    element("fields").replaceChildren();
    element("fields-note").textContent = content.fields.stored
      ? `The page does not hold the fields of this point${isOwn ? "" : " at this wear rate"}.`
      : "The sweep holds no fields; store them with fields = true under [sweep] in the scene.";
    return;
  }
  const levels = opened.get(place);
  if (levels) return drawFields(place, levels);
  unpacked(content.fields.points[place][6]).then((unpackedLevels) => {
    opened.set(place, unpackedLevels);
    if (chosen.point) showFields(chosen.point.i, chosen.point.j); // it may be another one meanwhile
  });
}

/** Levels of fields from compressed base64. @param {string} packed */
async function unpacked(packed) {
  const stream = new Blob([bytes(packed)]).stream().pipeThrough(new DecompressionStream("deflate"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

/** @param {number} place @param {Uint8Array} levels of each field in turn */
function drawFields(place, levels) {
  const [pressure, low, high, wear, lowResponse, highResponse] = content.fields.points[place];
  const { shape = [1, 1], block = [1, 1], extent: sides = [NaN, NaN] } = content.fields;
  const n = shape[0] * shape[1];
  const { critical_temperature, friction, bulk_temperature } = chosen.conditions;
  const limit = critical_temperature ?? Infinity;
  const difference = bulkDifference(chosen.conditions);
  const part = (/** @type {number} */ level) => level / 255;
  const between = (/** @type {number} */ level, /** @type {number} */ from, /** @type {number} */ to) =>
    from + ((level - 1) / 254) * (to - from);
  const kelvin = Array.from(levels.subarray(n, 2 * n), (level, k) => {
    if (level === 0) return NaN;
    const response = difference ? difference * between(levels[3 * n + k], lowResponse, highResponse) : 0;
    return bulk_temperature + friction * between(level, low, high) + response;
  });
  const touching = kelvin.filter(Number.isFinite);
  const [coldest, hottest] = [Math.min(...touching), Math.max(...touching)];
  const range = hottest - coldest || 1;
  const over = hottest > limit ? `; blue above ${celsius(limit, 6)}` : "";
  element("fields").replaceChildren(
    field("contact pressure [GPa]", [0, 1e-9 * pressure], COLOURS.pressure,
      Array.from(levels.subarray(0, n), (level) => (level ? part(level) : NaN))),
    field(`contact temperature [°C]${over}`, [coldest - ZERO_CELSIUS, hottest - ZERO_CELSIUS],
      COLOURS.temperature, kelvin.map((value) => (value - coldest) / range), (limit - coldest) / range),
    field("wear depth of the pin [µm]", [0, 1e6 * wear], COLOURS.wear,
      Array.from(levels.subarray(2 * n, 3 * n), part)),
  );
  const averaged = Math.max(...block) > 1 ? `, averaged over ${block[0]} × ${block[1]} elements` : "";
  const number = content.surfaces?.[Math.floor(place / sweep.place(1, 0, 0))];
  const surface = number === undefined ? "" : ` on surface ${number}`;
  const [x, y] = sides;
  const size = y === null ? `${shown(1e6 * x)} µm along sliding` : `${shown(1e6 * x)} × ${shown(1e6 * y)} µm`;
  element("fields-note").textContent =
    `At the end of the point${surface}: ${size}; sliding to the right${averaged}. ` +
    "The temperature is that of the parts in contact.";
}

/**
 * A field as a picture with its scale: by parts of the scale, white where there is none, and blue
 * above a limit.
 * @param {string} label @param {[number, number]} scale @param {string[]} colours
 * @param {number[]} parts @param {number} limit
 */
function field(label, scale, colours, parts, limit = Infinity) {
  const [low, high] = scale.map((end) => shown(end));
  const { shape = [1, 1], extent: sides = [1, 1] } = content.fields;
  const paint = (/** @type {number} */ part) => (part > limit ? [42, 168, 255] : colour(colours, part));
  const picture = canvas(shape[0], shape[1], (x, y) => parts[x * shape[1] + shape[1] - 1 - y], paint);
  const [along, across] = [sides[0] ?? 1, sides[1] ?? (sides[0] ?? 1) / 8];
  picture.style.aspectRatio = String(Math.min(Math.max(along / across, 0.4), 8));
  picture.setAttribute("role", "img");
  picture.setAttribute("aria-label", `${label}, from ${low} to ${high}`);
  const bar = canvas(255, 1, (x) => (x + 1) / 255, paint);
  bar.className = "scale";
  bar.setAttribute("aria-hidden", "true");
  const ends = html("div", { class: "ends" }, html("span", {}, low), html("span", {}, high));
  return html("figure", {}, html("figcaption", {}, label), picture, bar, ends);
}

/**
 * A canvas painted element by element; white where there is no part.
 * @param {number} width @param {number} height @param {(x: number, y: number) => number} partAt
 * @param {(part: number) => number[]} paint
 */
function canvas(width, height, partAt, paint) {
  const surface = /** @type {HTMLCanvasElement} */ (html("canvas"));
  surface.width = width;
  surface.height = height;
  const image = new ImageData(width, height);
  for (let y = 0; y < height; y++) {
    for (let x = 0; x < width; x++) {
      const part = partAt(x, y);
      image.data.set([...(Number.isNaN(part) ? [255, 255, 255] : paint(part)), 255], 4 * (y * width + x));
    }
  }
  surface.getContext("2d")?.putImageData(image, 0, 0);
  return surface;
}
