/* Drawing: SVG elements, axes and contours, independent of sweeps. */

const SVG = "http://www.w3.org/2000/svg";

/** Give an element attributes and children; strings are text. @template {Element} Kind @param {Kind} made
 * @param {Object<string, string | number>} attributes @param {(Node | string)[]} children @returns {Kind} */
function filled(made, attributes, children) {
  for (const key in attributes) made.setAttribute(key, String(attributes[key]));
  made.append(...children);
  return made;
}

/** SVG element. @param {string} name @param {Attributes} [attributes] @param {(Node | string)[]} children */
function svg(name, attributes = {}, ...children) {
  return filled(/** @type {SVGElement} */ (document.createElementNS(SVG, name)), attributes, children);
}

/** @param {string} name @param {Object<string, string>} [attributes] @param {(Node | string)[]} children */
function html(name, attributes = {}, ...children) {
  return filled(document.createElement(name), attributes, children);
}

/** Element of the page by id. @param {string} id @returns {HTMLElement} */
function element(id) {
  return /** @type {HTMLElement} */ (document.getElementById(id));
}

/** Input element of the page by id. @param {string} id @returns {HTMLInputElement} */
function input(id) {
  return /** @type {HTMLInputElement} */ (element(id));
}

/** About `count` round values between ends. @param {number} low @param {number} high @param {number} count */
function ticks(low, high, count) {
  const rough = (high - low) / Math.max(count, 1);
  const power = 10 ** Math.floor(Math.log10(rough));
  const step = [1, 2, 2.5, 5, 10].map((part) => part * power).find((part) => part >= rough) ?? rough;
  const first = Math.ceil(low / step - 1e-9);
  const length = Math.floor(high / step + 1e-9) - first + 1;
  return Array.from({ length }, (_, k) => Number(((first + k) * step).toPrecision(12)));
}

/** About round values between ends of a logarithmic axis. @param {number} low @param {number} high */
function logTicks(low, high) {
  const powers = Array.from({ length: 30 }, (_, k) => k - 15);
  const found = powers.flatMap((power) => [1, 2, 3, 5, 7].map((part) => Number(`${part}e${power}`)));
  const inside = found.filter((value) => value >= low && value <= high);
  return inside.length > 2 ? inside : ticks(low, high, 4);
}

/** Map of a range of values to the range `from` to `to`. @param {Extent} extent @param {number} from @param
 * {number} to @returns {(value: number) => number} */
function scale({ low, high, isLog }, from, to) {
  const place = (/** @type {number} */ value) => (isLog ? Math.log(value) : value);
  return (value) => from + ((place(value) - place(low)) / (place(high) - place(low))) * (to - from);
}

/** The inverse of `scale`. @param {Extent} extent @param {number} from @param {number} to
 * @returns {(place: number) => number} */
function unscale({ low, high, isLog }, from, to) {
  const part = scale({ low: from, high: to }, 0, 1);
  return (place) => (isLog ? low * (high / low) ** part(place) : low + part(place) * (high - low));
}

/** A number as text with some significant digits. @param {number} value @param {number} [digits] */
function shown(value, digits = 4) {
  if (!Number.isFinite(value)) return "–";
  const size = Math.abs(value);
  if (size !== 0 && (size < 1e-4 || size >= 1e7)) return value.toExponential(Math.max(digits - 1, 0));
  return String(Number(value.toPrecision(digits)));
}

/** SVG with grid, axes and labels; drawings go into `inside`, between grid and axes. @param {number} width
 * @param {number} height @param {Axis} x @param {Axis} y */
function axes(width, height, x, y) {
  const [left, right, top, bottom] = [56, width - 12, 10, height - 42];
  const frame = {
    left, right, top, bottom,
    x: scale(x, left, right), y: scale(y, bottom, top),
    velocity: unscale(x, left, right), load: unscale(y, bottom, top),
  };
  const across = x.isLog ? logTicks(x.low, x.high) : ticks(x.low, x.high, (right - left) / 70);
  const down = y.isLog ? logTicks(y.low, y.high) : ticks(y.low, y.high, (bottom - top) / 40);
  const lines = [...across.map((value) => `M${frame.x(value)},${top}V${bottom}`),
    ...down.map((value) => `M${left},${frame.y(value)}H${right}`)];
  const dashes = [...across.map((value) => `M${frame.x(value)},${bottom}v4`),
    ...down.map((value) => `M${left},${frame.y(value)}h-4`)];
  const write = (/** @type {string} */ text, /** @type {string} */ anchor, /** @type {Attributes} */ place) =>
    svg("text", { ...place, "text-anchor": anchor }, text);
  const outline = [
    svg("path", { d: `M${left},${top}V${bottom}H${right}${dashes.join("")}` }),
    ...across.map((value) => write(shown(value), "middle", { x: frame.x(value), y: bottom + 17 })),
    ...down.map((value) => write(shown(value), "end", { x: left - 7, y: frame.y(value) + 4 })),
    write(x.label, "middle", { x: (left + right) / 2, y: height - 6 }),
    write(y.label, "middle", { transform: `translate(13 ${(top + bottom) / 2}) rotate(-90)` }),
  ];
  const inside = svg("g");
  const root = svg("svg", { viewBox: `0 0 ${width} ${height}`, height },
    svg("g", { class: "grid", "aria-hidden": "true" }, svg("path", { d: lines.join("") })),
    inside, svg("g", { class: "axis", "aria-hidden": "true" }, ...outline));
  return { root, inside, frame };
}

/** Data of the page, with base64 tables decoded to arrays. */
function readContent() {
  const packed = ["plane", "errors", "surface_errors", "rises", "times", "values", "likely", "places"];
  return JSON.parse(element("content").textContent ?? "", (name, value) => {
    if (typeof value !== "string" || !packed.includes(name)) return value;
    return new Float32Array(Uint8Array.from(atob(value), (letter) => letter.charCodeAt(0)).buffer);
  });
}

/** Pattern that fills what is outside the model. */
function hatch() {
  const size = { width: 6, height: 6, patternUnits: "userSpaceOnUse" };
  const line = svg("path", { class: "hatch", d: "M0,0V6" });
  return svg("pattern", { id: "hatch", ...size, patternTransform: "rotate(45)" }, line);
}

/** A mark of the legend drawn at a place [px]. @param {string} name @param {number} x @param {number} y
 * @param {number} [size] */
function sign(name, x, y, size = 1) {
  const shape = document.querySelector(`#sign-${name} svg > *`)?.cloneNode() ?? "";
  return svg("g", { transform: `translate(${x} ${y}) scale(${size}) translate(-13 -7)` }, shape);
}

/** Show those entries of the legend whose class occurs in the diagram. */
function showLegend() {
  for (const shape of element("legend").querySelectorAll("svg > *")) {
    const isThere = element("diagram").querySelector(`[class="${shape.getAttribute("class")}"]`);
    shape.closest("li")?.toggleAttribute("hidden", !isThere);
  }
}

/** The mark of an operating point. @param {Frame} frame @param {{load: number, velocity: number}} place */
function cross(frame, { load, velocity }) {
  const [x, y] = [frame.x(velocity), frame.y(load)];
  return svg("path", { class: "operating", d: `M${x - 9},${y}h18M${x},${y - 9}v18` });
}

/** SVG path of the region where all grids are positive; or, if `isLine`, of the line where one is 0. @param
 * {number[]} x @param {number[]} y [px] @param {number[][][]} grids values by y and x, or NaN @param
 * {boolean} isLine */
function contour(x, y, grids, isLine = false) {
  const cells = y.slice(1).flatMap((_top, i) => x.slice(1).flatMap((_right, j) => {
    const corners = [[i, j], [i, j + 1], [i + 1, j + 1], [i + 1, j]];
    const counts = grids.map((grid) => corners.filter(([k, l]) => grid[k][l] > 0).length);
    if (counts.some((count) => count === 0 || (isLine && count === 4))) return []; // most cells are empty
    return [corners.map(([k, l]) => [x[l], y[k], ...grids.map((grid) => grid[k][l])])];
  }));
  return cells.filter((corners) => !corners.flat().some(Number.isNaN)).flatMap((corners) => {
    const part = grids.reduce((rest, _, n) => clipped(rest, n + 2, isLine), corners);
    return isLine ? [part.slice(0, 2), part.slice(2)] : [part]; // a saddle has two lines
  }).map((part) => {
    const text = part.map(([across, down]) => `${across.toFixed(2)},${down.toFixed(2)}`).join("L");
    return text && `M${text}${isLine ? "" : "Z"}`;
  }).join("");
}

/** Part of a polygon where a value is positive; if `isLine`, only the places where it is 0.
 * @param {number[][]} corners @param {number} value its index in each @param {boolean} isLine */
function clipped(corners, value, isLine) {
  return corners.flatMap((corner, k) => {
    const next = corners[(k + 1) % corners.length];
    const [here, there] = [corner[value], next[value]];
    const kept = here > 0 && !isLine ? [corner] : [];
    if (here > 0 === there > 0) return kept;
    return [...kept, corner.map((own, n) => own + (here / (here - there)) * (next[n] - own))];
  });
}
