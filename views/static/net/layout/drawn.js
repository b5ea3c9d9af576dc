// Draws the lines of arranged sheets once everything has its place, and their labels.

import { lookUp, lookUpOrAdd } from "../../maps.js";
import { captionArea, chooseCaptions } from "./captions.js";
import { borderPoint, placeLabel, routeLine } from "./lines.js";
import { OUT } from "./pieces.js";

/**
 * @import {
 *   Area, ArrangedSheet, DrawnLine, End, Line, Picture, PlacedBox, PlacedEdge, PlacedNode, Places, Plan,
 *   Point
 * } from "../types.js"
 */
/** @typedef {{ one: End, angle: number, turn: number, key: string, index: number }} Arrival */
/** @typedef {{ boxes: Map<string, PlacedBox>, nodes: Map<string, PlacedNode> }} Shapes */

const APART = 10;
const NEAR = 0.4;

/** @type {(box: PlacedBox) => Area} */
const rectangle = (box) => [box.x, box.y, box.x + box.width, box.y + box.height];
/** @type {(box: PlacedBox) => Area} */
const title = (box) => [box.x, box.y, box.x + box.header[0], box.y + box.header[1]];

/**
 * Adds the paths of lines to those that ELK found.
 *
 * @type {(picture: Picture, plan: Plan, sizes: Map<string, ArrangedSheet>, found: Places) => void}
 */
export function routeLines(picture, plan, sizes, found) {
  const nodes = new Map(picture.nodes.map((node) => [node.id, node]));
  const boxes = new Map(picture.boxes.map((box) => [box.id, box]));
  const shapes = { nodes, boxes };
  /** @type {(id: string) => Area} */
  const covers = (id) => {
    const node = nodes.get(id);
    return node ? captionArea(node) : rectangle(lookUp(boxes, id));
  };
  const lines = [...plan.sheets.values()]
    .flatMap((sheet) => sheet.lines)
    .map((line) => drawn(line, shapes, sizes, found));
  chooseCaptions(picture, plan, lines, found.paths);
  spread(lines);
  const turns = new Map();
  for (const line of lines) {
    const from = line.sourceEnd;
    const to = line.targetEnd;
    if (line.bends) {
      const last = line.bends[line.bends.length - 1];
      found.paths.set(line.id, {
        points: [borderPoint(from, line.bends[0]), ...line.bends, borderPoint(to, last)],
      });
      continue;
    }
    for (const one of [from, to])
      if (one.shift) [one.x, one.y] = [one.x + one.shift[0], one.y + one.shift[1]];
    const through = new Set(line.sheets.map((sheet) => sheet.id));
    const obstacles = line.sheets.flatMap((sheet) => [
      ...(sheet.box ? [title(lookUp(boxes, sheet.id))] : []),
      ...sheet.children
        .filter((id) => id !== line.source && id !== line.target && !through.has(id))
        .map(covers),
    ]);
    found.paths.set(line.id, { points: routeLine(from, to, obstacles, turns) });
  }
}

/** @type {(line: Line, shapes: Shapes, sizes: Map<string, ArrangedSheet>, found: Places) => DrawnLine} */
function drawn(line, shapes, sizes, found) {
  return {
    ...line,
    key: [line.source, line.target].sort().join("\n"),
    sourceEnd: end(line.source, line, shapes, found),
    targetEnd: end(line.target, line, shapes, found),
    bends: line.bent ? bends(line, shapes, sizes) : undefined,
  };
}

/**
 * Lines that come to a shape from about the same direction end next to each other, in an order that crosses
 * none.
 *
 * @type {(lines: DrawnLine[]) => void}
 */
function spread(lines) {
  /** @type {Map<NonNullable<End["item"]>, Arrival[]>} */
  const ends = new Map();
  /** @type {(line: DrawnLine, one: End, other: End, turn: number) => void} */
  const arrive = (line, one, other, turn) => {
    if (!one.item) return;
    const there = lookUpOrAdd(ends, one.item, () => []);
    const angle = Math.atan2(other.y - one.y, other.x - one.x);
    there.push({ one, angle, turn, key: line.key, index: there.length });
  };
  for (const line of lines) {
    arrive(line, line.sourceEnd, line.targetEnd, line.source < line.target ? 1 : -1);
    arrive(line, line.targetEnd, line.sourceEnd, line.target < line.source ? 1 : -1);
  }
  for (const [item, found] of ends) {
    const wide = !/^(place|transition)/.test(item.kind);
    found.sort((a, b) =>
      Math.abs(a.angle - b.angle) > 1e-6 ? a.angle - b.angle : (a.index - b.index) * a.turn,
    );
    for (let first = 0, next = 0; first < found.length; first = next) {
      for (next = first + 1; next < found.length; next += 1) {
        if (wide ? found[next].angle - found[next - 1].angle > NEAR : found[next].key !== found[first].key)
          break;
      }
      const group = found.slice(first, next);
      const angle = group.reduce((sum, one) => sum + one.angle, 0) / group.length;
      const [x, y] = [-Math.sin(angle), Math.cos(angle)];
      const room = Math.min(
        item.width / Math.max(Math.abs(x), 1e-6),
        item.height / Math.max(Math.abs(y), 1e-6),
      );
      const step = Math.min(APART, (0.75 * room) / group.length);
      group.forEach(({ one }, index) => {
        const by = (index - (group.length - 1) / 2) * step;
        one.shift = [x * by, y * by];
      });
    }
  }
}

/** @type {(line: Line, shapes: Shapes, sizes: Map<string, ArrangedSheet>) => Point[]} */
function bends(line, shapes, sizes) {
  const [sheet] = line.sheets;
  const { x, y } = sheet.id ? lookUp(shapes.boxes, sheet.id) : { x: 0, y: 0 };
  /** @type {Point[]} */
  const found = lookUp(sizes, sheet.id)
    .bent(line.edge.bends ?? [])
    .map(([bendX, bendY]) => [bendX + x, bendY + y]);
  return line.back ? found.reverse() : found;
}

/** @type {(id: string, line: Line, shapes: Shapes, found: Places) => End} */
function end(id, line, { nodes, boxes }, found) {
  const node = nodes.get(id);
  if (node) return { x: node.x, y: node.y, item: node, middle: [node.x, node.y] };
  const box = boxes.get(id);
  if (box) {
    const x = box.x + box.width / 2;
    const y = box.y + box.height / 2;
    return { x, y, item: box, middle: [x, y] };
  }
  for (const sheet of line.sheets) {
    const own = sheet.ports.find((port) => port.id === id);
    if (own) return { ...lookUp(found.ports, id), out: [-OUT[own.side][0], -OUT[own.side][1]] };
  }
  return { ...lookUp(found.ports, id), out: OUT[lookUp(found.sides, id)] };
}

/** Gives the labels of lines a place off everything else. @type {(picture: Picture, plan: Plan) => void} */
export function placeLabels(picture, plan) {
  const wanted = new Set(
    [...plan.sheets.values()]
      .flatMap((sheet) => sheet.lines)
      .filter((line) => line.labelled)
      .map((line) => line.edge.id),
  );
  /** @type {Area[]} */
  const taken = [
    ...picture.nodes.map(captionArea),
    ...picture.boxes.map((box) => (box.collapsed ? rectangle(box) : title(box))),
    ...picture.edges.flatMap(around),
    [-1e6, -1e6, 0, 1e6],
    [picture.width, -1e6, 1e6, 1e6],
    [-1e6, -1e6, 1e6, 0],
    [-1e6, picture.height, 1e6, 1e6],
  ];
  const lines = picture.edges.map((edge) => edge.points);
  for (const edge of picture.edges) {
    if (!wanted.has(edge.id)) continue;
    const [x, y] = placeLabel(edge.points, edge.room ?? [0, 0], taken, lines);
    edge.labelAt = [Math.round(x * 10) / 10, Math.round(y * 10) / 10];
    taken.push(...around(edge));
  }
}

/** The area of a label, where there is one. @type {(edge: PlacedEdge) => Area[]} */
function around({ labelAt, room: [wide, high] = [0, 0] }) {
  if (!labelAt) return [];
  const [x, y] = labelAt;
  return [[x - wide / 2, y - high / 2, x + wide / 2, y + high / 2]];
}
