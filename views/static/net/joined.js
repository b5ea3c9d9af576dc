// What belongs together in a picture: the lines of a node, and what stands for what is hidden.

import { lookUp } from "../maps.js";

/** @import { Part } from "./pan.js" */
/** @import { Item, Picture, Placed } from "./types.js" */

/** The box that an element is in. @type {(item: Item) => string | null | undefined} */
export const outer = (item) => ("title" in item ? item.parent : item.box);

/**
 * The lines that lead to a node, or into a box and out of it; a line itself.
 *
 * @type {(picture: Picture, id: string | null) => string[]}
 */
export function linesOf({ boxes, nodes, edges }, id) {
  if (id === null) return [];
  const inside = new Set([id]);
  for (const item of [...boxes, ...nodes]) if (inside.has(outer(item) ?? "")) inside.add(item.id);
  return edges
    .filter((edge) => edge.id === id || inside.has(edge.source) !== inside.has(edge.target))
    .map((edge) => edge.id);
}

/**
 * The element itself where a picture shows it, or the collapsed box that hides it; of a line, its source.
 *
 * @type {(picture: Picture, items: Map<string, Item>, id: string) => Placed | null}
 */
export function shownFor(picture, items, id) {
  const shown = new Map([...picture.boxes, ...picture.nodes].map((item) => [item.id, item]));
  /** @type {string | null | undefined} */
  let at = id;
  while (at !== null && at !== undefined && items.has(at)) {
    const found = shown.get(at);
    if (found) return found;
    at = outer(lookUp(items, at));
  }
  return null;
}

/** The part of the plane that something covers. @type {(item: Placed) => Part} */
export const areaOf = (item) =>
  "title" in item
    ? { x: item.x, y: item.y, width: item.width, height: item.height }
    : { x: item.x - item.width / 2, y: item.y - item.height / 2, width: item.width, height: item.height };
