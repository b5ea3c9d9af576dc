// What is shown of a net: collapsed boxes hide what is in them, and a neighbourhood all else.
// `around` of `dineros.views.nets` does the same for Python's views: a test compares.

import { lookUp } from "../../maps.js";

/** @import { Edge, View } from "../types.js" */

/** What is left when collapsed boxes hide their content. @type {(view: View) => View} */
export function visible(view) {
  const boxes = new Map(view.boxes.map((box) => [box.id, box]));
  /** @type {Map<string, string | null>} */
  const known = new Map();
  /**
   * The outermost collapsed box around a box, itself included.
   *
   * @type {(id: string | null | undefined) => string | null}
   */
  const standIn = (id) => {
    if (id === undefined || id === null) return null;
    const before = known.get(id);
    if (before !== undefined) return before;
    const box = lookUp(boxes, id);
    const found = standIn(box.parent) ?? (box.collapsed ? id : null);
    known.set(id, found);
    return found;
  };
  const home = new Map(view.nodes.map((node) => [node.id, standIn(node.box) ?? node.id]));
  return {
    ...view,
    boxes: view.boxes.filter((box) => standIn(box.parent) === null),
    nodes: view.nodes.filter((node) => standIn(node.box) === null),
    edges: merged(view.edges, home),
  };
}

/**
 * Edges between what is shown: of one kind to the same collapsed box, they are one.
 *
 * @type {(edges: Edge[], home: Map<string, string>) => Edge[]}
 */
function merged(edges, home) {
  /** @type {Edge[]} */
  const found = [];
  /** @type {Map<string, Edge & { stands: string[] }>} */
  const known = new Map();
  for (const edge of edges) {
    const source = home.get(edge.source);
    const target = home.get(edge.target);
    if (source === undefined || target === undefined) continue;
    if (source === edge.source && target === edge.target) {
      found.push(edge);
      continue;
    }
    if (source === target) continue;
    const key = JSON.stringify([edge.kind, source, target, edge.change ?? ""]);
    const before = known.get(key);
    if (before) {
      before.stands.push(edge.id);
      if (before.label !== edge.label) {
        before.label = "";
        before.room = [0, 0];
      }
      continue;
    }
    const { bends: _, ...straight } = edge;
    const made = { ...straight, source, target, stands: [edge.id] };
    known.set(key, made);
    found.push(made);
  }
  return found;
}

/**
 * The part of a view that is at most some steps away from some nodes, boxes or edges.
 *
 * @type {(view: View, ids: string[], steps: number) => View}
 */
export function around(view, ids, steps) {
  /** @type {Map<string, string[]>} */
  const neighbours = new Map(view.nodes.map((node) => [node.id, []]));
  for (const { source, target } of view.edges) {
    if (!neighbours.has(source) || !neighbours.has(target)) continue;
    lookUp(neighbours, source).push(target);
    lookUp(neighbours, target).push(source);
  }
  let border = ids.flatMap((id) => nodesOf(view, id));
  const kept = new Set(border);
  for (let step = 0; step < steps; step += 1) {
    const next = new Set(border.flatMap((id) => lookUp(neighbours, id)));
    border = [...next].filter((id) => !kept.has(id));
    for (const id of border) kept.add(id);
  }
  const parents = new Map(view.boxes.map((box) => [box.id, box.parent]));
  const needed = new Set();
  const nodes = view.nodes.filter((node) => kept.has(node.id));
  for (const node of nodes) {
    for (let box = node.box; box !== undefined && box !== null && !needed.has(box); box = parents.get(box))
      needed.add(box);
  }
  const boxes = view.boxes.filter((box) => needed.has(box.id)).map(({ collapsed: _, ...open }) => open);
  const edges = view.edges.filter((edge) => kept.has(edge.source) && kept.has(edge.target));
  return { ...view, boxes, nodes, edges };
}

/** A node itself, the nodes in a box, or the ends of an edge. @type {(view: View, id: string) => string[]} */
function nodesOf(view, id) {
  if (view.nodes.some((node) => node.id === id)) return [id];
  if (view.boxes.some((box) => box.id === id)) {
    const inside = new Set([id]);
    for (const box of view.boxes) if (inside.has(box.parent ?? "")) inside.add(box.id);
    return view.nodes.filter((node) => inside.has(node.box ?? "")).map((node) => node.id);
  }
  const edge = view.edges.find((item) => item.id === id || item.also === id);
  return edge ? [edge.source, edge.target] : [];
}
