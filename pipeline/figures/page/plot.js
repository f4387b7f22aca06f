// @ts-check
"use strict";
/* Drawing: SVG elements, axes, colours. Nothing here knows a sweep. */

const SVG = "http://www.w3.org/2000/svg";

/**
 * @typedef {{x: (value: number) => number, y: (value: number) => number, left: number,
 *   right: number, top: number, bottom: number}} Frame where values lie [px]
 * @typedef {{low: number, high: number, label: string, isLog?: boolean}} Axis
 */

/**
 * An SVG element with attributes and children; text is text.
 * @param {string} name @param {Object<string, string | number>} [attributes]
 * @param {(Node | string)[]} children @returns {SVGElement}
 */
function svg(name, attributes = {}, ...children) {
  const element = document.createElementNS(SVG, name);
  for (const key in attributes) element.setAttribute(key, String(attributes[key]));
  element.append(...children);
  return /** @type {SVGElement} */ (element);
}

/**
 * An HTML element with attributes and children; text is text.
 * @param {string} name @param {Object<string, string>} [attributes]
 * @param {(Node | string)[]} children @returns {HTMLElement}
 */
function html(name, attributes = {}, ...children) {
  const element = document.createElement(name);
  for (const key in attributes) element.setAttribute(key, attributes[key]);
  element.append(...children);
  return element;
}

/**
 * Round values between two ends, about so many.
 * @param {number} low @param {number} high @param {number} count
 */
function ticks(low, high, count) {
  const rough = (high - low) / Math.max(count, 1);
  const power = 10 ** Math.floor(Math.log10(rough));
  const step = [1, 2, 2.5, 5, 10].map((each) => each * power).find((each) => each >= rough) ?? rough;
  const found = [];
  for (let k = Math.ceil(low / step - 1e-9); k * step <= high + 1e-9 * step; k++) {
    found.push(Number((k * step).toPrecision(12)));
  }
  return found;
}

/**
 * Round values on a logarithmic axis: 1, 2 and 5 times powers of ten, if there are enough of them.
 * @param {number} low @param {number} high @param {number} count
 */
function logTicks(low, high, count) {
  const found = [];
  for (let power = Math.floor(Math.log10(low)); power <= Math.log10(high); power++) {
    found.push(...[1, 2, 5].map((each) => Number((each * 10 ** power).toPrecision(12))));
  }
  const inside = found.filter((each) => each >= low && each <= high);
  return inside.length < 3 ? ticks(low, high, count) : inside;
}

/**
 * Places of an axis' values [px].
 * @param {Axis} axis @param {number} from @param {number} to @returns {(value: number) => number}
 */
function scale({ low, high, isLog }, from, to) {
  const of = isLog ? Math.log : (/** @type {number} */ value) => value;
  return (value) => from + ((of(value) - of(low)) / (of(high) - of(low))) * (to - from);
}

/**
 * A number as people read it. @param {number} value @param {number} [digits]
 */
function shown(value, digits = 4) {
  if (!Number.isFinite(value)) return "–";
  const size = Math.abs(value);
  if (size !== 0 && (size < 1e-4 || size >= 1e7)) return value.toExponential(Math.max(digits - 1, 0));
  return String(Number(value.toPrecision(digits)));
}

/**
 * Grid, axes and labels in an SVG of some size; what is drawn goes between grid and axes.
 * @param {number} width @param {number} height @param {Axis} x @param {Axis} y
 * @returns {{root: SVGElement, inside: SVGElement, frame: Frame}}
 */
function axes(width, height, x, y) {
  const [left, right, top, bottom] = [56, width - 12, 10, height - 42];
  const frame = { left, right, top, bottom, x: scale(x, left, right), y: scale(y, bottom, top) };
  const grid = svg("g", { class: "grid", "aria-hidden": "true" });
  const outline = svg("g", { class: "axis", "aria-hidden": "true" });
  for (const value of (x.isLog ? logTicks : ticks)(x.low, x.high, (right - left) / 70)) {
    const at = frame.x(value);
    grid.append(svg("line", { x1: at, x2: at, y1: top, y2: bottom }));
    outline.append(
      svg("line", { x1: at, x2: at, y1: bottom, y2: bottom + 4 }),
      svg("text", { x: at, y: bottom + 17, "text-anchor": "middle" }, shown(value)),
    );
  }
  for (const value of (y.isLog ? logTicks : ticks)(y.low, y.high, (bottom - top) / 40)) {
    const at = frame.y(value);
    grid.append(svg("line", { x1: left, x2: right, y1: at, y2: at }));
    outline.append(
      svg("line", { x1: left - 4, x2: left, y1: at, y2: at }),
      svg("text", { x: left - 7, y: at + 4, "text-anchor": "end" }, shown(value)),
    );
  }
  const middle = (top + bottom) / 2;
  outline.append(
    svg("path", { d: `M${left},${top}V${bottom}H${right}` }),
    svg("text", { x: (left + right) / 2, y: height - 6, "text-anchor": "middle" }, x.label),
    svg(
      "text",
      { x: 13, y: middle, "text-anchor": "middle", transform: `rotate(-90 13 ${middle})` },
      y.label,
    ),
  );
  const inside = svg("g");
  const root = svg("svg", { viewBox: `0 0 ${width} ${height}`, height });
  root.append(grid, inside, outline);
  return { root, inside, frame };
}

/**
 * Path through points; a gap where one is not finite.
 * @param {number[]} x @param {number[]} y in pixels
 */
function path(x, y) {
  let text = "";
  let pen = "M";
  x.forEach((at, k) => {
    const there = Number.isFinite(at) && Number.isFinite(y[k]);
    if (there) text += `${pen}${at.toFixed(2)},${y[k].toFixed(2)}`;
    pen = there ? "L" : "M";
  });
  return text;
}

/**
 * The mark of a kind of point.
 * @param {string} kind @param {number} x @param {number} y @param {number} r
 */
function mark(kind, x, y, r) {
  const look = { class: `mark is-${kind}` };
  if (kind === "failed") {
    return svg("path", { ...look, d: `M${x - r},${y - r}l${2 * r},${2 * r}m0,${-2 * r}l${-2 * r},${2 * r}` });
  }
  if (kind === "severe" || kind === "mixed") {
    return svg("rect", { ...look, x: x - r, y: y - r, width: 2 * r, height: 2 * r });
  }
  return svg("circle", { ...look, cx: x, cy: y, r: kind === "mild" ? r : r * 0.7 });
}

/** A square on its corner. @param {number} x @param {number} y @param {number} r @param {string} look */
function diamond(x, y, r, look) {
  return svg("path", { class: look, d: `M${x - r},${y}L${x},${y - r}L${x + r},${y}L${x},${y + r}Z` });
}

/** Colours from low to high, each readable in grey, too. */
const COLOURS = {
  pressure: ["#fde725", "#5ec962", "#21918c", "#3b528b", "#440154"],
  temperature: ["#1b0c41", "#65156e", "#bb3754", "#ed6925", "#fbb61a", "#fcffa4"],
  wear: ["#00224e", "#3b496c", "#7c7b78", "#bcaf6f", "#fee838"],
};

/**
 * Colour at a part of a scale, as red, green and blue.
 * @param {string[]} colours @param {number} part from 0 to 1
 */
function colour(colours, part) {
  const at = Math.min(Math.max(part, 0), 1) * (colours.length - 1);
  const k = Math.min(Math.floor(at), colours.length - 2);
  const [low, high] = [colours[k], colours[k + 1]].map((each) => parseInt(each.slice(1), 16));
  return [16, 8, 0].map((shift) => {
    const [a, b] = [(low >> shift) & 255, (high >> shift) & 255];
    return Math.round(a + (at - k) * (b - a));
  });
}
