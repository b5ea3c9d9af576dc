// The field of a clause: it completes names of signals, and shows errors where they are.

import { make } from "../../elements.js";
import { completing } from "./complete.js";

/** @import { Refused } from "../types.js" */

const KEYWORDS = new Set(["true", "false", "and", "or", "not"]);

/**
 * Gives a field what clauses need.
 *
 * @param {HTMLInputElement} input
 * @param {{ name: string, value?: string }[]} signals what can be spoken of
 * @param {(text: string) => Promise<Refused | null>} wrong what is wrong with a text
 * @returns {HTMLElement[]} what stands below the field
 */
export function clauseHelp(input, signals, wrong) {
  const said = make("div", { class: "where", role: "status", hidden: true });
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
  const written = new Map(
    signals.map(({ name, value }) =>
      value === undefined ? [name, quoted(name)] : [`${name} = ${value}`, `${quoted(name)} = '${value}'`],
    ),
  );
  const list = completing(input, {
    id: "clause-signals",
    label: "signals",
    word: /"[^"]*$|[\p{L}\p{N}_.-]*$/u,
    fitting(typed) {
      const word = typed.replace(/^"/, "");
      const isWithin = (/** @type {string} */ name) => name.toLowerCase().includes(word.toLowerCase());
      return word ? [...written.keys()].filter((name) => isWithin(name) && name !== word) : [];
    },
    first: 0,
    written: (name) => written.get(name) ?? name,
    taken: check,
  });
  input.addEventListener("input", check);
  input.addEventListener("blur", check);
  return [list, said];
}

/** A name as clauses read it. @type {(name: string) => string} */
const quoted = (name) =>
  /^[\p{L}\p{N}_]+(?:[.-]+[\p{L}\p{N}_]+)*$/u.test(name) && !KEYWORDS.has(name)
    ? name
    : `"${name.replace(/[\\"]/g, "\\$&")}"`;
