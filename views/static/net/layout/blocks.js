// What has no position on a sheet that was arranged: ELK lays it out, then each group that hangs together is
// put in one piece next to the rest.

import { lookUp, lookUpOrAdd } from "../../maps.js";

/**
 * @import {
 *   ArrangedSheet, Block, Item, LaidEdge, LaidGraph, Link, Part, PlacedSheet, Point, Sheet, Side, Spot
 * } from "../types.js"
 */

const APART = 9;

/**
 * The groups of a graph that ELK laid out, for `placeSheet`, and what is in them.
 *
 * @type {(laid: LaidGraph, links: Link[], items: Map<string, Item>) => { blocks: Block[], parts: Part[] }}
 */
export function splitBlocks(laid, links, items) {
  const laidItems = laid.children ?? [];
  const group = new Map(laidItems.map((child) => [child.id, child.id]));
  /** @type {(id: string) => string} */
  const root = (id) => (group.get(id) === id ? id : root(lookUp(group, id)));
  for (const [one, other] of links) if (group.has(one) && group.has(other)) group.set(root(one), root(other));
  /** @type {Map<string, Part>} */
  const parts = new Map();
  /** @type {Map<string, string>} */
  const owner = new Map();
  for (const child of laidItems) {
    lookUpOrAdd(parts, root(child.id), () => ({ children: [], edges: [] })).children.push(child);
    for (const { id } of [child, ...(child.ports ?? [])]) owner.set(id, child.id);
  }
  for (const edge of laid.edges ?? []) lookUp(parts, root(lookUp(owner, edge.sources[0]))).edges.push(edge);
  return { blocks: [...parts.values()].map((part) => block(part, links, items)), parts: [...parts.values()] };
}

/** @type {(part: Part, links: Link[], items: Map<string, Item>) => Block} */
function block(part, links, items) {
  const points = part.edges.filter((edge) => !edge.id.startsWith(" ")).flatMap(corners);
  for (const child of part.children) {
    const [wide, down] = lookUp(items, child.id).room ?? [0, 0];
    const middle = child.x + child.width / 2;
    const side = Math.max(child.width, child.ports ? 0 : wide) / 2;
    points.push([middle - side, child.y], [middle + side, child.y + child.height + (child.ports ? 0 : down)]);
  }
  const left = Math.min(...points.map(([x]) => x));
  const top = Math.min(...points.map(([, y]) => y));
  const ids = new Set(part.children.map(({ id }) => id));
  const single = part.children.length === 1 && lookUp(items, part.children[0].id).position;
  return {
    width: Math.max(...points.map(([x]) => x)) - left,
    height: Math.max(...points.map(([, y]) => y)) - top,
    near: links.flatMap(([one, other]) =>
      ids.has(one) === ids.has(other) ? [] : [ids.has(one) ? other : one],
    ),
    anchor: single || null,
    parts: part.children.map((child) => ({
      item: lookUp(items, child.id),
      x: child.x + child.width / 2 - left,
      y: child.y + child.height / 2 - top,
    })),
  };
}

/** The points a line has been given. @type {(edge: LaidEdge) => Spot[]} */
const course = (edge) =>
  (edge.sections ?? []).flatMap((section) => [
    section.startPoint,
    ...(section.bendPoints ?? []),
    section.endPoint,
  ]);

/** @type {(edge: LaidEdge) => Point[]} */
function corners(edge) {
  /** @type {Point[]} */
  const points = course(edge).map(({ x, y }) => [x, y]);
  for (const label of edge.labels ?? [])
    points.push([label.x, label.y], [label.x + label.width, label.y + label.height]);
  return points;
}

/**
 * Moves the content of the groups to where their items were put.
 *
 * @type {(parts: Part[], at: Map<string, Spot>) => void}
 */
export function moveBlocks(parts, at) {
  for (const { children, edges } of parts) {
    const [first] = children;
    const centre = lookUp(at, first.id);
    const dx = centre.x - first.x - first.width / 2;
    const dy = centre.y - first.y - first.height / 2;
    const points = edges.flatMap((edge) => [...(edge.labels ?? []), ...course(edge)]);
    for (const one of [...children, ...points]) {
      one.x += dx;
      one.y += dy;
    }
  }
}

/**
 * The ports of a sheet, as high as what they lead to.
 *
 * @type {(sheet: Sheet, placed: PlacedSheet) => ArrangedSheet["ports"]}
 */
export function portsOf(sheet, placed) {
  /** @type {ArrangedSheet["ports"]} */
  const made = [];
  for (const side of /** @type {Side[]} */ (["WEST", "EAST"])) {
    const wanted = sheet.ports
      .filter((port) => port.side === side)
      .map((port) => ({ port, y: lookUp(placed.at, port.via).y }))
      .sort((a, b) => a.y - b.y);
    let above = -Infinity;
    for (const { y, port } of wanted) {
      above = Math.max(y, above + APART);
      made.push({ id: port.id, side, x: side === "WEST" ? 0 : placed.width, y: above });
    }
  }
  return made;
}
