/* Choice of the scene shown: a sweep over entries has one HTML template for each scene. */

const sceneNumber = Number(location.hash.slice(1).split("&")[0]) || 0;
const templates = document.querySelectorAll("template");
const chosenTemplate = templates[sceneNumber] ?? templates[0];
chosenTemplate.replaceWith(chosenTemplate.content);
// On a narrow screen the heading is shown next to each cell.
for (const { rows: [heads, ...rows] } of document.querySelectorAll("table")) {
  for (const cell of rows.flatMap(({ cells }) => [...cells])) {
    cell.dataset.head = heads.cells[cell.cellIndex].textContent ?? "";
  }
}

/** Let readers choose a scene; return conditions kept from the last one. @param {() => object} changes */
function takeScene(changes) {
  const choice = input("scene");
  if (!choice) return {};
  choice.value = String(sceneNumber);
  if (history.state) choice.focus(); // so that arrow keys go on choosing
  choice.addEventListener("change", () => {
    history.replaceState(changes(), "", `#${choice.value}`);
    location.reload();
  });
  return history.state ?? {};
}
