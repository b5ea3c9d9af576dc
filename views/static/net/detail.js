// The panel next to the picture: the chosen element, or the differences of two models.

import { counted } from "../counting.js";
import { make } from "../elements.js";
import { facts, heading, SIGNS, WORDS } from "./words.js";

/** @import { NetPage } from "./page.js" */
/** @import { Edge, Item } from "./types.js" */

/**
 * Shows what is known of an element, and where to go from it.
 *
 * @type {(page: NetPage, item: Item | Edge) => void}
 */
export function describe(page, item) {
  page.side.replaceChildren(
    make("h2", {}, heading(item)),
    make("div", { class: "kind" }, WORDS[item.kind]),
    make(
      "dl",
      {},
      ...facts(item, page.labels).flatMap(([name, text]) => [make("dt", {}, name), make("dd", {}, text)]),
    ),
  );
  if (!("source" in item)) {
    const steps = [1, 2, 3].map((count) =>
      make("button", { onclick: () => page.showAround([item.id], count) }, String(count)),
    );
    page.side.append(
      make("p", {}, "Show what is ", ...steps, " steps around it"),
      ...neighbours(page, "Comes from", item.id, "target", "source"),
      ...neighbours(page, "Goes to", item.id, "source", "target"),
    );
  }
  const folded = page.folded.get(item.id);
  if (folded !== undefined)
    page.side.append(make("button", { onclick: () => page.toggle(item.id) }, folded ? "Expand" : "Collapse"));
}

/**
 * The elements at the other ends of an element's lines.
 *
 * @type {(page: NetPage, title: string, id: string, from: "source" | "target", to: "source" | "target") => Element[]}
 */
function neighbours(page, title, id, from, to) {
  const lines = page.everything.edges
    .filter((edge) => edge[from] === id)
    .map((edge) => {
      const said = `${page.labels.get(edge[to])} (${WORDS[edge.kind]}${edge.label ? `, ${edge.label}` : ""})`;
      return make("li", {}, make("button", { onclick: () => page.find(edge[to]) }, said));
    });
  return lines.length ? [make("h3", {}, title), make("ul", {}, ...lines)] : [];
}

/** Shows what differs between two models. @type {(page: NetPage) => void} */
export function listChanges(page) {
  const { changes } = page;
  const lines = changes.map((item) => {
    const name =
      "source" in item ? `${page.labels.get(item.source)} → ${page.labels.get(item.target)}` : heading(item);
    const button = make(
      "button",
      { onclick: () => page.find(item.id) },
      item.change && make("span", { class: `sign ${item.change}` }, SIGNS[item.change]),
      ` ${WORDS[item.kind]} ${name}`,
      item.notes && make("div", { class: "kind" }, item.notes.join("; ")),
    );
    return make("li", {}, button);
  });
  page.side.hidden = false;
  page.side.replaceChildren(
    make("h2", {}, changes.length ? counted(changes.length, "difference") : "no differences"),
    make("ul", {}, ...lines),
  );
}
