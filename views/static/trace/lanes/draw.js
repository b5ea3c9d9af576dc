// How what goes through all lanes looks, ruler, node strip and minimap.

import { clampX } from "./lanes.js";
import { nodeColour, nodeLetter } from "./shapes.js";
import { points, textWidth } from "./surface.js";

/** @import { Seen } from "../types.js" */
/** @typedef {(view: Seen, y: number, height: number) => void} Draw */

/** Backgrounds that go through all lanes: the loop, and what is folded. @type {Draw} */
export function drawGround(view, y, height) {
  const { surface, scale, theme, data } = view;
  if (data.loop !== null) {
    const x = clampX(view, view.dx + scale.left(data.loop));
    const end = clampX(view, view.dx + scale.width);
    surface.rect(x, y, end - x, height, { fill: theme.loop });
  }
  for (const fold of scale.folds) {
    const x = view.dx + fold.start * scale.zoom;
    const end = view.dx + fold.end * scale.zoom;
    if (end < view.left || x > view.left + view.width) continue;
    surface.rect(x + 1, y, Math.max(end - x - 2, 1), height, { fill: theme.fold, opacity: 0.8 });
  }
}

/** @type {Draw} */
export function drawRuler(view, y, height) {
  const { surface, theme, left, width } = view;
  surface.begin("ruler", "ruler", "");
  surface.path(points(left, y + height - 0.5, left + width, y + height - 0.5), { stroke: theme.line });
  if (view.scale.time) rulerOfTime(view, y + height);
  else rulerOfSteps(view, y + height);
  drawLoop(view, y);
  surface.end();
}

/**
 * A mark of the ruler, which is on a line, and its text.
 *
 * @type {(view: Seen, base: number, x: number, text: string | number) => void}
 */
function drawTick({ surface, theme, left, width }, base, x, text) {
  if (x < left - 40 || x > left + width + 40) return;
  surface.path(points(x, base - 6, x, base), { stroke: theme.soft });
  if (x < left + 12)
    surface.text(Math.max(x, left + 1), base - 8, text, { fill: theme.soft, size: 10, anchor: "start" });
  else surface.text(x, base - 8, text, { fill: theme.soft, size: 10, anchor: "middle" });
}

/** @type {(view: Seen, base: number) => void} */
function rulerOfTime(view, base) {
  const { scale, dx, left, width } = view;
  const unit = scale.ticks(90);
  for (let i = Math.max(0, Math.floor((left - dx) / scale.zoom / unit)); ; i++) {
    const x = dx + i * unit * scale.zoom;
    if (x > left + width + 40 || i * unit > scale.total * 1.0001) return;
    drawTick(view, base, x, view.data.duration(+(i * unit).toFixed(9), scale.total));
  }
}

/** @type {(view: Seen, base: number) => void} */
function rulerOfSteps(view, base) {
  const { surface, scale, theme, dx, left, width } = view;
  const unit = scale.ticks(60);
  for (let step = Math.max(0, Math.floor(view.from / unit) * unit); step <= view.to; step += unit) {
    if (step === 0 && unit > 1) continue; // steps count from 1
    const index = unit === 1 ? step : step - 1;
    if (scale.folds.some((fold) => fold.from <= index && index <= fold.to)) continue;
    drawTick(view, base, dx + scale.x(index), index + 1);
  }
  for (const fold of scale.folds) {
    const x = dx + ((fold.start + fold.end) / 2) * scale.zoom;
    const most = fold.to - fold.from;
    if (most < 3 && (fold.end - fold.start) * scale.zoom < 16) continue; // no room to say how many
    if (x > left - 30 && x < left + width + 30)
      surface.text(x, base - 18, `…${most + 1}`, { fill: theme.soft, size: 9, anchor: "middle" });
  }
}

/** @type {(view: Seen, y: number) => void} */
function drawLoop(view, y) {
  const { surface, scale, theme, data, dx, left, width } = view;
  if (data.loop === null) return;
  const x = dx + scale.left(data.loop);
  const end = dx + scale.width;
  const [from, to] = [clampX(view, x), clampX(view, end)];
  const bracket = points(from, y + 13, from, y + 3, to, y + 3, to, y + 13);
  surface.path(bracket, { stroke: theme.loopInk, width: 1.6 });
  const said = `forever: ${data.loop + 1}–${data.length}`;
  const room = Math.min(end, left + width) - Math.max(x, left);
  const lettering = { fill: theme.loopInk, size: 10.5, bold: true };
  if (textWidth(said, 10.5) + 10 > room && x - left > 120)
    surface.text(x - 5, y + 14, said, { ...lettering, anchor: "end" }); // a short loop has its text before it
  else surface.text(Math.max(x, left) + 5, y + 14, said, lettering);
  if (x - dx > 200) surface.text(Math.max(dx, left) + 4, y + 14, "stem", { fill: theme.soft, size: 10.5 });
}

/** The nodes that do the steps. @type {Draw} */
export function drawStrip(view, y, height) {
  const { surface, scale, theme, data } = view;
  surface.begin("strip", "nodes", "fired by node");
  let column = -Infinity;
  for (let step = view.from; step <= view.to; step++) {
    const x = view.dx + scale.left(step);
    const width = scale.time ? 3 : scale.right(step) - scale.left(step);
    if (x + width - column < 1) continue;
    column = x + width;
    const node = data.steps[step].n;
    const fill = nodeColour(theme, data, node);
    const shown = Math.max(width - (width > 4 ? 0.6 : 0), 0.6);
    surface.rect(x, y, shown, height, { fill, opacity: node === undefined ? 0.35 : 1 });
    if (width < 13 || node === undefined) continue;
    const lettering = { fill: theme.back, size: 9, bold: true };
    surface.text(x + width / 2, y + height - 3.5, nodeLetter(data, node), { ...lettering, anchor: "middle" });
  }
  surface.end();
}

/** The whole trace in the width of the page: nodes, loop, alarms in red. @type {Draw} */
export function drawMinimap(view, y, height) {
  const { surface, theme, data, scale, width, left } = view;
  const ratio = width / scale.width;
  surface.rect(left, y, width, height, { fill: theme.panel });
  let column = -Infinity;
  for (let step = 0; step < data.length; step++) {
    const x = left + scale.x(step) * ratio;
    if (x - column < 1) continue;
    column = x;
    const fill = nodeColour(theme, data, data.steps[step].n);
    const wide = Math.max(1, scale.time ? 1 : ratio * scale.zoom);
    surface.rect(x, y + height * 0.35, wide, height * 0.65, { fill, opacity: 0.75 });
  }
  if (data.loop !== null) {
    const begin = scale.left(data.loop);
    surface.rect(left + begin * ratio, y, (scale.width - begin) * ratio, 3, { fill: theme.loopInk });
  }
  for (const step of data.alarms)
    surface.rect(left + scale.x(step) * ratio - 1, y, 2.5, height, { fill: theme.alarm });
  if (data.cause && data.cause.first >= 0) {
    const x = left + scale.left(data.cause.first) * ratio;
    const flag = points(x, y + height, x, y, x + 8, y + 4, x, y + 8);
    surface.path(flag, { stroke: theme.cause, fill: theme.cause, width: 1.6 });
  }
}
