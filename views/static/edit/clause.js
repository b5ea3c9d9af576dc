// The field of a clause: names of signals are completed, and what is wrong is said where it stands.

import { make } from "../elements.js";

/** @import { Refused } from "./types.js" */

/**
 * Gives a field what clauses need.
 *
 * @param {HTMLInputElement} input
 * @param {string[]} signals what can be spoken of
 * @param {(text: string) => Promise<Refused | null>} wrong what is wrong with a text
 * @returns {HTMLElement[]} what stands below the field
 */
export function clauseHelp(input, signals, wrong) {
  const list = make("ul", { id: "clause-signals", role: "listbox", "aria-label": "signals", hidden: true });
  const said = make("div", { class: "where", role: "status", hidden: true });
  input.setAttribute("role", "combobox");
  input.setAttribute("aria-autocomplete", "list");
  input.setAttribute("aria-controls", list.id);
  input.setAttribute("autocomplete", "off");
  let at = 0;
  const close = () => {
    list.hidden = true;
    input.setAttribute("aria-expanded", "false");
    input.removeAttribute("aria-activedescendant");
  };
  const mark = (/** @type {number} */ index) => {
    const { length } = list.children;
    at = (index + length) % Math.max(1, length);
    [...list.children].forEach((each, number) => {
      each.setAttribute("aria-selected", String(number === at));
    });
    input.setAttribute("aria-activedescendant", `signal-${at}`);
  };
  const take = (/** @type {string} */ name) => {
    const { begin, end } = wordAt(input);
    input.setRangeText(quoted(name), begin, end, "end");
    close();
    check();
  };
  const offer = () => {
    const { word } = wordAt(input);
    const fitting = signals.filter(
      (name) => word && name.toLowerCase().includes(word.toLowerCase()) && name !== word,
    );
    if (fitting.length === 0) {
      close();
      return;
    }
    const options = fitting.slice(0, 8).map((name, index) => {
      const option = make("li", { role: "option", id: `signal-${index}` }, name);
      option.addEventListener("pointerdown", (event) => {
        event.preventDefault(); // the field keeps the focus
        take(name);
      });
      return option;
    });
    list.replaceChildren(...options);
    list.hidden = false;
    input.setAttribute("aria-expanded", "true");
    mark(0);
  };
  const check = async () => {
    const text = input.value;
    said.hidden = said.hidden || !list.hidden;
    if (!list.hidden) return; // a name is being typed
    const refused = text.trim() ? await wrong(text) : null;
    if (input.value !== text) return; // something else was typed meanwhile
    input.setAttribute("aria-invalid", String(refused !== null));
    said.hidden = refused === null;
    if (refused === null) return;
    const { column, reason, hint } = refused;
    said.replaceChildren(
      ...(column === undefined ? [] : [make("pre", {}, `${text}\n${" ".repeat(column - 1)}^`)]),
      make("span", {}, hint ? `${reason} (${hint})` : reason),
    );
  };
  input.addEventListener("input", () => {
    offer();
    check();
  });
  input.addEventListener("blur", () => {
    close();
    check();
  });
  input.addEventListener("keydown", (event) => {
    if (list.hidden) return;
    if (event.key === "ArrowDown") mark(at + 1);
    else if (event.key === "ArrowUp") mark(at - 1);
    else if (event.key === "Enter" || event.key === "Tab") take(list.children[at].textContent ?? "");
    else if (event.key === "Escape") close();
    else return;
    event.preventDefault();
    event.stopPropagation();
  });
  return [list, said];
}

/** The word in front of the cursor. @type {(input: HTMLInputElement) => { word: string, begin: number, end: number }} */
function wordAt(input) {
  const end = input.selectionStart ?? input.value.length;
  const word = /"[^"]*$|[\p{L}\p{N}_.-]*$/u.exec(input.value.slice(0, end))?.[0] ?? "";
  return { word: word.replace(/^"/, ""), begin: end - word.length, end };
}

const KEYWORDS = new Set(["true", "false", "and", "or", "not"]);

/** A name as clauses read it. @type {(name: string) => string} */
const quoted = (name) =>
  /^[\p{L}\p{N}_]+(?:[.-]+[\p{L}\p{N}_]+)*$/u.test(name) && !KEYWORDS.has(name)
    ? name
    : `"${name.replace(/[\\"]/g, "\\$&")}"`;
