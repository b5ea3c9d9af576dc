// Completion of names in formulas: what is typed of a name brings up those that begin so, or hold it.

import { make } from "../elements.js";

const MOST = 8; // names shown at once

/**
 * Lets a field complete names.
 *
 * @param {HTMLInputElement} field
 * @param {() => string[]} names all that there are
 * @returns {HTMLElement} the field with its list
 */
export function completing(field, names) {
  const list = make("ul", { role: "listbox", id: `${field.id}-names`, hidden: true, "aria-label": "Names" });
  /** @type {string[]} */
  let found = [];
  let at = -1;

  const close = () => {
    found = [];
    at = -1;
    show();
  };
  const show = () => {
    list.hidden = found.length === 0;
    field.setAttribute("aria-expanded", String(!list.hidden));
    list.replaceChildren(
      ...found.map((name, index) => {
        const option = make(
          "li",
          { role: "option", id: `${list.id}-${index}`, "aria-selected": String(index === at) },
          name,
        );
        option.onmousedown = (event) => {
          event.preventDefault(); // the field keeps the focus
          take(name);
        };
        return option;
      }),
    );
    if (at >= 0) field.setAttribute("aria-activedescendant", `${list.id}-${at}`);
    else field.removeAttribute("aria-activedescendant");
  };
  const look = () => {
    const typed = wordBefore(field).toLowerCase();
    const all = typed === "" ? [] : names();
    const begins = all.filter((name) => name.toLowerCase().startsWith(typed));
    const holds = all.filter((name) => name.toLowerCase().includes(typed) && !begins.includes(name));
    found = [...begins, ...holds].slice(0, MOST);
    if (found.length === 1 && found[0].toLowerCase() === typed) found = [];
    at = -1;
    show();
  };
  /** @type {(name: string) => void} */
  const take = (name) => {
    const end = field.selectionStart ?? field.value.length;
    const start = end - wordBefore(field).length;
    field.setRangeText(name, start, end, "end");
    close();
  };

  field.setAttribute("role", "combobox");
  field.setAttribute("aria-autocomplete", "list");
  field.setAttribute("aria-controls", list.id);
  field.setAttribute("aria-expanded", "false");
  field.autocomplete = "off";
  field.addEventListener("input", look);
  field.addEventListener("blur", close);
  field.addEventListener("keydown", (event) => {
    if (found.length === 0) return;
    const step = event.key === "ArrowDown" ? 1 : event.key === "ArrowUp" ? -1 : 0;
    if (step !== 0) {
      at = (at + step + found.length) % found.length;
      show();
    } else if (event.key === "Enter" && at >= 0) take(found[at]);
    else if (event.key === "Tab" && !event.shiftKey) take(found[Math.max(at, 0)]);
    else if (event.key === "Escape") close();
    else return;
    event.preventDefault();
    event.stopPropagation();
  });
  return make("span", { class: "completing" }, field, list);
}

/** What of a name stands before the caret. @type {(field: HTMLInputElement) => string} */
function wordBefore(field) {
  const before = field.value.slice(0, field.selectionStart ?? field.value.length);
  return before.match(/[A-Za-z_][\w.[\]-]*$/)?.[0] ?? "";
}
