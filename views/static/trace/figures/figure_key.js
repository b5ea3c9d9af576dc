// What the colours and marks of a figure mean.

import { STATES } from "../data.js";
import {
  cross,
  diamond,
  drawState,
  hourglass,
  nodeColour,
  nodeLetter,
  square,
  triangle,
} from "../lanes/shapes.js";
import { points, textWidth } from "../lanes/surface.js";

/** @import { Data } from "../data.js" */
/** @import { FilledLane, Surface, Theme } from "../types.js" */

/**
 * The colours of nodes; returns where what is below begins.
 *
 * @type {(surface: Surface, data: Data, theme: Theme, left: number, top: number, wide: number) => number}
 */
export function drawNodes(surface, data, theme, left, top, wide) {
  let [x, y] = [left, top];
  surface.begin("legend", "nodes", "");
  data.nodes.forEach((node, index) => {
    const room = textWidth(node, 10.5) + 34;
    if (x + room > left + wide && x > left) {
      x = left;
      y += 17;
    }
    surface.rect(x, y, 17, 12, { fill: nodeColour(theme, data, index) });
    const lettering = { fill: theme.back, size: 9, bold: true };
    surface.text(x + 8.5, y + 9.5, nodeLetter(data, index), { ...lettering, anchor: "middle" });
    surface.text(x + 21, y + 10, node, { fill: theme.ink, size: 10.5 });
    x += room;
  });
  surface.end();
  return y + 20;
}

/**
 * What the marks mean, of those that occur; returns where it ends.
 *
 * @type {(surface: Surface, theme: Theme, left: number, top: number, lanes: FilledLane[], shown: { causes: boolean, windows: boolean }) => number}
 */
export function drawKey(surface, theme, left, top, lanes, { causes, windows }) {
  let x = left;
  const middle = top + 7;
  /** @type {(text: string, draw: () => void) => void} */
  const item = (text, draw) => {
    draw();
    surface.text(x + 20, top + 11, text, { fill: theme.soft, size: 10.5 });
    x += textWidth(text, 10.5) + 38;
  };
  const kinds = new Set(lanes.map((lane) => lane.kind));
  const marks = lanes.flatMap((lane) =>
    lane.marks.map(([letter, value, more]) => ({ kind: lane.kind, letter, value, more })),
  );
  const calls = lanes.flatMap((lane) => lane.calls.filter(Boolean));
  const waits = { stroke: theme.service, width: 1.6 };
  surface.begin("key", "key", "");
  if (kinds.has("state"))
    STATES.forEach((name, number) => {
      item(name, () => drawState(surface, theme, number, x, x + 15, top, 13));
    });
  if (marks.some(({ kind, letter, more }) => kind === "state" && letter === "l" && more))
    item("fails to change its state", () => cross(surface, x + 7, middle, theme));
  if (kinds.has("queue")) {
    item("publish", () => surface.path(triangle(x + 7, middle, true), { fill: theme.topic, closed: true }));
    item("take", () => {
      surface.path(triangle(x + 7, middle, false), { stroke: theme.topic, width: 1.5, closed: true });
    });
    item("capacity", () => {
      surface.path(points(x, middle, x + 15, middle), { stroke: theme.alarm, dash: [5, 4] });
    });
  }
  if (marks.some(({ letter }) => letter === "d"))
    item("message lost", () => cross(surface, x + 7, middle, theme));
  if (kinds.has("client")) {
    item("client waits (C)", () => {
      surface.path(points(x, middle + 4, x, middle - 4, x + 14, middle - 4, x + 14, middle + 4), waits);
    });
    item("server instance works (I)", () => {
      surface.rect(x, middle - 4, 14, 8, { fill: theme.serviceFill });
    });
  }
  if (calls.some((call) => call.response === undefined && call.givenUp === undefined))
    item("not answered", () => {
      surface.path(points(x, middle + 4, x, middle - 4, x + 15, middle - 4), { ...waits, dash: [4, 3] });
    });
  if (calls.some((call) => call.timeouts.length))
    item("waits too long", () => hourglass(surface, x + 7, middle, theme));
  if (calls.some((call) => call.givenUp !== undefined))
    item("gives up", () => {
      surface.path(points(x, middle + 4, x, middle - 4, x + 11, middle - 4), { ...waits, dash: [4, 3] });
      hourglass(surface, x + 11, middle, theme);
    });
  if (calls.some((call) => call.feedback.length))
    item("feedback", () => surface.path(points(x + 7, middle - 4, x + 7, middle + 4), waits));
  if (calls.some((call) => call.cancels.length))
    item("asks to cancel", () => square(surface, x + 7, middle, theme));
  if (calls.some((call) => call.end !== undefined))
    item("succeeded, aborted, canceled, rejected", () => {
      surface.text(x - 5, top + 11, "SACR", { fill: theme.ink, size: 7.5, bold: true });
    });
  if (kinds.has("transition"))
    item("fires", () => {
      surface.path(points(x + 7, middle - 6, x + 7, middle + 6), { stroke: theme.soft, width: 2 });
    });
  if (marks.some(({ kind, letter, value }) => kind === "transition" && letter === "f" && value))
    item("fires with handlers", () => {
      surface.path(diamond(x + 7, middle), { fill: theme.handler, closed: true });
    });
  if (windows && kinds.has("transition"))
    item("can fire", () => surface.rect(x, middle - 3, 14, 6, { fill: theme.soft, opacity: 0.28 }));
  if (causes)
    item("brought the outcome about", () => {
      surface.rect(x, middle - 1, 14, 2.4, { fill: theme.cause });
    });
  surface.end();
  return top + 18;
}
