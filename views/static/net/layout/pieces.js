// Cuts the edges of a net view at the borders of its open boxes, each of which is laid out on its own; and
// makes the graphs that ELK lays out. Between two sheets that were arranged a line is not cut: it runs
// straight on.

import { lookUp } from "../../maps.js";
import { endsOf, leadsBack, nesting, orderOf } from "./order.js";
import { isArranged, kept } from "./stored.js";

/**
 * @import {
 *   ArrangedSheet, Box, Chain, Edge, Graph, GraphEdge, Item, Line, Plan, Point, Sheet, Side, View
 * } from "../types.js"
 */
/**
 * @typedef {object} Step
 * @property {Sheet} sheet
 * @property {string} item on the way of an edge
 * @property {string} [other] the other item of the sheet on which both ends are
 */
/**
 * @typedef {object} Cutting
 * @property {Map<string, string[]>} around
 * @property {Set<string>} turned
 * @property {Map<string, Sheet>} sheets
 * @property {Map<string, Item>} items
 */
/** @typedef {Graph & Required<Pick<Graph, "children" | "edges" | "ports" | "layoutOptions">>} Frame */

const SPACE = { node: 22, layer: 34, edge: 9 };
// What makes small pictures read in the order of the model takes minutes for large ones.
const MANY = 150;
const SMALL = {
  "elk.layered.nodePlacement.strategy": "NETWORK_SIMPLEX",
  "elk.layered.considerModelOrder.strategy": "PREFER_NODES",
  "elk.layered.considerModelOrder.crossingCounterNodeInfluence": "0.1",
  "elk.layered.considerModelOrder.components": "MODEL_ORDER",
};
const LARGE = { "elk.layered.nodePlacement.strategy": "BRANDES_KOEPF" };
const OPTIONS = {
  "elk.algorithm": "layered",
  "elk.direction": "RIGHT",
  "elk.edgeRouting": "ORTHOGONAL",
  "elk.hierarchyHandling": "SEPARATE_CHILDREN",
  "elk.layered.cycleBreaking.strategy": "MODEL_ORDER",
  "elk.layered.nodePlacement.favorStraightEdges": "true",
  "elk.layered.spacing.nodeNodeBetweenLayers": String(SPACE.layer),
  "elk.layered.spacing.edgeNodeBetweenLayers": "14",
  "elk.layered.spacing.edgeEdgeBetweenLayers": String(SPACE.edge),
  "elk.spacing.nodeNode": String(SPACE.node),
  "elk.spacing.edgeNode": "12",
  "elk.spacing.edgeEdge": String(SPACE.edge),
  "elk.spacing.edgeLabel": "2",
  "elk.spacing.componentComponent": "22",
  "elk.spacing.portPort": "12",
  "elk.spacing.labelNode": "0",
  "elk.randomSeed": "1",
};
/** The directions that lead out of a box. @type {Record<Side, Point>} */
export const OUT = { WEST: [-1, 0], EAST: [1, 0], NORTH: [0, -1], SOUTH: [0, 1] };

/** The sheets of a view, and the pieces of its edges. @type {(view: View) => Plan} */
export function cutView(view) {
  const around = nesting(view);
  const { children, turned } = orderOf(view, around);
  /** @type {Item[]} */
  const all = [...view.boxes, ...view.nodes];
  const items = new Map(all.map((item) => [item.id, item]));
  const rank = new Map(all.map((item, index) => [item.id, index]));
  const boxes = new Map(view.boxes.map((box) => [box.id, box]));
  /** @type {Map<string, Sheet>} */
  const sheets = new Map();
  for (const [id, inner] of children) {
    const box = boxes.get(id);
    const members = [...inner]
      .sort((a, b) => lookUp(rank, a) - lookUp(rank, b))
      .map((child) => lookUp(items, child));
    const arranged = isArranged(members, box);
    const free = new Set(inner);
    if (arranged) for (const item of kept(members)) free.delete(item.id);
    sheets.set(id, {
      id,
      box,
      children: inner,
      members,
      arranged,
      free,
      ports: [],
      edges: [],
      lines: [],
      links: [],
    });
  }
  const cutting = { around, turned, sheets, items };
  const chains = new Map(view.edges.map((edge, number) => [edge.id, chain(edge, number, cutting)]));
  return {
    sheets,
    items,
    chains,
    order: ["", ...view.boxes.filter((box) => !box.collapsed).map((box) => box.id)],
    large: view.nodes.length > MANY,
    aspect: view.aspect,
  };
}

/**
 * The pieces of an edge.
 *
 * @type {(edge: Edge, number: number, cutting: Cutting) => Chain}
 */
function chain(edge, number, { around, turned, sheets, items }) {
  const { depth, from, to } = endsOf(edge, around);
  const back = leadsBack(edge.kind) !== turned.has(edge.id);
  const start = back ? to : from;
  const end = back ? from : to;
  /** @type {(path: string[], level: number) => Sheet} */
  const sheetAt = (path, level) => lookUp(sheets, level ? path[level - 1] : "");
  /** @type {Step[]} */
  const steps = [];
  for (let level = start.length - 1; level > depth; level -= 1)
    steps.push({ sheet: sheetAt(start, level), item: start[level] });
  const middle = steps.length;
  steps.push({ sheet: sheetAt(start, depth), item: start[depth], other: end[depth] });
  for (let level = depth + 1; level < end.length; level += 1)
    steps.push({ sheet: sheetAt(end, level), item: end[level] });
  /** @type {{ id: string, flip: boolean }[]} */
  const pieces = [];
  let point = start[start.length - 1];
  let first = 0;
  /** @type {(target: string, last: number) => void} */
  const close = (target, last) => {
    const id = `edge ${number} ${pieces.length}`;
    const labelled = first <= middle && middle <= last && Boolean(edge.label);
    const piece = { id, edge, back, source: point, target, labelled };
    pieces.push({ id, flip: add(piece, steps.slice(first, last + 1)) });
  };
  for (let index = 0; index + 1 < steps.length; index += 1) {
    const out = index < middle;
    const [inner, outer] = out ? [steps[index], steps[index + 1]] : [steps[index + 1], steps[index]];
    if (inner.sheet.arranged && outer.sheet.arranged) continue;
    const id = `port ${number} ${index}`;
    const beyond = outer.other && (out ? outer.other : outer.item);
    const side =
      (outer.sheet.arranged && beyond && direction(lookUp(items, inner.sheet.id), lookUp(items, beyond))) ||
      (out ? "EAST" : "WEST");
    inner.sheet.ports.push({ id, side, via: inner.item });
    close(id, index);
    [point, first] = [id, index + 1];
  }
  close(end[end.length - 1], steps.length - 1);
  return { pieces, back };
}

/**
 * Hands a piece to its sheet; returns whether ELK gets it turned round.
 *
 * @type {(piece: Omit<Line, "sheets" | "bent">, steps: Step[]) => boolean}
 */
function add(piece, steps) {
  const { id, edge, source, target, labelled } = piece;
  const [{ sheet, item, other }] = steps;
  const alone = steps.length === 1;
  const together = alone && other !== undefined && sheet.free.has(item) && sheet.free.has(other);
  const byElk = alone && (!sheet.arranged || together);
  if (!byElk) {
    const outermost = steps.find((step) => step.other) || steps[0];
    outermost.sheet.lines.push({
      ...piece,
      sheets: steps.map((step) => step.sheet),
      bent: Boolean(alone && other && edge.bends && !sheet.free.has(item) && !sheet.free.has(other)),
    });
    if (outermost.other) outermost.sheet.links.push([outermost.item, outermost.other, id]);
    return false;
  }
  // A line that leaves to the left, or enters from the right, is laid out from there.
  /** @type {(port: string) => Side | undefined} */
  const side = (port) => sheet.ports.find((found) => found.id === port)?.side;
  const flip = side(target) === "WEST" || side(source) === "EAST";
  /** @type {GraphEdge} */
  const made = { id, sources: [flip ? target : source], targets: [flip ? source : target] };
  if (labelled) {
    const [width, height] = edge.room ?? [0, 0];
    made.labels = [{ id: `${id} label`, text: edge.label ?? "", width, height }];
    made.layoutOptions = { "elk.edgeLabels.placement": "CENTER" };
  }
  sheet.edges.push(made);
  if (together) sheet.links.push([item, other, id]);
  return flip;
}

/**
 * The side of a box that faces another item of an arranged sheet.
 *
 * @type {(box: Item, other: Item) => Side | null}
 */
function direction(box, other) {
  if (!box.position || !other.position) return null;
  const dx = other.position[0] - box.position[0];
  const dy = other.position[1] - box.position[1];
  if (Math.abs(dx) * 2 < Math.abs(dy)) return dy < 0 ? "NORTH" : "SOUTH";
  return dx < 0 ? "WEST" : "EAST";
}

/**
 * The graph of a sheet that ELK lays out, and of what is in it. `sizes` tells those of arranged sheets in it.
 *
 * @type {(plan: Plan, id: string, sizes: Map<string, ArrangedSheet>) => Graph}
 */
export function graphOf(plan, id, sizes) {
  const sheet = lookUp(plan.sheets, id);
  const box = sheet.box;
  const made = frame(plan, id || " root", box);
  made.children = sheet.children.map((child) => inner(plan, child, sizes));
  made.edges = sheet.edges;
  made.ports = sheet.ports.map((port) => ({
    id: port.id,
    width: 0,
    height: 0,
    layoutOptions: { "elk.port.side": port.side },
  }));
  if (box) {
    made.layoutOptions["elk.portConstraints"] = "FIXED_SIDE";
    made.layoutOptions["elk.nodeSize.constraints"] = "MINIMUM_SIZE PORTS";
    made.layoutOptions["elk.nodeSize.minimum"] = `(${box.header[0] + 8},${box.header[1] + 20})`;
  }
  return made;
}

/**
 * The graph of those items of an arranged sheet that have no position.
 *
 * @type {(plan: Plan, id: string, sizes: Map<string, ArrangedSheet>) => Graph}
 */
export function freeGraph(plan, id, sizes) {
  const sheet = lookUp(plan.sheets, id);
  const made = frame(plan, " free", undefined);
  made.layoutOptions["elk.padding"] = "[top=0,left=0,bottom=0,right=0]";
  made.children = sheet.children
    .filter((child) => sheet.free.has(child))
    .map((child) => inner(plan, child, sizes));
  // Items whose line is not laid out are to stand near each other nevertheless.
  const known = new Set(sheet.edges.map(({ id: edge }) => edge));
  const near = sheet.links.filter(
    ([one, other, edge]) => !known.has(edge) && one !== other && sheet.free.has(one) && sheet.free.has(other),
  );
  made.edges = [...sheet.edges];
  near.forEach(([one, other], index) => {
    made.edges.push({ id: ` near ${index}`, sources: [one], targets: [other] });
  });
  return made;
}

/** Several lines, as of text, where a form is asked for. @type {(plan: Plan) => Record<string, string>} */
function wrapping({ aspect }) {
  if (!aspect) return {};
  return { "elk.layered.wrapping.strategy": "MULTI_EDGE", "elk.aspectRatio": String(aspect) };
}

/** @type {(plan: Plan, id: string, box: Box | undefined) => Frame} */
function frame(plan, id, box) {
  const padding = box
    ? `[top=${box.header[1] + 10},left=16,bottom=14,right=16]`
    : "[top=16,left=16,bottom=16,right=16]";
  return {
    id,
    children: [],
    edges: [],
    ports: [],
    layoutOptions: { ...OPTIONS, ...(plan.large ? LARGE : SMALL), ...wrapping(plan), "elk.padding": padding },
  };
}

/** @type {(plan: Plan, id: string, sizes: Map<string, ArrangedSheet>) => Graph} */
function inner(plan, id, sizes) {
  const sheet = plan.sheets.get(id);
  if (!sheet) return leaf(lookUp(plan.items, id));
  if (!sheet.arranged) return graphOf(plan, id, sizes);
  const { width, height, ports } = lookUp(sizes, id);
  const fixed = ports.map(({ id: port, side, x, y }) => ({
    id: port,
    x,
    y,
    width: 0,
    height: 0,
    layoutOptions: { "elk.port.side": side },
  }));
  return { id, width, height, ports: fixed, layoutOptions: { "elk.portConstraints": "FIXED_POS" } };
}

/** @type {(item: Item) => Graph} */
function leaf(item) {
  /** @type {Graph} */
  const made = { id: item.id, width: item.width, height: item.height };
  if (item.room?.[0]) {
    made.labels = [{ id: `${item.id} label`, text: " ", width: item.room[0], height: item.room[1] }];
    made.layoutOptions = { "elk.nodeLabels.placement": "OUTSIDE V_BOTTOM H_CENTER" };
  }
  return made;
}
