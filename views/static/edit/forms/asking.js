// Lists to choose from: elements of the model, pages, templates, and what can be done.

import { choose, elementsOf } from "./palette.js";

/** @import { Editor } from "../page.js" */

/** Goes to an element. @type {(editor: Editor) => void} */
export function search(editor) {
  const entries = elementsOf(editor.model, (element) => editor.go(element));
  choose("Search", entries);
}

/** Moves what is chosen into a page. @type {(editor: Editor) => void} */
export function askForPage(editor) {
  const { model, canvas } = editor;
  const elements = canvas.chosenShapes();
  const from = model.sheetOf(elements[0]);
  const pages = model.all("pn.Page").filter((each) => each !== from && !elements.includes(each));
  const entries = pages.map((page) => ({
    words: model.label(page),
    note: `${model.kind(page).words} in ${model.label(model.get(page).in ?? model.root)}`,
    act: () => editor.compose({ kind: "into", elements, page }, `move into ${model.label(page)}`),
  }));
  choose("Move into a page", entries);
}

/** Inserts a template. @type {(editor: Editor) => void} */
export function askForTemplate(editor) {
  const entries = editor.model.metamodel.templates.map(({ name, says }) => ({
    words: name,
    note: says,
    act: async () => {
      editor.go(editor.model.root);
      const at = editor.canvas.below();
      const operation = { kind: "insert", template: name, x: Math.round(at.x), y: Math.round(at.y) };
      if ((await editor.compose(operation, name, null)) === null) editor.canvas.fit();
    },
  }));
  choose("Insert a template", entries);
}

/** Does something with what is chosen. @type {(editor: Editor) => void} */
export function askForAction(editor) {
  const entries = editor.actions().map(({ words, key, act }) => ({ words, note: key, act }));
  choose("Actions", entries);
}
