// The tools for a sheet: choosing, arcs, and one for each class that can be there, by the metamodel.

import { make } from "../elements.js";
import { typesFor } from "./forms/making.js";

/** @import { Model } from "./model.js" */

/**
 * A tool: what a click on the canvas makes.
 *
 * @typedef {{ name: string, words: string, says: string, feature: string, type: string }} Tool
 */

export const CHOOSE = "choose";
export const ARC = "arc";

/** @type {(model: Model, sheet: string) => Tool[]} */
export function toolsFor(model, sheet) {
  const features = model.kind(sheet).features.filter(({ kind, many }) => kind === "part" && many);
  /** @type {Tool[]} */
  const found = [{ name: CHOOSE, words: "choose", says: "Choose and move elements.", feature: "", type: "" }];
  const arcs = features.find(({ type }) => model.isA(type, "pn.Arc"));
  if (arcs) {
    const says = `${model.classOf(arcs.type).says} Click its source, then its target.`;
    found.push({ name: ARC, words: "arc", says, feature: arcs.name, type: arcs.type });
  }
  for (const feature of features) {
    for (const type of typesFor(model, feature, sheet)) {
      const { shape, words, says } = model.classOf(type);
      if (shape !== undefined) found.push({ name: type, words, says, feature: feature.name, type });
    }
  }
  return found;
}

/**
 * Shows the tools as buttons.
 *
 * @param {HTMLElement} bar
 * @param {Tool[]} tools
 * @param {string} taken the name of the one that is used
 * @param {(tool: Tool, byKey: boolean) => void} take
 */
export function showTools(bar, tools, taken, take) {
  const focused = bar.contains(document.activeElement)
    ? /** @type {HTMLElement} */ (document.activeElement).dataset.tool
    : null;
  bar.replaceChildren(
    ...tools.map((tool, index) =>
      make(
        "button",
        {
          "data-tool": tool.name,
          "aria-pressed": String(tool.name === taken),
          title: tool.says,
          onclick: (event) => take(tool, event.detail === 0),
        },
        tool.words,
        index < 9 && make("kbd", { "aria-hidden": "true" }, String(index + 1)),
      ),
    ),
  );
  if (focused) [...bar.querySelectorAll("button")].find((each) => each.dataset.tool === focused)?.focus();
}
