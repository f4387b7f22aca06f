// @ts-check
"use strict";
/* The scene that is shown, of those of a sweep over entries: each is a template of its own. */

/** Put the scene that the address names in the place of its template. */
function placeScene() {
  const scenes = [...document.querySelectorAll("template")];
  const scene = scenes[sceneNumber()] ?? scenes[0];
  scene.replaceWith(scene.content);
}

function sceneNumber() {
  return Number(location.hash.slice(1)) || 0;
}

/**
 * Let the reader choose another scene, which keeps the conditions that were changed; give those
 * that were brought along.
 * @param {() => object} changes
 */
function takeScene(changes) {
  const choice = input("scene");
  if (!choice) return {};
  choice.value = String(sceneNumber());
  choice.addEventListener("change", () => {
    history.replaceState(changes(), "", `#${choice.value}`);
    location.reload();
  });
  return history.state ?? {};
}

placeScene();
