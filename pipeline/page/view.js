/* How the diagram is seen: logarithmic axes, zoom, the address that keeps the reader's choices, pictures. */

/** Ends of the axes where the reader zoomed in. @type {View} */
const view = { isLog: false, x: {}, y: {} };

/** Zoom about a place of the diagram [px]; a factor below 1 shows less. @param {number} factor @param
 * {number} across @param {number} down */
function zoom(factor, across, down) {
  const { left, right, top, bottom, velocity, load } = diagram.frame;
  const near = (/** @type {number} */ end, /** @type {number} */ place) => place + (end - place) * factor;
  view.x = { low: velocity(near(left, across)), high: velocity(near(right, across)) };
  view.y = { low: load(near(bottom, down)), high: load(near(top, down)) };
  update();
}

/** Show the whole plane again. */
function unzoom() {
  Object.assign(view, { x: {}, y: {} });
  update();
}

function listenToView() {
  input("log").addEventListener("change", () => {
    view.isLog = input("log").checked;
    unzoom();
  });
  element("whole").addEventListener("click", unzoom);
  element("diagram").addEventListener("wheel", (event) => {
    event.preventDefault();
    const { left, top } = diagram.root.getBoundingClientRect();
    zoom(event.deltaY < 0 ? 0.8 : 1.25, event.clientX - left, event.clientY - top);
  }, { passive: false });
  element("diagram").addEventListener("keydown", ({ key }) => {
    const { left, right, top, bottom } = diagram.frame;
    if ("+-".includes(key)) zoom(key === "+" ? 0.8 : 1.25, (left + right) / 2, (top + bottom) / 2);
  });
  element("save-svg").addEventListener("click", () => save(picture(), "svg"));
  element("save-png").addEventListener("click", savePng);
}

/** The diagram as a file of its own: an SVG whose shapes have the colours that the page shows. */
function picture() {
  const copy = /** @type {SVGElement} */ (diagram.root.cloneNode(true));
  const looks = ["fill", "fill-opacity", "stroke", "stroke-width", "stroke-dasharray", "font-size"];
  const shapes = [...diagram.root.querySelectorAll("*")];
  [...copy.querySelectorAll("*")].forEach((shape, k) => {
    const look = getComputedStyle(shapes[k]);
    for (const name of looks) shape.setAttribute(name, look.getPropertyValue(name));
  });
  const { width, height } = diagram.root.getBoundingClientRect();
  const paper = getComputedStyle(document.body).backgroundColor;
  copy.prepend(svg("rect", { width: "100%", height: "100%", fill: paper }));
  filled(copy, { xmlns: SVG, width, height, "font-family": "sans-serif" }, []);
  const text = new XMLSerializer().serializeToString(copy);
  return `data:image/svg+xml;charset=utf-8,${encodeURIComponent(text)}`;
}

/** Save a file. @param {string} href its content @param {string} ending */
function save(href, ending) {
  html("a", { href, download: `${content.name}.${ending}` }).click();
}

/** Save the diagram as PNG, at twice the size of the screen. */
function savePng() {
  const image = new Image();
  image.addEventListener("load", () => {
    const canvas = document.createElement("canvas");
    Object.assign(canvas, { width: 2 * image.width, height: 2 * image.height });
    canvas.getContext("2d")?.drawImage(image, 0, 0, canvas.width, canvas.height);
    save(canvas.toDataURL("image/png"), "png");
  });
  image.src = picture();
}

/** Write the answer under changed conditions into its line. */
function showNow() {
  const turns = criticalVelocities().flatMap(([, likely, ...ends], i) => {
    const named = ends.map((end, k) => (Number.isFinite(end) ? `${[5, 95][k]} %: ${shown(end, 3)} m/s` : ""));
    const words = named.filter(Boolean).join(", ");
    const place = `${shown(likely, 3)} m/s at ${shown(content.loads[i])} N`;
    return Number.isFinite(likely) ? [words ? `${place} (${words})` : place] : [];
  });
  const set = content.controls.map(({ name, offset }) => {
    const value = shown((chosen.conditions[name] ?? NaN) + offset);
    return `${name.replaceAll("_", " ")} ${value}${offset ? " °C" : ""}`;
  });
  const few = turns.length > 2 ? [turns[0], turns[turns.length - 1]] : turns;
  const words = few.length ? `severe wear is 50 % likely at ${few.join("; ")}`
    : "no transition within the plane";
  element("now").textContent = `At ${set.join(", ")}: ${words}.`;
}

/** Keep the choices in the address, as "0&friction=0.12&log=1". @param {string} [scene] */
function keepAddress(scene = String(sceneNumber)) {
  const place = Number.isFinite(chosen.load + chosen.velocity)
    ? { load: chosen.load, velocity: chosen.velocity } : {};
  const held = { ...changes(), ...place, ...(view.isLog ? { log: 1 } : {}) };
  const words = Object.entries(held).map(([name, value]) => `${name}=${value}`);
  if (words.length || location.hash || scene !== "0") {
    history.replaceState(null, "", `#${[scene, ...words].join("&")}`);
  }
}

/** Take the choices that the address has; those out of range are left out. */
function readAddress() {
  const held = Object.fromEntries(new URLSearchParams(location.hash.slice(1)));
  for (const control of content.controls) {
    const conditions = { ...chosen.conditions, [control.name]: Number(held[control.name] ?? NaN) };
    if (!faultOf(conditions, control)) chosen.conditions = conditions;
  }
  view.isLog = input("log").checked = held.log === "1";
  for (const name of /** @type {AxisName[]} */ (["load", "velocity"])) {
    if (held[name]) input(`at-${name}`).value = held[name];
    chosen[name] = Number(held[name] ?? NaN);
  }
}
