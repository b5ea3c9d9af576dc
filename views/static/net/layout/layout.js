// Layout of a net view: where its boxes, nodes and edges go. Runs in browsers and, for Python, in V8.

import { lookUp } from "../../maps.js";
import { moveBlocks, portsOf, splitBlocks } from "./blocks.js";
import { placeLabels, routeLines } from "./drawn.js";
import { cutView, freeGraph, graphOf } from "./pieces.js";
import { visible } from "./shown.js";
import { placeSheet } from "./stored.js";

/**
 * @import {
 *   ArrangedSheet, Edge, Graph, LaidGraph, LoadEngine, Path, Picture, PlacedEdge, PlacedNode, Places,
 *   Plan, Point, Seated, Spot, View
 * } from "../types.js"
 */
/** @typedef {(graph: Graph) => Promise<LaidGraph>} Run */
/**
 * @typedef {object} Sheets
 * @property {Map<string, LaidGraph>} laid what ELK laid out
 * @property {Map<string, ArrangedSheet>} sizes what was arranged
 */
/** @typedef {Pick<LaidGraph, "x" | "y" | "width" | "height" | "children" | "edges" | "ports">} Laid */

/** Width by height of what people look at: a form is asked for where the picture would be a long strip. */
const SCREEN = 1.6;
const STRIP = { width: 4000, ratio: 3 };
/** Nodes of a net beyond which a second layout would take too long. */
const MOST_TRIED = 600;
/** How much smaller a folded picture must be, since its lines lead back and forth. */
const WORTH = 0.75;

/** The width of a screen that shows all of a picture. @type {(picture: Picture) => number} */
const reach = ({ width, height }) => Math.max(width, SCREEN * height);

/**
 * The visible part of a view with coordinates: in layers from left to right, or folded into several lines as
 * text is, where that makes a long strip much smaller.
 *
 * @type {(view: View, load: LoadEngine) => Promise<Picture>}
 */
export async function layout(view, load) {
  const plain = await placed(view, load);
  const isStrip = plain.width > STRIP.width && plain.width > STRIP.ratio * plain.height;
  if (view.aspect || !isStrip || plain.nodes.length > MOST_TRIED) return plain;
  const folded = await placed({ ...view, aspect: SCREEN }, load);
  return reach(folded) < WORTH * reach(plain) ? folded : plain;
}

/**
 * The visible part of a view with coordinates. Where everything was arranged, there is nothing that the
 * engine lays out.
 *
 * @type {(view: View, load: LoadEngine) => Promise<Picture>}
 */
async function placed(view, load) {
  const seen = visible(view);
  const plan = cutView(seen);
  return positioned(seen, plan, await sheetsOf(plan, async (graph) => (await load()).layout(graph)));
}

/**
 * Lays out what ELK lays out and arranges what was arranged, inner sheets first.
 *
 * @type {(plan: Plan, run: Run) => Promise<Sheets>}
 */
async function sheetsOf(plan, run) {
  /** @type {Sheets} */
  const sheets = { laid: new Map(), sizes: new Map() };
  for (const id of [...plan.order].reverse()) {
    if (lookUp(plan.sheets, id).arranged) await arrange(plan, id, sheets, run);
  }
  if (!lookUp(plan.sheets, "").arranged) sheets.laid.set("", await run(graphOf(plan, "", sheets.sizes)));
  return sheets;
}

/** @type {(plan: Plan, id: string, sheets: Sheets, run: Run) => Promise<void>} */
async function arrange(plan, id, { laid, sizes }, run) {
  const sheet = lookUp(plan.sheets, id);
  /** @type {Seated[]} */
  const items = [];
  for (const item of sheet.members) {
    const inner = plan.sheets.get(item.id);
    if (inner && !sheet.free.has(item.id) && !inner.arranged) {
      const wrapped = await run({
        id: " one",
        children: [graphOf(plan, item.id, sizes)],
        layoutOptions: { "elk.hierarchyHandling": "SEPARATE_CHILDREN" },
      });
      if (wrapped.children) laid.set(item.id, wrapped.children[0]);
    }
    const open = inner && (laid.get(item.id) ?? sizes.get(item.id));
    items.push(open ? { ...item, open: [open.width, open.height] } : item);
  }
  const free = sheet.free.size ? await run(freeGraph(plan, id, sizes)) : null;
  const { blocks, parts } = free ? splitBlocks(free, sheet.links, plan.items) : { blocks: [], parts: [] };
  const bends = sheet.lines.filter((line) => line.bent).flatMap((line) => line.edge.bends ?? []);
  const placed = placeSheet(items, sheet.box, blocks, bends);
  moveBlocks(parts, placed.at);
  sizes.set(id, { ...placed, free, ports: portsOf(sheet, placed) });
}

/** Everything's place in the picture. @type {(plan: Plan, sheets: Sheets) => Places} */
function places(plan, { laid, sizes }) {
  /** @type {Places} */
  const found = { at: new Map(), ports: new Map(), paths: new Map(), sides: new Map() };
  for (const sheet of plan.sheets.values())
    for (const port of sheet.ports) found.sides.set(port.id, port.side);
  /** @type {(id: string, x: number, y: number) => void} */
  function inside(id, x, y) {
    if (!lookUp(plan.sheets, id).arranged) {
      walk(lookUp(laid, id), x, y);
      return;
    }
    const { at, free } = lookUp(sizes, id);
    if (free) walk(free, x, y);
    for (const [child, centre] of at) {
      if (found.at.has(child)) continue;
      const { width, height } = laid.get(child) ?? sizes.get(child) ?? lookUp(plan.items, child);
      const corner = { x: centre.x - width / 2, y: centre.y - height / 2, width, height };
      put(child, { ...laid.get(child), ...corner }, x, y);
    }
  }
  /** @type {(id: string, child: Laid, x: number, y: number) => void} */
  function put(id, child, x, y) {
    const at = { x: x + child.x, y: y + child.y, width: child.width, height: child.height };
    found.at.set(id, at);
    for (const port of child.ports ?? []) found.ports.set(port.id, { x: at.x + port.x, y: at.y + port.y });
    const sheet = plan.sheets.get(id);
    if (sheet?.arranged) inside(id, at.x, at.y);
    else if (sheet) walk(child, at.x, at.y);
  }
  /** @type {(item: Laid, x: number, y: number) => void} */
  function walk(item, x, y) {
    for (const child of item.children ?? []) put(child.id, child, x, y);
    for (const edge of item.edges ?? []) {
      const section = edge.sections?.[0];
      if (!section) continue;
      const label = edge.labels?.[0];
      /** @type {(point: Spot) => Point} */
      const moved = (point) => [x + point.x, y + point.y];
      found.paths.set(edge.id, {
        points: [section.startPoint, ...(section.bendPoints ?? []), section.endPoint].map(moved),
        label: label && moved({ x: label.x + label.width / 2, y: label.y + label.height / 2 }),
      });
    }
  }
  inside("", 0, 0);
  return found;
}

/** @type {(value: number) => number} */
const round = (value) => Math.round(value * 10) / 10;

/** @type {(view: View, plan: Plan, sheets: Sheets) => Picture} */
function positioned(view, plan, sheets) {
  const found = places(plan, sheets);
  const whole = lookUp(plan.sheets, "").arranged ? lookUp(sheets.sizes, "") : lookUp(sheets.laid, "");
  const boxes = view.boxes.map((box) => {
    const { x, y, width, height } = lookUp(found.at, box.id);
    return { ...box, x: round(x), y: round(y), width: round(width), height: round(height) };
  });
  const nodes = view.nodes.map((node) => {
    const { x, y, width, height } = lookUp(found.at, node.id);
    return { ...node, x: round(x + width / 2), y: round(y + height / 2) };
  });
  const size = { width: round(whole.width), height: round(whole.height) };
  /** @type {Picture} */
  const picture = { ...view, ...size, boxes, nodes, edges: [] };
  routeLines(picture, plan, sheets.sizes, found);
  const shapes = new Map(nodes.map((node) => [node.id, node]));
  picture.edges = view.edges.map((edge) => drawn(edge, plan, found.paths, shapes));
  placeLabels(picture, plan);
  return picture;
}

/**
 * @type {(edge: Edge, plan: Plan, paths: Map<string, Path>, shapes: Map<string, PlacedNode>) => PlacedEdge}
 */
function drawn(edge, plan, paths, shapes) {
  const { pieces, back } = lookUp(plan.chains, edge.id);
  /** @type {Point[]} */
  const course = [];
  /** @type {Point | undefined} */
  let label;
  for (const { id, flip } of pieces) {
    const path = paths.get(id);
    if (!path) continue;
    course.push(...(flip ? [...path.points].reverse() : path.points));
    label ??= path.label;
  }
  if (back) course.reverse();
  const points = simplified(course);
  meetShape(points, shapes.get(edge.source), true);
  meetShape(points, shapes.get(edge.target), false);
  /** @type {PlacedEdge} */
  const made = { ...edge, points: points.map(([x, y]) => [round(x), round(y)]) };
  if (label) made.labelAt = [round(label[0]), round(label[1])];
  return made;
}

/** Without points on the way from one to the next. @type {(points: Point[]) => Point[]} */
function simplified(points) {
  /** @type {Point[]} */
  const kept = [];
  for (const point of points) {
    const last = kept[kept.length - 1];
    const before = kept[kept.length - 2];
    if (last && Math.abs(last[0] - point[0]) < 0.05 && Math.abs(last[1] - point[1]) < 0.05) continue;
    /** @type {(axis: 0 | 1) => boolean} */
    const along = (axis) =>
      before && Math.abs(before[axis] - last[axis]) < 0.05 && Math.abs(last[axis] - point[axis]) < 0.05;
    /** @type {(axis: 0 | 1) => boolean} */
    const turns = (axis) => (point[axis] - last[axis]) * (last[axis] - before[axis]) < 0;
    if ((along(0) && !turns(1)) || (along(1) && !turns(0))) kept.pop();
    kept.push(point);
  }
  return kept;
}

/**
 * The router ends lines at the square around a circle; they continue to the circle.
 *
 * @type {(points: Point[], node: PlacedNode | undefined, first: boolean) => void}
 */
function meetShape(points, node, first) {
  if (!node || !/^place/.test(node.kind) || points.length < 2) return;
  const end = first ? 0 : points.length - 1;
  const point = points[end];
  const radius = node.width / 2;
  const next = points[first ? 1 : end - 1];
  const flat = Math.abs(point[1] - next[1]) <= Math.abs(point[0] - next[0]);
  const off = Math.min(Math.abs(flat ? point[1] - node.y : point[0] - node.x), radius * 0.95);
  const reach = Math.sqrt(radius * radius - off * off);
  points[end] = flat
    ? [node.x + Math.sign(point[0] - node.x) * reach, point[1]]
    : [point[0], node.y + Math.sign(point[1] - node.y) * reach];
}
