// @ts-check
"use strict";
/* The points of the diagram, by pointer and by keyboard: what they tell, and which is kept. */

const tip = html("div", { class: "tip", role: "tooltip", id: "tip", hidden: "" });

/** Element that takes pointer and focus for a point. */
function target(/** @type {Frame} */ frame, /** @type {number} */ i, /** @type {number} */ j) {
  const at = { cx: frame.x(sweep.velocities[j]), cy: frame.y(sweep.loads[i]) };
  const dense = (frame.right - frame.left) / sweep.velocities.length;
  const r = Math.min(Math.max(dense / 2, 5), 11);
  const found = svg("g", { class: "point-target", role: "button", tabindex: "-1" });
  found.append(svg("circle", { class: "hit", ...at, r }));
  found.addEventListener("pointerenter", () => showTip(i, j));
  found.addEventListener("pointerleave", hideTip);
  found.addEventListener("focus", () => {
    found.setAttribute("aria-label", labelOf(i, j));
    showTip(i, j);
  });
  found.addEventListener("blur", hideTip);
  found.addEventListener("click", () => choosePoint(i, j));
  found.addEventListener("keydown", (event) => pressed(/** @type {KeyboardEvent} */ (event), i, j));
  return found;
}

/** Indices of the point with which to begin: the one nearest to the transition. */
function nearest() {
  const limit = riseLimit(chosen.conditions);
  const { rises } = sweep.decisive(chosen.conditions);
  let found = { i: 0, j: 0 };
  let least = Infinity;
  rises[chosen.surface ?? 0].forEach((row, i) =>
    row.forEach((rise, j) => {
      const distance = Math.abs(Math.log(rise / limit));
      if (distance < least) {
        least = distance;
        found = { i, j };
      }
    }),
  );
  return found;
}

/** Move with the arrow keys, keep a point with Enter or Space. */
function pressed(
  /** @type {KeyboardEvent} */ event,
  /** @type {number} */ i,
  /** @type {number} */ j,
) {
  /** @type {Object<string, [number, number]>} */
  const ways = { ArrowUp: [1, 0], ArrowDown: [-1, 0], ArrowLeft: [0, -1], ArrowRight: [0, 1] };
  if (event.key === "Enter" || event.key === " ") choosePoint(i, j);
  else if (event.key === "Escape") hideTip();
  else if (ways[event.key]) focusOn(i, j, ...ways[event.key]);
  else return;
  event.preventDefault();
}

/** Move the focus to the next point in a direction that has anything to tell. */
function focusOn(
  /** @type {number} */ i,
  /** @type {number} */ j,
  /** @type {number} */ up,
  /** @type {number} */ right,
) {
  let [k, l] = [i + up, j + right];
  while (diagram?.targets[k]?.[l] && !kindOf(k, l)) [k, l] = [k + up, l + right];
  const next = diagram?.targets[k]?.[l];
  if (!diagram || !next) return;
  diagram.targets[i][j].setAttribute("tabindex", "-1");
  next.setAttribute("tabindex", "0");
  next.focus();
}

/** @param {number} i @param {number} j */
function showTip(i, j) {
  if (!diagram) return;
  const rows = told(i, j, false).map(([name, text]) => html("div", {}, `${name}: ${text}`));
  tip.replaceChildren(html("b", {}, nameOf(i, j)), ...rows);
  tip.hidden = false;
  const { frame } = diagram;
  const [x, y] = [frame.x(sweep.velocities[j]), frame.y(sweep.loads[i])];
  const left = Math.min(x + 14, frame.right - tip.offsetWidth);
  tip.style.left = `${Math.max(left, 0)}px`;
  const under = y + 14 + tip.offsetHeight < frame.bottom;
  tip.style.top = `${under ? y + 14 : Math.max(y - 14 - tip.offsetHeight, 0)}px`;
}

function hideTip() {
  tip.hidden = true;
}

/** @param {number} i @param {number} j */
function choosePoint(i, j) {
  if (!kindOf(i, j)) return;
  if (diagram) {
    for (const each of diagram.targets.flat()) {
      each.setAttribute("tabindex", "-1");
      each.classList.remove("is-chosen");
    }
    diagram.targets[i][j].setAttribute("tabindex", "0");
    diagram.targets[i][j].classList.add("is-chosen");
  }
  chosen.point = { i, j };
  showPoint();
}

/** @param {number} i @param {number} j */
function labelOf(i, j) {
  return `${nameOf(i, j)}: ${told(i, j, false).map(([name, text]) => `${name} ${text}`).join("; ")}`;
}

/** Name the points for who cannot see them. */
function labelPoints() {
  diagram?.targets.forEach((row, i) =>
    row.forEach((each, j) => each.setAttribute("aria-label", labelOf(i, j))),
  );
}
