/* The scene that is shown, of those of a sweep over entries: each is a template of its own. */

const sceneNumber = Number(location.hash.slice(1)) || 0;
const templates = document.querySelectorAll("template");
const chosenTemplate = templates[sceneNumber] ?? templates[0];
chosenTemplate.replaceWith(chosenTemplate.content);
// On a narrow screen each cell has its head beside it.
for (const { rows: [heads, ...rows] } of document.querySelectorAll("table")) {
  for (const cell of rows.flatMap(({ cells }) => [...cells])) {
    cell.dataset.head = heads.cells[cell.cellIndex].textContent ?? "";
  }
}

/** Let readers choose another scene, and give the conditions brought along. @param {() => object} changes */
function takeScene(changes) {
  const choice = input("scene");
  if (!choice) return {};
  choice.value = String(sceneNumber);
  if (history.state) choice.focus(); // for another arrow key
  choice.addEventListener("change", () => {
    history.replaceState(changes(), "", `#${choice.value}`);
    location.reload();
  });
  return history.state ?? {};
}
