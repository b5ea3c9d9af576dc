// What keys do; the help of the page lists them.

import { byId, isInField } from "../elements.js";
import { actionFor } from "./actions.js";
import { askForAction, search } from "./forms/asking.js";
import { toolsFor } from "./tools.js";

/** @import { Editor } from "./page.js" */

/** Does what a key stands for. @type {(event: KeyboardEvent, editor: Editor) => void} */
export function heed(event, editor) {
  const { key, ctrlKey, metaKey, shiftKey, altKey } = event;
  const isCommand = ctrlKey || metaKey;
  if (isCommand && key.toLowerCase() === "s") used(event, () => editor.save(false));
  if (document.querySelector("dialog[open]")) return;
  if (altKey && key === "ArrowUp" && !(event.target instanceof HTMLSelectElement)) {
    used(event, () => editor.up());
    return;
  }
  if (isInField(event)) {
    if (key === "Escape" && document.activeElement instanceof HTMLElement) document.activeElement.blur();
    return;
  }
  const lower = key.toLowerCase();
  const name = key === " " ? spaceOf(event) : isCommand ? lower : key;
  const action = actionFor(`${isCommand ? "Ctrl " : ""}${altKey ? "Alt " : ""}${name}`, editor);
  if (isCommand && lower === "z") used(event, () => editor.turn(shiftKey ? "redo" : "undo"));
  else if (isCommand && lower === "y") used(event, () => editor.turn("redo"));
  else if ((isCommand && lower === "f") || key === "/") used(event, () => search(editor));
  else if (isCommand && lower === "k") used(event, () => askForAction(editor));
  else if (action !== undefined && !shiftKey) used(event, () => action.act(editor));
  else if (isCommand || altKey) return;
  else if (key === "p") used(event, () => editor.player.toggle());
  else if (key === "c") used(event, () => editor.worker.check());
  else if (key === "q") used(event, () => editor.worker.focus());
  else if (editor.player.game !== null && play(event, editor)) return;
  else if (key === "Escape") used(event, () => editor.putDown());
  else if (key === "Delete" || key === "Backspace") used(event, () => editor.remove());
  else if (key === "F2") used(event, () => editor.looked !== null && editor.rename(editor.looked));
  else if (key.startsWith("Arrow") && editor.canvas.chosen().length > 0)
    used(event, () => editor.push(key, shiftKey));
  else if (key === "Enter" && shiftKey) editor.enterToo(event);
  else if (key === "Enter") editor.enter(event);
  else if (key === "0") used(event, () => editor.canvas.fit());
  else if (key === "a") used(event, () => editor.pen.beginArc());
  else if (key === "l") used(event, () => editor.canvas.diagram.get("lassoTool").toggle());
  else if (key === "?") used(event, () => byId("help", HTMLDialogElement).showModal());
  else if (/^[1-9]$/.test(key)) {
    const tool = toolsFor(editor.model, editor.page)[Number(key) - 1];
    if (tool) used(event, () => editor.pen.take(tool, false));
  }
}

/** The name of the space bar, which presses buttons where one has the focus. @type {(event: KeyboardEvent) => string} */
const spaceOf = ({ target }) => (target instanceof SVGElement || target === document.body ? "Space" : "");

/** Does what a key stands for while the model is played; whether it stands for anything. @type {(event: KeyboardEvent, editor: Editor) => boolean} */
function play(event, editor) {
  const { player } = editor;
  if (event.key === "ArrowLeft") used(event, () => player.back());
  else if (event.key === "ArrowRight") used(event, () => player.forward());
  else if (event.key === "r") used(event, () => player.run("random"));
  else return !["Enter", "0", "?", "Escape"].includes(event.key);
  return true;
}

/** @type {(event: KeyboardEvent, action: () => unknown) => void} */
function used(event, action) {
  event.preventDefault();
  action();
}
