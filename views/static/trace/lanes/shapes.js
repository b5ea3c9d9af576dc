// Small signs on lanes, and the colours and letters of nodes.

import { points } from "./surface.js";

/** @import { Data } from "../data.js" */
/** @import { Point, Surface, Theme } from "../types.js" */
/** @typedef {(surface: Surface, x: number, y: number, theme: Theme) => void} DrawSign */

/** A message that is published (up) or taken. @type {(x: number, y: number, up: boolean) => Point[]} */
export const triangle = (x, y, up) =>
  up ? points(x - 4.5, y + 4, x + 4.5, y + 4, x, y - 4) : points(x - 4.5, y - 4, x + 4.5, y - 4, x, y + 4);

/** A transition that fires with handlers. @type {(x: number, y: number) => Point[]} */
export const diamond = (x, y) => points(x - 5, y, x, y - 5, x + 5, y, x, y + 5);

/** A message that is lost, a step that fails. @type {DrawSign} */
export function cross(surface, x, y, theme) {
  surface.path(points(x - 4, y - 4, x + 4, y + 4), { stroke: theme.alarm, width: 2.4 });
  surface.path(points(x - 4, y + 4, x + 4, y - 4), { stroke: theme.alarm, width: 2.4 });
}

/** A request that waits too long. @type {DrawSign} */
export function hourglass(surface, x, y, theme) {
  const course = points(x - 4, y - 5, x + 4, y - 5, x - 4, y + 5, x + 4, y + 5);
  surface.path(course, { fill: theme.alarm, closed: true });
}

/** A request to cancel a goal. @type {DrawSign} */
export function square(surface, x, y, theme) {
  surface.rect(x - 3.5, y - 3.5, 7, 7, { fill: theme.alarm });
}

/** How a goal ends, by its first letter. @type {(end: number) => string} */
export const letterOfEnd = (end) => "SACR"[end] ?? "?";

/** Tokens that are left aside. @type {DrawSign} */
export function bars(surface, x, y, theme) {
  for (const at of [x - 3, x + 1]) surface.rect(at, y - 5, 2.5, 10, { fill: theme.alarm });
}

/** Tokens that are taken again. @type {DrawSign} */
export function arrow(surface, x, y, theme) {
  const course = points(x - 4, y - 5, x + 5, y, x - 4, y + 5);
  surface.path(course, { stroke: theme.alarm, width: 1.5, closed: true });
}

/** The height of the band of each state of a managed node: colour alone would not distinguish states. */
const PARTS = [0.35, 0.7, 1, 0.12];

/**
 * A managed node in a state; returns where a line of text stands.
 *
 * @type {(surface: Surface, theme: Theme, state: number, from: number, to: number, y: number, height: number) => number}
 */
export function drawState(surface, theme, state, from, to, y, height) {
  const fill = [theme.fold, theme.signalFill, theme.serviceFill, theme.soft][state];
  const top = y + height * (1 - PARTS[state]);
  surface.rect(from, top, to - from, y + height - top, { fill });
  surface.path(points(from, top, to, top), { stroke: theme.soft, width: 1.2 });
  return PARTS[state] < 0.5 ? top - 2 : y + height - 3;
}

/** A breakpoint that was hit. @type {DrawSign} */
export function stop(surface, x, y, theme) {
  const angles = Array.from({ length: 8 }, (_, i) => Math.PI * (i / 4 + 0.125));
  const octagon = angles.flatMap((angle) => [x + 4.6 * Math.cos(angle), y + 4.6 * Math.sin(angle)]);
  surface.path(points(...octagon), { fill: theme.alarm, stroke: theme.back, width: 1, closed: true });
}

/**
 * The colour of a node, given by its name or its number.
 *
 * @type {(theme: Theme, data: Data, node: string | number | undefined) => string}
 */
export function nodeColour(theme, data, node = -1) {
  const index = typeof node === "number" ? node : data.nodes.indexOf(node);
  return index < 0 ? theme.soft : theme.nodes[index % theme.nodes.length];
}

/** One or two letters that tell a node from the others. @type {(data: Data, index: number) => string} */
export function nodeLetter(data, index) {
  const name = data.nodes[index];
  const first = name[0].toUpperCase();
  const unique = !data.nodes.some((other, i) => i < index && other[0].toUpperCase() === first);
  return unique ? first : first + (name[1] ?? "");
}
