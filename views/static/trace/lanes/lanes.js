// How lanes look.

import { lastAtMost, STATES } from "../data.js";
import {
  arrow,
  bars,
  cross,
  diamond,
  drawState,
  hourglass,
  letterOfEnd,
  nodeColour,
  square,
  triangle,
} from "./shapes.js";
import { points, textWidth } from "./surface.js";

/** @import { Call, FilledLane, LaneKind, Mark, Point, Seen } from "../types.js" */
/** @typedef {(view: Seen, lane: FilledLane, y: number, height: number) => void} DrawLane */
/** @typedef {[x: number, value: number]} Level */
/** @typedef {(step: number, mark: Mark, x: number) => void} Visit */

/** @type {Record<LaneKind | "heading", number>} */
export const HEIGHTS = {
  heading: 24,
  state: 22,
  signal: 20,
  queue: 30,
  client: 30,
  transition: 18,
  place: 30,
};

/** A place on the surface, near enough to what is seen. @type {(view: Seen, x: number) => number} */
export const clampX = (view, x) => Math.max(view.left - 20, Math.min(view.left + view.width + 20, x));

/** A line through the whole trace. @type {(view: Seen, y: number) => Point[]} */
const throughout = (view, y) => points(clampX(view, view.dx), y, clampX(view, view.dx + view.scale.width), y);

/**
 * Calls `visit` for the marks of a lane with some letters that can be seen, once for each pixel when they are
 * dense.
 *
 * @type {(view: Seen, lane: FilledLane, letters: string, visit: Visit) => void}
 */
function visible(view, lane, letters, visit) {
  let column = -Infinity;
  for (let i = lastAtMost(lane.at, view.from - 1) + 1; i < lane.at.length && lane.at[i] <= view.to; i++) {
    if (!letters.includes(lane.marks[i][0])) continue;
    const x = view.dx + view.scale.x(lane.at[i]);
    if (lane.marks[i][0] !== "d" && x - column < 1) continue;
    column = x;
    visit(lane.at[i], lane.marks[i], x);
  }
}

/**
 * The values of a lane where they change, from the left edge of what is seen to the right.
 *
 * @type {(view: Seen, lane: FilledLane) => Level[]}
 */
function levels(view, lane) {
  /** @type {Level[]} */
  const found = [[view.dx + view.scale.x(Math.max(view.from - 1, -1)), view.data.level(lane, view.from - 1)]];
  let first = lastAtMost(lane.at, view.from - 1) + 1;
  for (; first < lane.at.length && lane.at[first] <= view.to; first++) {
    const x = view.dx + view.scale.x(lane.at[first]);
    const value = lane.marks[first][1];
    const last = found[found.length - 1];
    const before = found[found.length - 2];
    if (value === last[1]) continue;
    if (before && x - before[0] < 0.5) {
      // many changes in one pixel: the highest and the last of them
      before[1] = Math.max(before[1], last[1]);
      last[1] = value;
      continue;
    }
    found.push([x, value]);
  }
  const end = view.dx + (view.to >= view.data.length - 1 ? view.scale.width : view.scale.x(view.to + 1));
  found.push([end, found[found.length - 1][1]]);
  return found;
}

/**
 * A line that goes up and down in steps.
 *
 * @type {(levels: Level[], yOf: (value: number) => number) => Point[]}
 */
const stairs = (levels, yOf) =>
  levels.flatMap(([x, value], i) =>
    i ? points(x, yOf(levels[i - 1][1]), x, yOf(value)) : points(x, yOf(value)),
  );

/** A signal that has values: a band for each, with its name. @type {DrawLane} */
function valued(view, lane, y, height) {
  const { surface, theme } = view;
  const values = levels(view, lane);
  for (let i = 0; i + 1 < values.length; i++) {
    const [x, value] = values[i];
    const [from, to] = [clampX(view, x), clampX(view, values[i + 1][0])];
    const fill = value % 2 ? theme.signalFill : theme.fold;
    surface.rect(from, y + 3, to - from, height - 6, { fill });
    if (i) surface.path(points(from, y + 2, from, y + height - 2), { stroke: theme.signal, width: 1.6 });
    const name = lane.values?.[value] ?? "";
    const begin = Math.max(from, view.left);
    if (textWidth(name, 9.5) + 8 <= Math.min(to, view.left + view.width) - begin)
      surface.text(begin + 4, y + height - 6, name, { fill: theme.ink, size: 9.5 });
  }
}

/** @type {DrawLane} */
function signal(view, lane, y, height) {
  if (lane.values) {
    valued(view, lane, y, height);
    return;
  }
  const { surface, theme } = view;
  const top = y + 4;
  const low = y + height - 4;
  const values = levels(view, lane);
  for (let i = 0; i + 1 < values.length; i++) {
    const [x, value] = values[i];
    if (value) surface.rect(x, top, values[i + 1][0] - x, low - top, { fill: theme.signalFill });
  }
  const line = stairs(values, (value) => (value ? top : low));
  surface.path(line, { stroke: theme.signal, width: 1.6 });
}

/** A managed node: a band whose height and colour are its state, which is in it. @type {DrawLane} */
function state(view, lane, y, height) {
  const { surface, theme } = view;
  const base = y + height - 3;
  const values = levels(view, lane);
  for (let i = 0; i + 1 < values.length; i++) {
    const [x, value] = values[i];
    const [from, to] = [clampX(view, x), clampX(view, values[i + 1][0])];
    const line = drawState(surface, theme, value, from, to, y + 3, height - 6);
    const begin = Math.max(from, view.left);
    if (textWidth(STATES[value], 9.5) + 8 <= Math.min(to, view.left + view.width) - begin)
      surface.text(begin + 4, line, STATES[value], { fill: theme.ink, size: 9.5 });
  }
  visible(view, lane, "l", (_, [, , failed], x) => {
    if (failed) cross(surface, x, y + height / 2, theme);
    else surface.path(points(x, y + 2, x, base), { stroke: theme.ink, width: 1.4 });
  });
}

/** @type {(lane: FilledLane) => number} */
function highest(lane) {
  let most = 1;
  for (const mark of lane.marks) if (mark[1] > most) most = mark[1];
  return most;
}

/** @type {DrawLane} */
function queue(view, lane, y, height) {
  const { surface, theme } = view;
  const base = y + height - 4;
  const top = y + 6;
  const most = Math.max(lane.capacity ?? 0, highest(lane));
  /** @type {(value: number) => number} */
  const yOf = (value) => base - ((base - top) * value) / most;
  if (lane.kind === "place" || lane.marks.some((mark) => mark[1])) {
    const values = levels(view, lane);
    const line = stairs(values, yOf);
    const ground = points(line[line.length - 1][0], base, line[0][0], base);
    surface.path([...line, ...ground], { fill: theme.topicFill, closed: true });
    surface.path(line, { stroke: theme.topic, width: 1.2 });
    // The number stands where the level stays long enough to be read.
    for (let i = 0; i + 1 < values.length; i++) {
      const from = Math.max(values[i][0], view.left);
      const to = Math.min(values[i + 1][0], view.left + view.width);
      if (values[i][1] && to - from > 26)
        surface.text(from + 12, base - 2, values[i][1], { fill: theme.ink, size: 9.5 });
    }
  } else surface.path(throughout(view, base), { stroke: theme.line });
  if (lane.capacity) {
    const limit = throughout(view, yOf(lane.capacity));
    surface.path(limit, { stroke: theme.alarm, dash: [5, 4], opacity: 0.75 });
  }
  visible(view, lane, "pkd", (_, mark, x) => {
    if (mark[0] === "d") {
      cross(surface, x, y + height / 2, theme);
      if (mark[2] > 1)
        surface.text(x + 6, y + height / 2 + 4, mark[2], { fill: theme.alarm, size: 10, bold: true });
    } else if (mark[0] === "p")
      surface.path(triangle(x, y + height / 2 - 2, true), { fill: theme.topic, closed: true });
    else {
      const hollow = { fill: theme.back, stroke: theme.topic, width: 1.5, closed: true };
      surface.path(triangle(x, y + height / 2 - 2, false), hollow);
    }
  });
}

/** Rows for calls of a client that overlap, at most. */
const ROWS = 3;

/** @type {DrawLane} */
function client(view, lane, y, height) {
  const { surface, theme, scale } = view;
  const rows = Math.min(ROWS, Math.max(1, lane.levels.length));
  const tall = (height - 8) / rows;
  /** @type {number[]} */
  const free = [];
  for (const call of seenCalls(lane, view.from)) {
    if (!call) continue;
    if (call.first > view.to) break;
    const row = call.level % rows;
    const top = y + 5 + row * tall;
    const low = top + tall - (row === rows - 1 ? 0 : 1);
    const x = view.dx + scale.x(call.request ?? call.serve ?? call.first);
    const end = view.dx + scale.x(call.response ?? call.givenUp ?? view.data.length);
    const late = call.givenUp === undefined || call.serve === undefined;
    const last = late ? end : view.dx + scale.x(call.reply ?? view.data.length);
    if (Math.max(end, last) < view.left - 20) continue;
    if (end - x < 1.5 && x - (free[row] ?? -Infinity) < 1) continue;
    free[row] = end;
    const answered = call.response !== undefined;
    const left = clampX(view, x);
    const right = clampX(view, end);
    const outline = points(left, top, right, top);
    if (left === x) outline.unshift([x, low]);
    if (right === end && answered) outline.push([end, low]);
    surface.path(outline, { stroke: theme.service, width: 1.6, dash: answered ? undefined : [4, 3] });
    if (call.serve !== undefined) served(view, lane, call, call.serve, top, low);
    for (const step of call.timeouts) hourglass(surface, view.dx + scale.x(step), top + 5, theme);
    if (call.givenUp !== undefined) hourglass(surface, end, top + 5, theme);
    for (const step of call.feedback) {
      const at = view.dx + scale.x(step);
      surface.path(points(at, top + 4, at, low), { stroke: theme.service, width: 1.6 });
    }
    for (const step of call.cancels) square(surface, view.dx + scale.x(step), top + 1, theme);
    if (call.end !== undefined && right === end)
      surface.text(end - 8, low - 3, letterOfEnd(call.end), { fill: theme.ink, size: 9.5, bold: true });
  }
}

/** The calls that can be seen from a step on. @type {(lane: FilledLane, from: number) => Call[]} */
function seenCalls(lane, from) {
  if (lane.levels.length > 1 || lane.calls.some((call) => call?.givenUp !== undefined)) return lane.calls;
  // Calls follow one another: the first that can be seen is the last that began before the window, or later.
  const begins = Array.from(lane.calls, (call) => call?.first ?? -1);
  return lane.calls.slice(Math.max(0, lastAtMost(begins, from) - 1));
}

/**
 * The part of a call in which a server instance works.
 *
 * @type {(view: Seen, lane: FilledLane, call: Call, serve: number, top: number, low: number) => void}
 */
function served(view, lane, call, serve, top, low) {
  const { surface, theme, scale } = view;
  const from = clampX(view, view.dx + scale.x(serve));
  const to = clampX(view, view.dx + scale.x(call.reply ?? view.data.length));
  const upper = top + Math.min(4, (low - top) / 4);
  surface.rect(from, upper, Math.max(to - from, 1), low - upper - 1, { fill: theme.serviceFill });
  if (call.reply === undefined && call.response === undefined) {
    const open = points(to, upper, from, upper, from, low - 1, to, low - 1);
    surface.path(open, { stroke: theme.service, dash: [4, 3] });
  }
  const instance = `I${call.instance ?? "?"}`;
  const room = Math.min(to, view.left + view.width) - Math.max(from, view.left);
  const whole = `${instance} C ${lane.id}`;
  const text = textWidth(whole, 9.5) + 6 <= room ? whole : instance;
  if (textWidth(text, 9.5) + 4 <= room && low - top >= 12)
    surface.text(Math.max(from, view.left) + 3, low - 4, text, { fill: theme.ink, size: 9.5 });
}

/**
 * When a firing of a schedule can happen: from its earliest to its latest time, or open to the right.
 *
 * @type {(view: Seen, window: [number, number | null], middle: number, colour: string) => void}
 */
function drawWindow(view, [earliest, latest], middle, colour) {
  const { surface, scale, dx } = view;
  const from = clampX(view, dx + earliest * scale.zoom);
  const to = clampX(view, dx + Math.min(latest ?? scale.total, scale.total) * scale.zoom);
  if (to - from < 1) return;
  surface.rect(from, middle - 3, to - from, 6, { fill: colour, opacity: 0.28 });
  surface.path(points(from, middle - 5, from, middle + 5), { stroke: colour, width: 1 });
  if (latest !== null && latest <= scale.total)
    surface.path(points(to, middle - 5, to, middle + 5), { stroke: colour, width: 1 });
  else surface.path(points(to - 5, middle - 4, to, middle, to - 5, middle + 4), { stroke: colour, width: 1 });
}

/** @type {DrawLane} */
function transition(view, lane, y, height) {
  const { surface, theme, scale, data } = view;
  const colour = nodeColour(theme, data, lane.node);
  const middle = y + height / 2;
  surface.path(throughout(view, middle), { stroke: theme.grid, width: 1 });
  visible(view, lane, "fezu", (step, [letter, handlers], x) => {
    if (letter === "e") cross(surface, x, middle, theme);
    else if (letter === "z") bars(surface, x, middle, theme);
    else if (letter === "u") arrow(surface, x, middle, theme);
    else {
      const possible = scale.time && data.steps[step].d?.window;
      if (possible) drawWindow(view, possible, middle, colour);
      const took = scale.time ? data.steps[step].d?.duration : 0;
      if (took) {
        const begun = clampX(view, x - took * scale.zoom);
        surface.rect(begun, middle - 3, x - begun, 6, { fill: theme.handler, opacity: 0.35 });
      }
      const filled = { fill: theme.handler, stroke: theme.back, width: 0.8, closed: true };
      if (handlers) surface.path(diamond(x, middle), filled);
      else surface.path(points(x, middle - 6, x, middle + 6), { stroke: colour, width: 2 });
    }
  });
}

/** @type {Record<LaneKind, DrawLane>} */
const DRAWERS = { state, signal, queue, client, transition, place: queue };

/** @type {DrawLane} */
export function drawLane(view, lane, y, height) {
  view.surface.begin(`lane ${lane.kind}`, lane.id, `${lane.label} ${lane.note}`.trim());
  if (!lane.absent) DRAWERS[lane.kind](view, lane, y, height); // otherwise only the other trace has it
  view.surface.end();
}
