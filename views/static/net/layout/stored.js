// Sheets (pages, or the whole picture) whose elements were arranged in an editor keep that arrangement.

import { lookUp } from "../../maps.js";

/** @import { Block, Box, PlacedSheet, Point, Reach, Seated, Spot, Stored } from "../types.js" */
/** @typedef {{ at: Spot, room: Reach }} Taken  what stands somewhere already */
/**
 * @typedef {{ from: number, to: number, rate: number }} Strip  a part of an axis, and by how much it grows
 */

const GAP = 14;
const ROOM = 32;
const PADDING = 18;
const MOST_SCALE = 3;

/** How far an item and its captions reach from its centre. @type {(item: Seated) => Reach} */
function reach(item) {
  const room = item.room || [0, 0];
  const [width, height] = item.open || [item.width, item.height];
  return { side: Math.max(width, room[0]) / 2, up: height / 2, down: height / 2 + room[1] };
}

/** @type {(item: Seated) => Reach} */
const closed = (item) => reach({ ...item, open: undefined });

/**
 * The items of a sheet that stand where they were stored.
 *
 * @type {(items: Seated[]) => Stored[]}
 */
export function kept(items) {
  /** @type {Stored[]} */
  const found = [];
  /** @type {(point: Point) => boolean} */
  const taken = ([x, y]) =>
    found.some((other) => Math.hypot(other.position[0] - x, other.position[1] - y) < 1);
  for (const item of items)
    if (item.position && !taken(item.position)) found.push(/** @type {Stored} */ (item));
  return found;
}

/**
 * Whether stored positions of a sheet say where its elements go: one point is not an arrangement, unless it is
 * drawn in a frame.
 *
 * @type {(items: Seated[], box: Box | undefined) => boolean}
 */
export const isArranged = (items, box) => kept(items).length > (box?.frame ? 0 : 1);

/** @type {(one: Spot, first: Reach, other: Spot, second: Reach, gap: number) => boolean} */
function overlap(one, first, other, second, gap) {
  return (
    Math.abs(one.x - other.x) < first.side + second.side + gap &&
    (one.y < other.y
      ? one.y + first.down + gap > other.y - second.up
      : other.y + second.down + gap > one.y - first.up)
  );
}

/**
 * By how much the plane must grow for two items to be so far apart while they are closed.
 *
 * @type {(a: Stored, b: Stored, gap: number) => number}
 */
function neededScale(a, b, gap) {
  const dx = Math.abs(a.position[0] - b.position[0]);
  const dy = b.position[1] - a.position[1];
  const first = closed(a);
  const second = closed(b);
  const across = (first.side + second.side + gap) / dx;
  const along = (dy > 0 ? first.down + second.up + gap : second.down + first.up + gap) / Math.abs(dy);
  return Math.min(across, along);
}

/**
 * One scale for the whole sheet. Drawings in centimetres need a large one; a few items that were drawn nearly
 * on top of each other do not make it larger, and stay as they were drawn. Those that just get clear of each
 * other at the limit do with a smaller gap.
 *
 * @type {(items: Stored[]) => number}
 */
function scaleOf(items) {
  /** @type {{ need: number, least: number }[]} */
  const pairs = [];
  const most = items.map(() => 1);
  items.forEach((item, index) => {
    for (let other = 0; other < index; other += 1) {
      const need = neededScale(item, items[other], GAP);
      pairs.push({ need, least: neededScale(item, items[other], 0) });
      most[index] = Math.max(most[index], need);
      most[other] = Math.max(most[other], need);
    }
  });
  const sorted = most.sort((a, b) => a - b);
  const limit = Math.max(MOST_SCALE, 2 * sorted[Math.floor((sorted.length - 1) / 2)]);
  return Math.max(1, ...pairs.filter(({ least }) => least <= limit).map(({ need }) => Math.min(need, limit)));
}

/**
 * Of things that may be put among others on a sheet, one after the other, whether each stands clear of what is
 * there without the plane growing by more than it has to, or than a limit.
 *
 * @type {(items: Stored[], more: Stored[], limit: number) => boolean[]}
 */
export function standClear(items, more, limit) {
  const there = [...items];
  const most = Math.max(limit, scaleOf(items));
  return more.map((item) => {
    const clear = there.every((other) => neededScale(item, other, 0) <= most);
    if (clear) there.push(item);
    return clear;
  });
}

/**
 * Half of the room that a sheet gives a box: the frame it was drawn with, unless that holds other items of
 * the sheet.
 *
 * @type {(item: Stored, at: Map<string, Spot>, items: Stored[], scale: number) => Reach}
 */
function seat(item, at, items, scale) {
  const own = closed(item);
  const [wide, high] = item.frame || [0, 0];
  const framed = {
    side: Math.max(own.side, (wide * scale) / 2),
    up: Math.max(own.up, (high * scale) / 2),
    down: Math.max(own.down, (high * scale) / 2),
  };
  const free = items.every(
    (other) =>
      other === item || !overlap(lookUp(at, item.id), framed, lookUp(at, other.id), closed(other), 0),
  );
  return free ? framed : own;
}

/**
 * A map of one axis that grows the strips of open boxes, each to the room its box needs, and moves what is
 * beyond: order is kept, distances never shrink, and boxes above each other share a strip.
 *
 * @type {(strips: Strip[]) => (value: number) => number}
 */
export function stretched(strips) {
  const ends = [...new Set(strips.flatMap(({ from, to }) => [from, to]))].sort((a, b) => a - b);
  const rates = ends
    .slice(1)
    .map((end, index) =>
      Math.max(
        0,
        ...strips.filter(({ from, to }) => from <= ends[index] && to >= end).map(({ rate }) => rate),
      ),
    );
  return (value) =>
    rates.reduce(
      (sum, rate, index) => sum + rate * Math.max(0, Math.min(value, ends[index + 1]) - ends[index]),
      value,
    );
}

/** Where points of the stored plane go. @type {(items: Stored[], scale: number) => (point: Point) => Spot} */
function plane(items, scale) {
  const base = new Map(
    items.map((item) => [item.id, { x: item.position[0] * scale, y: item.position[1] * scale }]),
  );
  /** @type {Strip[]} */
  const across = [];
  /** @type {Strip[]} */
  const along = [];
  for (const item of items) {
    if (!item.open) continue;
    const { x, y } = lookUp(base, item.id);
    const room = seat(item, base, items, scale);
    const need = reach(item);
    across.push({ from: x - room.side, to: x + room.side, rate: Math.max(0, need.side / room.side - 1) });
    along.push({ from: y - room.up, to: y + room.up, rate: Math.max(0, need.up / room.up - 1) });
  }
  const onX = stretched(across);
  const onY = stretched(along);
  return ([x, y]) => ({ x: onX(x * scale), y: onY(y * scale) });
}

/**
 * Where everything on such a sheet goes.
 *
 * @type {(items: Seated[], box: Box | undefined, blocks: Block[], bends: Point[]) => PlacedSheet}
 */
export function placeSheet(items, box, blocks, bends) {
  const fixed = kept(items);
  const scale = scaleOf(fixed);
  const map = plane(fixed, scale);
  const at = new Map(fixed.map((item) => [item.id, map(item.position)]));
  const areas = fixed.map((item) => ({ at: lookUp(at, item.id), room: reach(item) }));
  for (const block of inOrder(blocks, at)) {
    const room = { side: block.width / 2, up: block.height / 2, down: block.height / 2 };
    const near = block.anchor ? [map(block.anchor)] : block.near.flatMap((id) => at.get(id) ?? []);
    const centre = freePlace(room, areas, near.length ? near : [...at.values()]);
    areas.push({ at: centre, room });
    for (const { item, x, y } of block.parts)
      at.set(item.id, { x: centre.x - room.side + x, y: centre.y - room.up + y });
  }
  const header = box?.header ?? [0, 0];
  const points = bends.map(map);
  if (box?.frame && box.position) {
    const [x, y] = box.position;
    const [wide, high] = box.frame;
    points.push(map([x - wide / 2, y - high / 2]), map([x + wide / 2, y + high / 2]));
  }
  const none = { side: 0, up: 0, down: 0 };
  const all = [
    ...areas.map((area) => ({ ...area, by: PADDING })),
    ...points.map((point, index) => ({ at: point, room: none, by: index < bends.length ? PADDING : 0 })),
  ];
  const left = Math.min(...all.map((one) => one.at.x - one.room.side - one.by));
  const right = Math.max(...all.map((one) => one.at.x + one.room.side + one.by));
  const top = Math.min(...all.map((one) => one.at.y - one.room.up - one.by - (one.by ? header[1] : 0)));
  const bottom = Math.max(...all.map((one) => one.at.y + one.room.down + one.by));
  for (const point of at.values()) {
    point.x -= left;
    point.y -= top;
  }
  /** @type {PlacedSheet["bent"]} */
  const bent = (found) => found.map(map).map(({ x, y }) => [x - left, y - top]);
  return { at, bent, width: Math.max(right - left, header[0] + 8), height: bottom - top };
}

/**
 * What is joined to things that have their place comes first.
 *
 * @type {(blocks: Block[], at: Map<string, Spot>) => Block[]}
 */
function inOrder(blocks, at) {
  const placed = new Set(at.keys());
  const rest = [...blocks];
  /** @type {Block[]} */
  const found = [];
  while (rest.length) {
    const index = Math.max(
      0,
      rest.findIndex((block) => block.anchor || block.near.some((id) => placed.has(id))),
    );
    const [block] = rest.splice(index, 1);
    for (const { item } of block.parts) placed.add(item.id);
    found.push(block);
  }
  return found;
}

/**
 * The nearest place to some points where a block covers nothing.
 *
 * @type {(room: Reach, areas: Taken[], near: Spot[]) => Spot}
 */
function freePlace(room, areas, near) {
  /** @type {(axis: "x" | "y") => number} */
  const mean = (axis) => near.reduce((sum, one) => sum + one[axis], 0) / near.length;
  const centre = { x: mean("x"), y: mean("y") };
  const step = Math.max(12, Math.min(room.side, room.up) / 3);
  for (let ring = 0; ring < 150; ring += 1) {
    const turns = Math.max(1, 8 * ring);
    for (let turn = 0; turn < turns; turn += 1) {
      const angle = (2 * Math.PI * turn) / turns;
      const point = {
        x: centre.x + step * ring * Math.cos(angle),
        y: centre.y + step * ring * Math.sin(angle),
      };
      if (!areas.some((area) => overlap(point, room, area.at, area.room, ROOM))) return point;
    }
  }
  return { x: centre.x, y: Math.max(...areas.map((area) => area.at.y + area.room.down)) + ROOM + room.up };
}
