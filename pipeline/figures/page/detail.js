// @ts-check
"use strict";
/* One point in detail: its numbers, its temperature over the contact, its fields. */

/** @type {{place: number, levels: Uint8Array} | null} */
let opened = null;

function showPoint() {
  if (!chosen.point) return;
  const { i, j } = chosen.point;
  element("point").replaceChildren(html("h3", {}, nameOf(i, j)), pairs(told(i, j, true)));
  showDistribution(findings(i, j));
  showFields(i, j);
}

/** Share of the contact that is hotter than each temperature. @param {Finding[]} found */
function showDistribution(found) {
  const room = element("distribution");
  if (!found.length) {
    room.replaceChildren();
    element("distribution-caption").textContent = "";
    return;
  }
  const critical = chosen.conditions.critical_temperature;
  const curves = found.map(({ temperatures }) => temperatures.map((each) => each - ZERO_CELSIUS));
  const all = [...curves.flat(), ...(critical === null ? [] : [critical - ZERO_CELSIUS])];
  const width = Math.max(room.clientWidth, 260);
  const { root, inside, frame } = axes(
    width,
    Math.round(Math.min(0.6 * width, 300)),
    { ...ends(all), label: "temperature [°C]" },
    { low: 0, high: 100, label: "contact that is hotter [%]" },
  );
  const shares = sweep.quantiles.map((quantile) => 100 * (1 - quantile));
  for (const curve of curves) {
    const look = curves.length > 1 ? "faint" : "curve";
    inside.append(svg("path", { class: look, d: path(curve.map(frame.x), shares.map(frame.y)) }));
  }
  if (hasShare()) {
    const y = frame.y(100 * chosen.conditions.failing_share);
    inside.append(svg("line", { class: "guide", x1: frame.left, x2: frame.right, y1: y, y2: y }));
  }
  if (critical !== null) {
    const x = frame.x(critical - ZERO_CELSIUS);
    inside.append(svg("line", { class: "guide", x1: x, x2: x, y1: frame.top, y2: frame.bottom }));
  }
  root.setAttribute("role", "img");
  const share = shown(100 * chosen.conditions.failing_share);
  const text =
    critical === null || !hasShare()
      ? "How the temperature is distributed over the contact."
      : "How the temperature is distributed over the contact. Wear is severe where the curve passes " +
        `above the crossing of the dashed lines: more than ${share} % hotter than ${celsius(critical, 6)}.`;
  root.setAttribute("aria-label", text);
  room.replaceChildren(root);
  element("distribution-caption").textContent = text;
}

/** Unpack the fields of a point, and show them. @param {number} i @param {number} j */
function showFields(i, j) {
  const places = surfaces().map((surface) => sweep.place(surface, i, j));
  const isOwn = sweep.wearRate === content.conditions.wear_rate || !content.wear_rates.length;
  const place = places.find((each) => isOwn && String(each) in content.fields.points);
  if (place === undefined) {
    element("fields").replaceChildren();
    element("fields-note").textContent = content.fields.stored
      ? `The page does not hold the fields of this point${isOwn ? "" : " at this wear rate"}.`
      : "The sweep holds no fields; store them with fields = true under [sweep] in the scene.";
    return;
  }
  if (opened?.place === place) return drawFields(place, opened.levels);
  const packed = new Uint8Array(bytes(content.fields.points[place][6]));
  unpacked(packed).then((levels) => {
    const now = chosen.point; // which may have been changed meanwhile
    if (!now || now.i !== i || now.j !== j) return;
    opened = { place, levels };
    drawFields(place, levels);
  });
}

/** @param {Uint8Array<ArrayBuffer>} packed */
async function unpacked(packed) {
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("deflate"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

/** @param {number} place @param {Uint8Array} levels */
function drawFields(place, levels) {
  const [pressure, low, high, wear, lowResponse, highResponse] = content.fields.points[place];
  const { shape = [1, 1], block = [1, 1] } = content.fields;
  const n = shape[0] * shape[1];
  const { critical_temperature, friction, bulk_temperature } = chosen.conditions;
  const limit = critical_temperature === null ? Infinity : critical_temperature;
  const difference = bulkDifference(chosen.conditions);
  const warmth = Float64Array.from(levels.subarray(n, 2 * n), (level, k) => {
    if (level === 0) return NaN;
    const rise = low + ((level - 1) / 254) * (high - low);
    const response = lowResponse + ((levels[3 * n + k] - 1) / 254) * (highResponse - lowResponse);
    return bulk_temperature + friction * rise + (difference ? difference * response : 0);
  });
  const known = warmth.filter(Number.isFinite);
  const [coldest, hottest] = [known.reduce(least, Infinity), known.reduce(most, -Infinity)];
  const part = (/** @type {number} */ level) => (level ? colour(COLOURS.pressure, level / 255) : null);
  const hot = (/** @type {number} */ value) => {
    if (Number.isNaN(value)) return null;
    if (value > limit) return HOT;
    return colour(COLOURS.temperature, (value - coldest) / (hottest - coldest || 1));
  };
  const worn = (/** @type {number} */ level) => colour(COLOURS.wear, level / 255);
  const over = hottest > limit ? `; blue above ${celsius(limit, 6)}` : "";
  element("fields").replaceChildren(
    field("contact pressure [GPa]", levels.subarray(0, n), part, [0, 255], [0, 1e-9 * pressure]),
    field(
      `contact temperature [°C]${over}`,
      warmth,
      hot,
      [coldest, hottest],
      [coldest - ZERO_CELSIUS, hottest - ZERO_CELSIUS],
    ),
    field("wear depth of the pin [µm]", levels.subarray(2 * n, 3 * n), worn, [0, 255], [0, 1e6 * wear]),
  );
  const averaged = Math.max(...block) > 1 ? `, averaged over ${block[0]} × ${block[1]} elements` : "";
  const surface = content.surfaces ? ` on ${surfaceName(Math.floor(place / sweep.plane))}` : "";
  element("fields-note").textContent =
    `At the end of the point${surface}: ${extentText()}; sliding to the right${averaged}. ` +
    "The temperature is that of what is in contact.";
}

const least = (/** @type {number} */ a, /** @type {number} */ b) => Math.min(a, b);
const most = (/** @type {number} */ a, /** @type {number} */ b) => Math.max(a, b);
const HOT = [0x2a, 0xa8, 0xff];

function extentText() {
  const [x, y] = content.fields.extent ?? [NaN, NaN];
  return y === null ? `${shown(1e6 * x)} µm along sliding` : `${shown(1e6 * x)} × ${shown(1e6 * y)} µm`;
}

/** A field as a picture with its scale. */
function field(
  /** @type {string} */ label,
  /** @type {ArrayLike<number>} */ values,
  /** @type {(value: number) => number[] | null} */ paint,
  /** @type {[number, number]} */ ends,
  /** @type {[number, number]} */ named,
) {
  const [low, high] = named.map((each) => shown(each));
  const { shape = [1, 1], extent = [1, 1] } = content.fields;
  const picture = canvas(shape[0], shape[1], (x, y) => paint(values[x * shape[1] + shape[1] - 1 - y]));
  const [along, across] = [extent[0] ?? 1, extent[1] ?? (extent[0] ?? 1) / 8];
  picture.style.aspectRatio = String(Math.min(Math.max(along / across, 0.4), 8));
  picture.setAttribute("role", "img");
  picture.setAttribute("aria-label", `${label}, from ${low} to ${high}`);
  const scale = canvas(255, 1, (x) => paint(ends[0] + ((x + 1) / 255) * (ends[1] - ends[0])));
  scale.className = "scale";
  scale.setAttribute("aria-hidden", "true");
  return html(
    "figure",
    {},
    html("figcaption", {}, label),
    picture,
    scale,
    html("div", { class: "ends" }, html("span", {}, low), html("span", {}, high)),
  );
}

/** A canvas painted element by element; white where there is no colour. */
function canvas(
  /** @type {number} */ width,
  /** @type {number} */ height,
  /** @type {(x: number, y: number) => number[] | null} */ paint,
) {
  const found = /** @type {HTMLCanvasElement} */ (html("canvas"));
  found.width = width;
  found.height = height;
  const image = new ImageData(width, height);
  for (let y = 0; y < height; y++) {
    for (let x = 0; x < width; x++) {
      image.data.set([...(paint(x, y) ?? [255, 255, 255]), 255], 4 * (y * width + x));
    }
  }
  found.getContext("2d")?.putImageData(image, 0, 0);
  return found;
}
