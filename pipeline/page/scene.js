/* Choice of the scene shown: a sweep over entries has one HTML template for each scene. */

const sceneNumber = Number(location.hash.slice(1).split("&")[0]) || 0;
const templates = document.querySelectorAll("template");
const chosenTemplate = templates[sceneNumber] ?? templates[0];
chosenTemplate.replaceWith(chosenTemplate.content);

/** Let readers choose a scene; the address hands their other choices on. */
function listenToScene() {
  const choice = input("scene");
  if (!choice) return;
  choice.value = String(sceneNumber);
  if (location.hash) choice.focus(); // so that arrow keys go on choosing
  choice.addEventListener("change", () => {
    keepAddress(choice.value);
    location.reload();
  });
}
