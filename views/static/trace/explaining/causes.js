// Where the outcome of a witness may have begun, and the steps that brought it about, as they are drawn; and
// breakpoints.

import { lastAtMost } from "../data.js";
import { stop } from "../lanes/shapes.js";
import { points, textWidth } from "../lanes/surface.js";

/** @import { Seen } from "../types.js" */

/** The flag of the first cause, on the ruler. @type {(view: Seen, y: number, height: number) => void} */
export function drawCauseFlag(view, y, height) {
  const { surface, scale, theme, data, dx, left } = view;
  if (!data.cause || data.cause.first < 0) return;
  const right = left + view.width;
  const x = dx + scale.left(data.cause.first);
  const said = `first cause? ${data.cause.first + 1}`;
  const wide = textWidth(said, 10.5) + 8;
  if (x + wide < left - 20 || x > right + 20) return;
  surface.begin("cause", "cause", "first cause?");
  const loop = data.loop === null ? Infinity : dx + scale.left(data.loop);
  const overLoop = x <= loop && x + wide > loop && x - wide > left; // whose name begins there
  const turned = overLoop || x + wide > right; // the flag blows to the left
  const from = turned ? x - wide : x;
  surface.path(points(x, y, x, y + height), { stroke: theme.cause, width: 1.8 });
  surface.rect(from, y, wide, 15, { fill: theme.back, stroke: theme.cause, width: 1.2 });
  surface.text(from + 4, y + 11, said, { fill: theme.cause, size: 10.5, bold: true });
  surface.end();
}

/** The line of the first cause, through all lanes. @type {(view: Seen, y: number, height: number) => void} */
export function drawCauseLine(view, y, height) {
  const { surface, scale, theme, data } = view;
  if (!data.cause || data.cause.first < 0) return;
  const x = view.dx + scale.left(data.cause.first);
  if (x < view.left || x > view.left + view.width) return;
  surface.path(points(x, y, x, y + height), { stroke: theme.cause, width: 1.4, dash: [2, 3] });
}

/** Bars below the strip of nodes. @type {(view: Seen, y: number) => void} */
export function drawCauseBars(view, y) {
  const { surface, scale, theme, data } = view;
  if (!data.cause) return;
  surface.begin("causes", "causes", "steps that brought the outcome about");
  let column = -Infinity;
  for (const step of within(view, data.cause.steps)) {
    const x = view.dx + scale.left(step);
    const width = scale.right(step) - scale.left(step);
    if (x + width - column < 1) continue;
    column = x + width;
    surface.rect(x, y, Math.max(width - (width > 4 ? 0.6 : 0), 0.8), 2.4, { fill: theme.cause });
  }
  surface.end();
}

/**
 * Breakpoints that were hit, as stop signs on the ruler.
 *
 * @type {(view: Seen, stops: number[], y: number, height: number) => void}
 */
export function drawStops(view, stops, y, height) {
  let column = -Infinity;
  for (const step of within(view, stops)) {
    const x = view.dx + view.scale.x(step);
    if (x - column < 2) continue;
    column = x;
    stop(view.surface, x, y + height - 4, view.theme);
  }
}

/** Those of some steps that can be seen. @type {(view: Seen, steps: number[]) => number[]} */
const within = (view, steps) =>
  steps.slice(lastAtMost(steps, view.from - 1) + 1, lastAtMost(steps, view.to) + 1);
