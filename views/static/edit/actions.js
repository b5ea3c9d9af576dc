// What can be done with what is chosen, beyond drawing: each with its key, and all of them in one list.

import { shifts } from "./aligning.js";
import { askForPage, askForTemplate } from "./forms/asking.js";

/** @import { Editor } from "./page.js" */
/** @import { Way } from "./aligning.js" */
/** @import { CanvasElement } from "./types.js" */

/**
 * An action.
 *
 * @typedef {object} Action
 * @property {string} words
 * @property {string} key how keys.js writes the keys that do it; empty: only the list has it
 * @property {(editor: Editor) => boolean} applies
 * @property {(editor: Editor) => unknown} act
 */

/** Shapes that are chosen. @type {(editor: Editor) => CanvasElement[]} */
const shapes = ({ canvas }) => canvas.selection.get().filter((each) => each.waypoints === undefined);

/** @type {(least: number) => (editor: Editor) => boolean} */
const chosen = (least) => (editor) => shapes(editor).length >= least;

/** What of the chosen is on a page, so that it can go into another one. @type {(editor: Editor) => boolean} */
const isOnPage = (editor) =>
  shapes(editor).length > 0 &&
  shapes(editor).every(({ business }) => editor.model.get(business.element).as === "objects");

/** @type {(words: string, key: string, way: Way, least: number) => Action} */
const aligned = (words, key, way, least) => ({
  words,
  key,
  applies: chosen(least),
  act: (editor) => {
    const found = shapes(editor);
    const moved = new Map(shifts(found, way).map((shift, index) => [found[index], shift]));
    return editor.act(editor.canvas.moved(moved), words);
  },
});

/** The element of the canvas that has the focus. @type {() => string | undefined} */
export function focusedElement() {
  const { activeElement } = document;
  return activeElement instanceof SVGElement ? activeElement.dataset.element : undefined;
}

/** The page that has the focus, or is the only one that is chosen. @type {(editor: Editor) => string | null} */
function pageOf({ canvas }) {
  const focused = focusedElement();
  const elements = focused === undefined ? canvas.chosenShapes() : [focused];
  const found = elements.length === 1 ? canvas.registry.get(elements[0]) : undefined;
  return found?.business.isPage ? elements[0] : null;
}

/** @type {Action[]} */
export const ACTIONS = [
  {
    words: "open the page in place, or close it",
    key: "Space",
    applies: (editor) => pageOf(editor) !== null,
    act: (editor) => editor.toggle(pageOf(editor) ?? ""),
  },
  { words: "choose all", key: "Ctrl a", applies: () => true, act: (editor) => editor.canvas.chooseAll() },
  { words: "copy", key: "Ctrl c", applies: chosen(1), act: (editor) => editor.clipboard.copy(false) },
  { words: "cut", key: "Ctrl x", applies: isOnPage, act: (editor) => editor.clipboard.copy(true) },
  {
    words: "paste",
    key: "Ctrl v",
    applies: (editor) => editor.clipboard.elements.length > 0,
    act: (editor) => editor.clipboard.paste(),
  },
  { words: "duplicate", key: "Ctrl d", applies: chosen(1), act: (editor) => editor.clipboard.duplicate() },
  {
    words: "group into a page",
    key: "g",
    applies: isOnPage,
    act: (editor) => editor.group("pn.Page"),
  },
  {
    words: "group into a callback page",
    key: "",
    applies: (editor) => isOnPage(editor) && editor.model.classOf("sym.CallbackPage") !== undefined,
    act: (editor) => editor.group("sym.CallbackPage"),
  },
  {
    words: "split the page",
    key: "u",
    applies: (editor) => shapes(editor).length === 1 && isOnPage(editor) && editor.isPage(shapes(editor)[0]),
    act: (editor) => editor.split(),
  },
  { words: "move into a page…", key: "m", applies: isOnPage, act: askForPage },
  aligned("align left", "Alt 1", "left", 2),
  aligned("align centres", "Alt 2", "centre", 2),
  aligned("align right", "Alt 3", "right", 2),
  aligned("align top", "Alt 4", "top", 2),
  aligned("align middles", "Alt 5", "middle", 2),
  aligned("align bottom", "Alt 6", "bottom", 2),
  aligned("distribute across", "Alt 7", "across", 3),
  aligned("distribute down", "Alt 8", "down", 3),
  { words: "arrange the sheet", key: "", applies: () => true, act: (editor) => editor.places.arrange() },
  { words: "insert a template…", key: "t", applies: () => true, act: askForTemplate },
];

/** The action of a key that can be done now. @type {(key: string, editor: Editor) => Action | undefined} */
export const actionFor = (key, editor) =>
  ACTIONS.find((action) => action.key === key && action.applies(editor));
