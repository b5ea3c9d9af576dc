// Lists to search and choose from by keys: elements, actions, pages, templates.

import { make } from "../../elements.js";
import { openDialog } from "./dialogs.js";

/** @import { Model } from "../model.js" */

/** An entry of a list. @typedef {{ words: string, note: string, act: () => unknown }} Entry */

const MOST = 60; // entries that are shown

/**
 * Opens a list: typing narrows it, arrows walk through it, Enter takes what is marked.
 *
 * @param {string} title
 * @param {Entry[]} entries
 */
export function choose(title, entries) {
  const list = make("ul", { id: "palette-list", role: "listbox", "aria-label": title });
  const field = make("input", {
    type: "search",
    role: "combobox",
    "aria-label": title,
    "aria-controls": "palette-list",
    "aria-expanded": "true",
    "aria-autocomplete": "list",
    autofocus: true,
    spellcheck: "false",
  });
  /** @type {Entry[]} */
  let found = [];
  let at = 0;
  const mark = (/** @type {number} */ index) => {
    at = Math.max(0, Math.min(index, found.length - 1));
    [...list.children].forEach((each, number) => {
      each.setAttribute("aria-selected", String(number === at));
    });
    field.setAttribute("aria-activedescendant", found.length ? `palette-${at}` : "");
    list.children[at]?.scrollIntoView({ block: "nearest" });
  };
  const take = (/** @type {Entry | undefined} */ entry) => {
    if (entry === undefined) return;
    dialog.close();
    entry.act();
  };
  const narrow = () => {
    found = matching(entries, field.value).slice(0, MOST);
    list.replaceChildren(
      ...found.map((entry, index) =>
        make(
          "li",
          { role: "option", id: `palette-${index}`, onclick: () => take(entry) },
          make("span", {}, entry.words),
          make("span", { class: "quiet" }, entry.note),
        ),
      ),
    );
    mark(0);
  };
  field.oninput = narrow;
  field.onkeydown = (event) => {
    if (event.key === "ArrowDown" || event.key === "ArrowUp") mark(at + (event.key === "ArrowDown" ? 1 : -1));
    else if (event.key === "Enter") take(found[at]);
    else return;
    event.preventDefault();
  };
  narrow();
  const dialog = openDialog([make("div", { class: "palette" }, make("h2", {}, title), field, list)]);
}

/** Entries whose words or notes have all that was typed; those that begin with it first. @type {(entries: Entry[], typed: string) => Entry[]} */
export function matching(entries, typed) {
  const wanted = typed.toLowerCase().split(/\s+/).filter(Boolean);
  const begins = (/** @type {Entry} */ { words }) =>
    wanted.length > 0 && words.toLowerCase().startsWith(wanted[0]) ? 0 : 1;
  return entries
    .filter(({ words, note }) => {
      const text = `${words} ${note}`.toLowerCase();
      return wanted.every((each) => text.includes(each));
    })
    .sort((one, other) => begins(one) - begins(other));
}

/** What can be searched for: all that has a name, by what it is, where, and what it says. @type {(model: Model, go: (element: string) => void) => Entry[]} */
export function elementsOf(model, go) {
  return [...model.objects.keys()]
    .filter((element) => {
      const { values } = model.get(element);
      return values?.id !== undefined || values?.name !== undefined || values?.text !== undefined;
    })
    .map((element) => {
      const { values = {}, in: above } = model.get(element);
      const said = [values.id, values.topic, values.service, values.action, values.text].filter(
        (each) => each !== undefined && each !== model.label(element),
      );
      const where = above === undefined ? "" : ` in ${model.label(above)}`;
      const note = [`${model.kind(element).words}${where}`, ...said].join(" · ");
      return { words: model.label(element), note, act: () => go(element) };
    });
}
