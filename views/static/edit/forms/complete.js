// Completion of names in a field: what is typed of one brings up those that fit; keys or a click take one of them.

import { make } from "../../elements.js";

const MOST = 8; // names shown at once

/**
 * How names are completed.
 *
 * @typedef {object} Completion
 * @property {string} id of the list
 * @property {string} label of the list
 * @property {RegExp} word what stands of a name before the caret
 * @property {(typed: string) => string[]} fitting the names that fit what is typed
 * @property {number} first which of them is marked at once; -1: none
 * @property {(name: string) => string} [written] a name as the field has it
 * @property {() => void} [taken] is called when one was taken
 */

/**
 * Lets a field complete names.
 *
 * @param {HTMLInputElement} field
 * @param {Completion} completion
 * @returns {HTMLElement} the list of what fits
 */
export function completing(field, { id, label, word, fitting, first, written, taken }) {
  const list = make("ul", { role: "listbox", id, hidden: true, "aria-label": label });
  /** @type {string[]} */
  let found = [];
  let at = first;

  /** What stands of a name before the caret, and where that is. */
  const typed = () => {
    const end = field.selectionStart ?? field.value.length;
    const text = word.exec(field.value.slice(0, end))?.[0] ?? "";
    return { text, begin: end - text.length, end };
  };
  const show = () => {
    list.hidden = found.length === 0;
    field.setAttribute("aria-expanded", String(!list.hidden));
    list.replaceChildren(
      ...found.map((name, index) => {
        /** @type {(event: MouseEvent) => void} */
        const onmousedown = (event) => {
          event.preventDefault(); // the field keeps the focus
          take(name);
        };
        const marked = { "aria-selected": String(index === at), onmousedown };
        return make("li", { role: "option", id: `${id}-${index}`, ...marked }, name);
      }),
    );
    if (found[at] === undefined) field.removeAttribute("aria-activedescendant");
    else field.setAttribute("aria-activedescendant", `${id}-${at}`);
  };
  /** @type {(names: string[]) => void} */
  const offer = (names) => {
    found = names.slice(0, MOST);
    at = first;
    show();
  };
  /** @type {(name: string) => void} */
  const take = (name) => {
    const { begin, end } = typed();
    field.setRangeText(written?.(name) ?? name, begin, end, "end");
    offer([]);
    taken?.();
  };

  field.setAttribute("role", "combobox");
  field.setAttribute("aria-autocomplete", "list");
  field.setAttribute("aria-controls", id);
  field.setAttribute("aria-expanded", "false");
  field.autocomplete = "off";
  field.addEventListener("input", () => {
    const { text } = typed();
    offer(text === "" ? [] : fitting(text));
  });
  field.addEventListener("blur", () => offer([]));
  field.addEventListener("keydown", (event) => {
    if (found.length === 0) return;
    const step = event.key === "ArrowDown" ? 1 : event.key === "ArrowUp" ? -1 : 0;
    if (step !== 0) {
      at = (at + step + found.length) % found.length;
      show();
    } else if (event.key === "Enter" && at >= 0) take(found[at]);
    else if (event.key === "Tab" && !event.shiftKey) take(found[Math.max(at, 0)]);
    else if (event.key === "Escape") offer([]);
    else return;
    event.preventDefault();
    event.stopPropagation();
  });
  return list;
}
