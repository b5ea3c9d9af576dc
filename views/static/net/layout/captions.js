// The captions of arranged nodes: below them as everywhere else, unless their own lines go through there and
// another side is free.

import { lookUp } from "../../maps.js";
import { crosses } from "./lines.js";

/** @import { Area, DrawnLine, Path, Picture, PlacedNode, Plan, Point, Size } from "../types.js" */
/** @typedef {"below" | "above" | "right" | "left" | "below right" | "below left" | "above right" | "above left"} CaptionSide */
/** @typedef {Pick<DrawnLine, "source" | "target"> & { points: Point[] }} Course */
/** @typedef {PlacedNode & { room: Size }} Captioned */

const OWN = 10;
const OTHER = 3;
/** How much worse each side is than the one before. */
const LATER = 0.6;
/** How far a caption's room reaches beyond its letters. */
const LOOSE = 2;
/** @type {CaptionSide[]} */
const SIDES = ["below", "above", "right", "left", "below right", "below left", "above right", "above left"];

/**
 * @param {PlacedNode} node
 * @returns {node is Captioned}
 */
const isCaptioned = (node) => Boolean(node.room?.[0]);

/** @type {(node: Captioned, at: Point) => Area} */
function caption(node, [dx, dy]) {
  const [wide, down] = node.room;
  const top = node.y + node.height / 2 + dy;
  return [node.x + dx - wide / 2, top, node.x + dx + wide / 2, top + down];
}

/** The rectangle around a node and its captions. @type {(node: PlacedNode) => Area} */
export const captionArea = (node) => around(node, node.captionAt ?? [0, 0]);

/** @type {(node: PlacedNode, at: Point) => Area} */
function around(node, at) {
  /** @type {Area} */
  const shape = [
    node.x - node.width / 2,
    node.y - node.height / 2,
    node.x + node.width / 2,
    node.y + node.height / 2,
  ];
  if (!isCaptioned(node)) return shape;
  const text = caption(node, at);
  return [
    Math.min(shape[0], text[0]),
    Math.min(shape[1], text[1]),
    Math.max(shape[2], text[2]),
    Math.max(shape[3], text[3]),
  ];
}

/** @type {(node: Captioned, side: CaptionSide) => Point} */
function shift(node, side) {
  const [wide, down] = node.room;
  const middle = -(node.height + down) / 2 - 1;
  const aside = (node.width + wide) / 2 + 1;
  const up = -node.height - down - 2;
  const along = (wide - node.width) / 2 - LOOSE; // from the edge of the shape on
  /** @type {Record<CaptionSide, Point>} */
  const shifts = {
    below: [0, 0],
    above: [0, up],
    right: [aside, middle],
    left: [-aside, middle],
    "below right": [along, 0],
    "below left": [-along, 0],
    "above right": [along, up],
    "above left": [-along, up],
  };
  return shifts[side];
}

/** @type {(room: Area) => Area} */
const letters = ([left, top, right, bottom]) => [left + LOOSE, top + LOOSE, right - LOOSE, bottom - LOOSE];

/** @type {(one: Area, other: Area) => boolean} */
const meet = (one, other) => one[0] < other[2] && other[0] < one[2] && one[1] < other[3] && other[1] < one[3];

/**
 * Moves captions: gives nodes `captionAt`, by how much, and a new glyph.
 *
 * @type {(picture: Picture, plan: Plan, lines: DrawnLine[], paths: Map<string, Path>) => void}
 */
export function chooseCaptions(picture, plan, lines, paths) {
  const nodes = new Map(picture.nodes.map((node) => [node.id, node]));
  /** @type {Map<string, Area>} */
  const boxes = new Map(
    picture.boxes.map((box) => [box.id, [box.x, box.y, box.x + box.width, box.y + box.height]]),
  );
  for (const sheet of plan.sheets.values()) {
    if (!sheet.arranged) continue;
    /** @type {Area} */
    const frame = sheet.box ? lookUp(boxes, sheet.id) : [0, 0, picture.width, picture.height];
    /** @type {Area[]} */
    const title = sheet.box
      ? [[frame[0], frame[1], frame[0] + sheet.box.header[0], frame[1] + sheet.box.header[1]]]
      : [];
    /** @type {Course[]} */
    const near = [
      ...lines.filter((line) => line.sheets.includes(sheet)).map(course),
      ...sheet.edges.map(({ id, sources: [source], targets: [target] }) => ({
        source,
        target,
        points: lookUp(paths, id).points,
      })),
    ];
    for (const { id } of sheet.members) {
      const node = nodes.get(id);
      if (!node || !isCaptioned(node)) continue;
      const others = [
        ...title,
        ...sheet.members
          .filter((other) => other.id !== id)
          .map((other) => boxes.get(other.id) ?? captionArea(lookUp(nodes, other.id))),
      ];
      /** @type {(side: CaptionSide, rank: number) => number} */
      const cost = (side, rank) => {
        const text = letters(caption(node, shift(node, side)));
        const all = around(node, shift(node, side));
        const marked = (node.change || node.badge) && /above|^left/.test(side);
        const within = text[0] > frame[0] && text[1] > frame[1] && text[2] < frame[2] && text[3] < frame[3];
        if (rank && (marked || !within || others.some((other) => meet(all, other)))) return Infinity;
        return near.reduce(
          (sum, line) =>
            sum + (passes(line, text) ? (line.source === id || line.target === id ? OWN : OTHER) : 0),
          rank * LATER,
        );
      };
      const costs = SIDES.map(cost);
      const best = costs.indexOf(Math.min(...costs));
      if (best > 0 && costs[0] - costs[best] >= OWN / 2) move(node, shift(node, SIDES[best]));
    }
  }
}

/** A line as if it ran straight from end to end, or by its bends. @type {(line: DrawnLine) => Course} */
function course({ source, target, sourceEnd, targetEnd, bends }) {
  return {
    source,
    target,
    points: [[sourceEnd.x, sourceEnd.y], ...(bends ?? []), [targetEnd.x, targetEnd.y]],
  };
}

/** Whether a line goes through an area. @type {(line: Course, text: Area) => boolean} */
const passes = ({ points }, text) =>
  points.some((point, index) => index > 0 && crosses(points[index - 1], point, text));

/** @type {(node: PlacedNode, by: Point) => void} */
function move(node, [dx, dy]) {
  /** @type {(value: number) => number} */
  const number = (value) => Math.round(value * 10) / 10;
  node.captionAt = [number(dx), number(dy)];
  node.glyph = node.glyph.replace(
    /(<text class="[a-z]+") y="([-\d.]+)"/g,
    (_, start, y) => `${start}${dx ? ` x="${number(dx)}"` : ""} y="${number(Number(y) + dy)}"`,
  );
}
