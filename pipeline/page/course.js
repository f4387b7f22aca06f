/* The course of a chosen point, from the first increment of its ramp. */

/** Show the highest temperature while the load grows. @param {Point} point */
function showCourse(point) {
  const { steps, own, loads, rises } = content.course;
  const load = [...loads.slice(point.i * steps, (point.i + 1) * steps)];
  const rows = placesOf(point).map((place) => load.map((_, k) => place * steps + k).map((at) =>
    ({ at, value: temperature(rises[at]) - ZERO_CELSIUS })));
  const every = rows.flat().map(({ value }) => value).filter(Number.isFinite);
  const isThere = steps > 1 && isOwnBulk() && every.length > 1;
  const text = "While the load grows: the line on larger elements of the history, marks on the point’s own.";
  const x = { low: 0, high: 1.04 * content.loads[point.i], label: "load [N]" };
  const y = { ...ends(every), label: "highest temperature [°C]" };
  showChart("course", isThere, text, x, y, (frame) => rows.flatMap((row) => {
    const way = row.map(({ at, value }) => (own[at] === "1" ? NaN : frame.y(value)));
    const marks = row.map(({ value }, k) => [load[k], value, way[k]])
      .filter(([, value, height]) => Number.isFinite(value) && Number.isNaN(height))
      .map(([newtons, value]) => sign("unjudged", frame.x(newtons), frame.y(value), 1.25));
    const look = rows.length > 1 ? "faint" : "curve";
    return [svg("path", { class: look, d: path(load.map(frame.x), way) }), ...marks];
  }));
}
