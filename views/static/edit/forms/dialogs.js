// What is asked in the dialog of the page, one thing at a time.

import { byId, make } from "../../elements.js";

/** Shows something in the dialog; `left` is called when it is closed. @type {(content: Element[], left?: () => void) => HTMLDialogElement} */
export function openDialog(content, left) {
  const dialog = byId("dialog", HTMLDialogElement);
  dialog.onclose = left ?? null;
  dialog.replaceChildren(...content);
  dialog.showModal();
  return dialog;
}

/** A button that does nothing. */
const cancel = () =>
  make("button", { type: "button", onclick: () => byId("dialog", HTMLDialogElement).close() }, "Cancel");

/**
 * Asks for what a form holds.
 *
 * @param {{ title: string, says: string, rows: HTMLElement[], button: string }} form
 * @param {() => unknown} submit
 * @param {() => void} [left]
 */
export function askForm({ title, says, rows, button }, submit, left) {
  const buttons = make("p", { class: "buttons" }, make("button", { class: "main" }, button), cancel());
  const texts = [make("h2", {}, title), make("p", { class: "quiet" }, says)];
  openDialog([make("form", { method: "dialog", onsubmit: submit }, ...texts, ...rows, buttons)], left);
}

/** Asks which of several things is meant. @type {(title: string, choices: { words: string, act: () => unknown }[]) => void} */
export function askWhich(title, choices) {
  const items = choices.map(({ words, act }) => {
    const onclick = () => {
      dialog.close();
      act();
    };
    return make("li", {}, make("button", { onclick }, words));
  });
  const dialog = openDialog([
    make("h2", {}, title),
    make("ul", { class: "choices" }, ...items),
    make("p", { class: "buttons" }, cancel()),
  ]);
}
