// The order in which a net is laid out, and which of its lines lead backwards.

import { lookUp, lookUpOrAdd } from "../../maps.js";

/** @import { Edge, EdgeKind, View } from "../types.js" */
/** @typedef {Map<string, string[]>} Nesting  the boxes around each box and node, from outside inwards */
/** @typedef {[one: string, other: string, edge: string | null]} OrderLink */

/**
 * Whether lines are laid out against their direction: a client's response comes back the way the request
 * went.
 *
 * @type {(kind: EdgeKind) => boolean}
 */
export const leadsBack = (kind) => kind === "response" || kind === "return";

/** The boxes around each item. @type {(view: View) => Nesting} */
export function nesting(view) {
  const parents = new Map(view.boxes.map((box) => [box.id, box.parent]));
  /** @type {Nesting} */
  const paths = new Map();
  /** @type {(id: string | null | undefined) => string[]} */
  const path = (id) =>
    id === null || id === undefined ? [] : lookUpOrAdd(paths, id, () => [...path(parents.get(id)), id]);
  return new Map([
    ...view.boxes.map((box) => /** @type {const} */ ([box.id, path(box.parent)])),
    ...view.nodes.map((node) => /** @type {const} */ ([node.id, path(node.box)])),
  ]);
}

/**
 * What an edge joins: `from` and `to` are its ends with the boxes around them, which are apart from `depth`
 * inwards.
 *
 * @type {(edge: Pick<Edge, "source" | "target">, around: Nesting) => { depth: number, from: string[], to: string[] }}
 */
export function endsOf(edge, around) {
  const from = [...lookUp(around, edge.source), edge.source];
  const to = [...lookUp(around, edge.target), edge.target];
  let depth = 0;
  while (depth < from.length - 1 && depth < to.length - 1 && from[depth] === to[depth]) depth += 1;
  return { depth, from, to };
}

/**
 * The children of each box ("" is the whole) in the order they are met from where tokens are, and the edges
 * to turn round.
 *
 * @type {(view: View, around: Nesting) => { children: Map<string, string[]>, turned: Set<string> }}
 */
export function orderOf(view, around) {
  /** @type {Map<string, string[]>} */
  const children = new Map([["", []]]);
  const marked = new Set();
  for (const box of view.boxes) if (!box.collapsed) children.set(box.id, []);
  for (const item of [...view.boxes, ...view.nodes]) {
    const boxes = lookUp(around, item.id);
    lookUp(children, boxes[boxes.length - 1] ?? "").push(item.id);
    if (item.tokens) for (const id of [...boxes, item.id]) marked.add(id);
  }
  const links = linksOf(view, around, [...children.keys()]);
  /** @type {Set<string>} */
  const turned = new Set();
  for (const [container, ids] of children) {
    const own = lookUp(links, container);
    sortBy(ids, walk(ids, own, marked, turned), own, turned);
  }
  return { children, turned };
}

/**
 * What is joined among the children of each container.
 *
 * @type {(view: View, around: Nesting, containers: string[]) => Map<string, OrderLink[]>}
 */
function linksOf(view, around, containers) {
  /** @type {Map<string, OrderLink[]>} */
  const links = new Map(containers.map((id) => [id, []]));
  /** @type {(container: string | undefined, link: OrderLink) => void} */
  const add = (container = "", link) => {
    if (link[0] !== link[1]) lookUp(links, container).push(link);
  };
  for (const edge of view.edges) {
    const { depth, from, to } = endsOf(edge, around);
    const [one, other] = leadsBack(edge.kind) ? [to[depth], from[depth]] : [from[depth], to[depth]];
    add(from[depth - 1], [one, other, edge.id]);
  }
  // A client continues from its request to its response; this orders, but is not a line.
  /** @type {Map<string, string>} */
  const waiting = new Map();
  for (const edge of view.edges) {
    const client = JSON.stringify([edge.label, edge.kind === "request" ? edge.target : edge.source]);
    const source = waiting.get(client);
    if (edge.kind === "request") waiting.set(client, edge.source);
    else if (edge.kind === "response" && source !== undefined) {
      const { depth, from, to } = endsOf({ source, target: edge.target }, around);
      add(from[depth - 1], [from[depth], to[depth], null]);
    }
  }
  return links;
}

/**
 * Children in the order they are met, depth first; edges that lead back to where the walk is are to be turned
 * round.
 *
 * @type {(ids: string[], links: OrderLink[], marked: Set<string>, turned: Set<string>) => string[]}
 */
function walk(ids, links, marked, turned) {
  /** @type {Map<string, { other: string, edge: string | null }[]>} */
  const next = new Map(ids.map((id) => [id, []]));
  const entered = new Set(links.map(([, other]) => other));
  for (const [one, other, edge] of links) lookUp(next, one).push({ other, edge });
  const starts = [
    ...ids.filter((id) => !entered.has(id) && lookUp(next, id).length),
    ...ids.filter((id) => marked.has(id)),
    ...ids,
  ];
  /** @type {Map<string, "open" | "done">} */
  const state = new Map();
  /** @type {string[]} */
  const met = [];
  for (const start of starts) {
    if (state.has(start)) continue;
    const stack = [{ id: start, index: 0 }];
    state.set(start, "open");
    met.push(start);
    while (stack.length) {
      const top = stack[stack.length - 1];
      const found = lookUp(next, top.id)[top.index];
      if (!found) {
        state.set(top.id, "done");
        stack.pop();
        continue;
      }
      top.index += 1;
      const { other, edge } = found;
      if (state.get(other) === "open") {
        if (edge !== null) turned.add(edge);
      } else if (!state.has(other)) {
        state.set(other, "open");
        met.push(other);
        stack.push({ id: other, index: 0 });
      }
    }
  }
  return met;
}

/**
 * Sorts so that all edges, turned round or not, lead onwards; otherwise in the order things were met.
 *
 * @type {(ids: string[], met: string[], links: OrderLink[], turned: Set<string>) => void}
 */
function sortBy(ids, met, links, turned) {
  const rank = new Map(met.map((id, index) => [id, index]));
  /** @type {Map<string, string[]>} */
  const next = new Map(ids.map((id) => [id, []]));
  const waits = new Map(ids.map((id) => [id, 0]));
  for (const [one, other, edge] of links) {
    if (edge === null) continue;
    const [first, second] = turned.has(edge) ? [other, one] : [one, other];
    lookUp(next, first).push(second);
    waits.set(second, lookUp(waits, second) + 1);
  }
  const free = ids.filter((id) => !waits.get(id));
  const sorted = [];
  while (free.length) {
    let best = 0;
    for (let index = 1; index < free.length; index += 1)
      if (lookUp(rank, free[index]) < lookUp(rank, free[best])) best = index;
    const [id] = free.splice(best, 1);
    sorted.push(id);
    for (const other of lookUp(next, id)) {
      waits.set(other, lookUp(waits, other) - 1);
      if (!waits.get(other)) free.push(other);
    }
  }
  ids.splice(0, ids.length, ...sorted);
}
