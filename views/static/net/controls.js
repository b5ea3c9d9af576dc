// What the reader of a net's page does: by pointer, keys and tools.

import { byId, isInField, make } from "../elements.js";
import { saveFile } from "../saving.js";
import { asPng } from "./figure.js";
import { areaOf } from "./joined.js";
import { facts, heading, WORDS } from "./words.js";

/** @import { NetPage } from "./page.js" */
/** @import { Edge, Item } from "./types.js" */

/** The drawn element that something happened to. @type {(event: Event) => SVGElement | null} */
const groupAt = ({ target }) => (target instanceof Element ? target.closest("#picture g[data-id]") : null);

/** @type {(group: SVGElement) => string} */
const idOf = (group) => group.dataset.id ?? "";

/**
 * Shows in short what is under the mouse.
 *
 * @param {NetPage} page
 * @param {Item | Edge} item
 * @param {number} x
 * @param {number} y
 */
function showHint(page, item, x, y) {
  const { hint } = page;
  const stands = page.picture.edges.find((edge) => edge.id === item.id)?.stands ?? [];
  const isEdge = "source" in item;
  const title = stands.length > 1 ? `${stands.length} lines` : isEdge ? WORDS[item.kind] : heading(item);
  const lines = facts(item, page.labels)
    .filter(([name]) => name !== "Id" || heading(item) !== item.id)
    .map(([name, text]) => make("div", {}, `${name}: ${text}`));
  hint.replaceChildren(make("b", {}, title), ` ${isEdge ? "" : WORDS[item.kind]}`, ...lines);
  const right = Math.min(x + 14, window.innerWidth - hint.offsetWidth - 8);
  const below = y + 16 + hint.offsetHeight <= window.innerHeight;
  hint.style.left = `${Math.max(4, right)}px`;
  hint.style.top = `${Math.max(4, below ? y + 16 : y - hint.offsetHeight - 10)}px`;
}

/** @param {NetPage} page */
export function bindPointer(page) {
  const { svg, hint } = page;
  svg.addEventListener("click", (event) => {
    const group = groupAt(event);
    if (!group) page.select(null);
    else if (event.target instanceof Element && event.target.closest(".fold")) page.toggle(idOf(group));
    else if (page.items.has(idOf(group))) page.select(idOf(group));
  });
  svg.addEventListener("dblclick", (event) => {
    const group = groupAt(event);
    if (group && page.folded.has(idOf(group))) page.toggle(idOf(group));
  });
  svg.addEventListener("pointermove", (event) => {
    const group = event.buttons ? null : groupAt(event);
    const item = group && page.items.get(idOf(group));
    hint.hidden = !item;
    page.point(item ? item.id : null);
    if (item) showHint(page, item, event.clientX, event.clientY);
  });
  svg.addEventListener("pointerleave", () => {
    hint.hidden = true;
    page.point(null);
  });
  svg.addEventListener("focusin", (event) => {
    const group = groupAt(event);
    if (!group) return;
    page.point(idOf(group));
    const item = page.placed(idOf(group));
    if (item) page.pan.bringIn(areaOf(item));
  });
  svg.addEventListener("focusout", () => page.point(null));
}

/** @param {NetPage} page */
export function bindKeys(page) {
  const { pan } = page;
  /** @type {Record<string, () => unknown>} */
  const keys = {
    ArrowLeft: () => pan.move(-0.1, 0),
    ArrowRight: () => pan.move(0.1, 0),
    ArrowUp: () => pan.move(0, -0.1),
    ArrowDown: () => pan.move(0, 0.1),
    "+": () => pan.zoom(1.25),
    "=": () => pan.zoom(1.25),
    "-": () => pan.zoom(0.8),
    0: () => pan.fit(),
    "/": () => page.search.field.focus(),
    f: () => page.search.field.focus(),
    a: () => page.showAroundSelected(),
    e: () => page.showEverything(),
    x: () => page.foldAll(false),
    c: () => page.foldAll(true),
    n: () => page.nextChange(1),
    p: () => page.nextChange(-1),
    "?": () => page.help.showModal(),
    Escape: () => page.select(null),
  };
  document.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey || isInField(event) || page.help.open) return;
    const presses = event.key === "Enter" || event.key === " ";
    const group = groupAt(event);
    if (group && presses) {
      if (page.folded.has(idOf(group)) && event.key === " ") page.toggle(idOf(group));
      else page.select(idOf(group));
    } else if (presses && event.target instanceof HTMLButtonElement) return;
    else if (keys[event.key]) keys[event.key]();
    else return;
    event.preventDefault();
  });
}

/** @param {NetPage} page */
export function bindTools(page) {
  /** @type {(id: string, work: () => void) => void} */
  const onClick = (id, work) => byId(id, HTMLButtonElement).addEventListener("click", work);
  onClick("around", () => {
    if (!page.showAroundSelected()) page.say("choose an element first: click it, or search for it");
  });
  onClick("everything", () => page.showEverything());
  onClick("expand", () => page.foldAll(false));
  onClick("collapse", () => page.foldAll(true));
  onClick("fit", () => page.pan.fit());
  onClick("svg", () => saveFile(new Blob([page.figure()], { type: "image/svg+xml" }), `${page.name}.svg`));
  onClick("png", () =>
    asPng(page.figure(), page.picture).then(
      (picture) => saveFile(picture, `${page.name}.png`),
      (error) => page.say(`no picture could be made: ${error.message}`),
    ),
  );
  onClick("keys", () => page.help.showModal());
  const dark = matchMedia("(prefers-color-scheme: dark)");
  const theme = byId("theme", HTMLSelectElement);
  const paint = () => {
    const automatic = dark.matches ? "dark" : "light";
    document.body.dataset.theme = theme.value === "auto" ? automatic : theme.value;
  };
  theme.addEventListener("change", paint);
  dark.addEventListener("change", paint);
  paint();
}
