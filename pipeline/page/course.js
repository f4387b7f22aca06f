"use strict";
/* The course of a chosen point, from the first increment of its ramp. */

/** Show the highest temperature while the load grows. @param {number} i @param {number} j */
function showCourse(i, j) {
  const [{ steps, own }, { loads, rises }] = [content.course, tables.course];
  const isOwn = bulkRatio(chosen.conditions) === bulkRatio(content.conditions);
  element("course").replaceChildren();
  element("course-caption").textContent = "";
  if (steps < 2 || !isOwn) return;
  const load = Array.from(loads.slice(i * steps, (i + 1) * steps));
  const rows = surfaces().map((surface) => {
    const first = placeOf(surface, i, j) * steps;
    const values = Array.from(rises.slice(first, first + steps), (rise) => temperature(rise) - ZERO_CELSIUS);
    return { values, way: values.map((value, k) => (Number(own[first + k]) ? NaN : value)) };
  });
  const every = rows.flatMap(({ values }) => values.filter(Number.isFinite));
  if (every.length < 2) return;
  const width = Math.max(element("course").clientWidth, 260);
  const x = { low: 0, high: 1.04 * content.loads[i], label: "load [N]" };
  const y = { ...ends(every), label: "highest temperature [°C]" };
  const { root, inside, frame } = axes(width, Math.round(Math.min(0.6 * width, 300)), x, y);
  const look = rows.length > 1 ? "faint" : "curve";
  for (const { values, way } of rows) {
    inside.append(svg("path", { class: look, d: path(load.map(frame.x), way.map(frame.y)) }));
    values.forEach((value, k) => {
      const isMark = Number.isFinite(value) && Number.isNaN(way[k]);
      if (isMark) inside.append(mark("unjudged", frame.x(load[k]), frame.y(value), 5));
    });
  }
  const text = "While the load grows: the line on larger elements of the history, marks on the point’s own.";
  element("course-caption").textContent = text;
  root.setAttribute("role", "img");
  root.setAttribute("aria-label", text);
  element("course").append(root);
}
