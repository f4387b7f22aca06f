// @ts-check
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
  root.addEventListener("focus", () => pointTo(pointed ?? chosen.point ?? nearest()));
  root.addEventListener("click", (event) => {
    const point = pointAt(event);
    if (point) choosePoint(point.i, point.j);
  });
  root.addEventListener("keydown", pressed);
}

/** Point of the sweep under a pointer. @param {MouseEvent} event */
function pointAt(event) {
  if (!diagram) return null;
  const { frame, root } = diagram;
  const { left, top } = root.getBoundingClientRect();
  const [i, j] = [
    closest(sweep.loads.map(frame.y), event.clientY - top),
    closest(sweep.velocities.map(frame.x), event.clientX - left),
  ];
  return i < 0 || j < 0 || !isShown(i, j) ? null : { i, j };
}

/**
 * Index of the place within reach of a pointer, −1 if there is none.
 * @param {number[]} places @param {number} pointer
 */
function closest(places, pointer) {
  const distances = places.map((place) => Math.abs(place - pointer));
  const least = Math.min(...distances);
  return least < REACH ? distances.indexOf(least) : -1;
}

/** A point has anything to tell, and lies within the frame. @param {number} i @param {number} j */
function isShown(i, j) {
  const x = diagram?.frame.x(sweep.velocities[j]) ?? NaN;
  return kindOf(i, j) !== "" && x >= (diagram?.frame.left ?? NaN) && x <= (diagram?.frame.right ?? NaN);
}

/** Point with which to begin: the one nearest to the transition. */
function nearest() {
  const limit = riseLimit(chosen.conditions);
  const distances = everyPoint().map(({ i, j }) =>
    Math.abs(Math.log(sweep.rise(chosen.surface ?? 0, i, j, chosen.conditions) / limit)),
  );
  const least = Math.min(...distances.filter((distance) => !Number.isNaN(distance)));
  const k = Math.max(distances.indexOf(least), 0);
  const n = sweep.velocities.length;
  return { i: Math.floor(k / n), j: k % n };
}

/** Move with the arrow keys, keep a point with Enter or Space. @param {KeyboardEvent} event */
function pressed(event) {
  /** @type {Object<string, [number, number]>} */
  const ways = { ArrowUp: [1, 0], ArrowDown: [-1, 0], ArrowLeft: [0, -1], ArrowRight: [0, 1] };
  const { i, j } = pointed ?? nearest();
  if (event.key === "Enter" || event.key === " ") choosePoint(i, j);
  else if (event.key === "Escape") pointTo(null);
  else if (ways[event.key]) pointTo(next(i, j, ways[event.key]));
  else return;
  event.preventDefault();
}

/**
 * Next point in a direction that has anything to tell; the same one if there is none.
 * @param {number} i @param {number} j @param {[number, number]} way
 */
function next(i, j, [up, right]) {
  const isInside = () => k >= 0 && k < sweep.loads.length && l >= 0 && l < sweep.velocities.length;
  let [k, l] = [i + up, j + right];
  while (isInside() && !isShown(k, l)) [k, l] = [k + up, l + right];
  return isInside() ? { i: k, j: l } : { i, j };
}

/** Show the numbers of a point beside it, or of none. @param {{i: number, j: number} | null} point */
function pointTo(point) {
  if (!diagram) return;
  const isSame = point?.i === pointed?.i && point?.j === pointed?.j;
  if (isSame && point) return;
  pointed = point;
  tip.hidden = !point;
  ring(diagram.pointer, point);
  if (!point) return;
  const { i, j } = point;
  const rows = description(i, j, false).map(([name, text]) => html("div", {}, `${name}: ${text}`));
  tip.replaceChildren(html("b", {}, nameOf(i, j)), ...rows);
  placeTip(diagram.frame, sweep.loads[i], sweep.velocities[j]);
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
  if (!isThere || !diagram) return;
  circle.setAttribute("cx", String(diagram.frame.x(sweep.velocities[point.j])));
  circle.setAttribute("cy", String(diagram.frame.y(sweep.loads[point.i])));
}

/** @param {number} i @param {number} j */
function choosePoint(i, j) {
  if (!kindOf(i, j)) return;
  chosen.point = { i, j };
  if (diagram) ring(diagram.choice, chosen.point);
  showPoint();
}
