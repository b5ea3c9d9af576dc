// A trace as one SVG picture, for papers and for print: all chosen lanes from top to bottom, no windows.

import { Data } from "../data.js";
import { drawCauseBars, drawCauseFlag, drawCauseLine } from "../explaining/causes.js";
import { drawGround, drawRuler, drawStrip } from "../lanes/draw.js";
import { drawLane } from "../lanes/lanes.js";
import { rowsOf } from "../lanes/rows.js";
import { isLane, Scale, stepsShown } from "../lanes/scale.js";
import { points, SvgSurface, shorten } from "../lanes/surface.js";
import { THEMES } from "../themes.js";
import { drawKey, drawNodes } from "./figure_key.js";

/** @import { Divergence, Row, Seen, ThemeName, View } from "../types.js" */
/**
 * @typedef {object} Options
 * @property {ThemeName} [theme]
 * @property {number} [width] of the lanes
 * @property {boolean} [time] by wall-clock time
 * @property {boolean} [fold] without what does not matter
 * @property {boolean} [causes] only the steps that brought the outcome about
 * @property {string} [filter]
 * @property {Divergence | null} [divergence]
 */

const LABELS = 232;
const MARGIN = 14;
const RULER = 34;
const STRIP = 15;
const LEFT = LABELS + MARGIN;

/** Draws one trace, or two to compare. @type {(views: View[], options?: Options) => string} */
export function figure(views, options = {}) {
  const theme = THEMES[options.theme ?? "light"];
  const traces = views.map((view) => new Data(view));
  const surface = new SvgSurface();
  const { rows, height } = rowsOf(traces, { filter: options.filter });
  const causes = options.causes && traces.some((data) => data.cause);
  const shown = stepsShown(traces, rows, { causes, fold: options.fold });
  const scales = traces.map(
    (data) => new Scale(data, { time: options.time, shown, least: causes ? 1 : undefined }),
  );
  const total = Math.max(...scales.map((scale) => scale.total));
  const { time } = scales[0];
  const wide = options.width ?? (time ? 1100 : Math.max(640, Math.min(1500, total * 15)));
  for (const scale of scales) scale.zoom = wide / total;
  const width = LABELS + wide + 2 * MARGIN;
  let y = MARGIN;
  for (const view of views) {
    const lettering = { fill: theme.ink, size: 14, bold: true };
    surface.text(MARGIN, y + 12, shorten(title(view), 14, width - 2 * MARGIN), lettering);
    y += 20;
  }
  const all = traces.map((data, number) => {
    const to = Math.max(data.length - 1, 0);
    return { surface, theme, data, scale: scales[number], dx: LEFT, left: LEFT, width: wide, from: 0, to };
  });
  const axis = time ? traces[0].axisOfTime : "firings";
  surface.text(LEFT - 24, y + RULER - 8, axis, { fill: theme.soft, size: 10.5, anchor: "end" });
  drawRuler(all[0], y, RULER);
  drawCauseFlag(all[0], y, RULER);
  y += RULER;
  all.forEach((view, number) => {
    const said = `fired by node${all.length > 1 ? ` ${"AB"[number]}` : ""}`;
    surface.text(LEFT - 8, y + STRIP - 4, said, { fill: theme.soft, size: 10.5, anchor: "end" });
    if (view.data.length) {
      drawStrip(view, y, STRIP - 2);
      drawCauseBars(view, y + STRIP - 2);
    }
    y += STRIP;
  });
  const top = drawNodes(surface, traces[0], theme, LEFT, y + 4, wide);
  drawGround(all[0], top, height);
  drawCauseLine(all[0], top, height);
  for (const row of rows) drawRow(all, row, top, width);
  const apart = options.divergence;
  if (apart) {
    const x = LEFT + scales[0].left(apart.a);
    const dashed = { stroke: theme.cursor, width: 2, dash: [6, 3] };
    surface.path(points(x, top - 4, x, top + height), dashed);
    const lettering = { fill: theme.cursor, size: 10.5, bold: true };
    surface.text(x + 4, top + 10, `first divergence: ${apart.a + 1}`, lettering);
  }
  const hasCauses = traces.some((data) => data.cause);
  const windows = time && traces.some((data) => data.scheduled);
  const lanes = rows.filter(isLane).map((row) => row.lane);
  const bottom = drawKey(surface, theme, MARGIN, top + height + 10, lanes, {
    causes: hasCauses,
    windows,
  });
  return surface.picture(width, bottom + MARGIN, theme);
}

/** @type {(view: View) => string} */
function title(view) {
  const kind = view.kind === "run" ? "run" : "witness";
  return `${view.title} — ${[view.verdict, view.property].filter(Boolean).join(": ") || kind}`;
}

/** @type {(views: Seen[], row: Row, top: number, width: number) => void} */
function drawRow(views, row, top, width) {
  const { surface, theme } = views[0];
  const y = top + row.y;
  const small = { fill: theme.soft, size: 10.5 };
  if (row.type === "heading") {
    surface.rect(MARGIN, y + 3, width - 2 * MARGIN, row.height - 4, { fill: theme.panel });
    surface.text(MARGIN + 6, y + 17, row.label, { fill: theme.ink, size: 11.5, bold: true });
  } else if (row.type === "lane") {
    const { lane } = row;
    const middle = y + row.height / 2 + 4;
    const mark = views.length > 1 ? `${"AB"[row.trace]}  ` : "";
    const note = lane.capacity ? `${lane.note} ≤ ${lane.capacity}` : lane.note;
    const double = note && row.height >= 28;
    const name = shorten(mark + lane.label, 11, LABELS - 16);
    const fill = lane.absent ? theme.soft : theme.ink;
    surface.text(MARGIN + 6, double ? middle - 6 : middle, name, { fill, size: 11 });
    if (double) {
      const lettering = { fill: theme.soft, size: 9.5 };
      surface.text(MARGIN + 6, middle + 7, shorten(note, 9.5, LABELS - 16), lettering);
    }
    surface.clip(LEFT - 6, y, width - LABELS - 2 * MARGIN + 12, row.height);
    drawLane(views[row.trace], lane, y, row.height);
    surface.unclip();
  } else if (row.type === "silent") {
    const word = row.group === "transitions" ? "silent" : "idle";
    surface.text(MARGIN + 6, y + 13, `${row.count} ${word}`, small);
  } else surface.text(MARGIN + 16, y + 13, row.label, small);
}
