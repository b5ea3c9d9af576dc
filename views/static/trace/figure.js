// A trace as one SVG picture, for papers and for print: all chosen lanes from top to bottom, no windows.
(function (T) {
  "use strict";

  const LABELS = 232, MARGIN = 14, RULER = 34, STRIP = 15;

  /**
   * @param {object[]} views one trace, or two to compare
   * @param {{theme?: string, width?: number, time?: boolean, fold?: boolean, causes?: boolean, filter?: string, from?: number, to?: number, divergence?: object}} options
   */
  T.figure = function (views, options = {}) {
    const theme = T.themes[options.theme || "light"];
    const traces = views.map((view) => new T.Data(view));
    const surface = new T.SvgSurface();
    const { rows, height } = T.rowsOf(traces, { filter: options.filter });
    const lanes = rows.filter((row) => row.type === "lane");
    const causal = options.causes && traces.some((data) => data.cause);
    const shown = causal ? new Set(traces.flatMap((data) => [...data.causal])) : options.fold ? new Set(traces.flatMap((data, i) => [...T.stepsOf(lanes.filter((row) => row.trace === i).map((row) => row.lane))])) : null;
    const scales = traces.map((data) => new T.Scale(data, { time: options.time, shown, least: causal ? 1 : undefined }));
    const total = Math.max(...scales.map((scale) => scale.total));
    const time = scales[0].time;
    const wide = options.width || (time ? 1100 : Math.max(640, Math.min(1500, total * 15)));
    for (const scale of scales) scale.zoom = wide / total;
    const width = LABELS + wide + 2 * MARGIN;
    let y = MARGIN;
    for (const [line, bold] of titles(views)) {
      surface.text(MARGIN, y + 12, T.shorten(line, bold ? 14 : 11.5, width - 2 * MARGIN), { fill: bold ? theme.ink : theme.soft, size: bold ? 14 : 11.5, bold });
      y += bold ? 20 : 16;
    }
    const view = (number) => ({
      surface, theme, data: traces[number], scale: scales[number], dx: LABELS + MARGIN, left: LABELS + MARGIN, width: wide,
      from: 0, to: Math.max(traces[number].length - 1, 0),
    });
    surface.text(LABELS + MARGIN - 24, y + RULER - 8, time ? "wall-clock time" : "firings", { fill: theme.soft, size: 10.5, anchor: "end" });
    T.drawRuler(view(0), y, RULER);
    T.drawCauseFlag(view(0), y, RULER);
    y += RULER;
    traces.forEach((data, number) => {
      surface.text(LABELS + MARGIN - 8, y + STRIP - 4, `fired by node${traces.length > 1 ? ` ${"AB"[number]}` : ""}`, { fill: theme.soft, size: 10.5, anchor: "end" });
      if (data.length) { T.drawStrip(view(number), y, STRIP - 2); T.drawCauseBars(view(number), y + STRIP - 2); }
      y += STRIP;
    });
    y = legend(surface, traces[0], theme, LABELS + MARGIN, y + 4, wide);
    const top = y;
    T.drawGround(view(0), top, height);
    T.drawCauseLine(view(0), top, height);
    for (const row of rows) drawRow(surface, theme, row, top, width, traces.length > 1, view);
    const apart = options.divergence;
    if (apart) {
      const x = LABELS + MARGIN + scales[0].left(apart.a);
      surface.path([[x, top - 4], [x, top + height]], { stroke: theme.cursor, width: 2, dash: [6, 3] });
      surface.text(x + 4, top + 10, `first divergence: ${apart.a + 1}`, { fill: theme.cursor, size: 10.5, bold: true });
    }
    return surface.toString(width, key(surface, theme, MARGIN, top + height + 10, lanes, traces.some((data) => data.cause)) + MARGIN, theme);
  };

  function titles(views) {
    const lines = [];
    for (const view of views) {
      const what = [view.verdict, view.property].filter(Boolean).join(": ") || (view.kind === "run" ? "run" : "witness");
      lines.push([`${view.title} — ${what}`, true]);
    }
    return lines;
  }

  function legend(surface, data, theme, x, y, wide) {
    surface.begin("legend", "nodes", "");
    const start = x;
    data.nodes.forEach((node, index) => {
      const letter = T.nodeLetter(data, index);
      const room = T.textWidth(node, 10.5) + 34;
      if (x + room > start + wide && x > start) { x = start; y += 17; }
      surface.rect(x, y, 17, 12, { fill: T.nodeColour(theme, data, index) });
      surface.text(x + 8.5, y + 9.5, letter, { fill: theme.back, size: 9, anchor: "middle", bold: true });
      surface.text(x + 21, y + 10, node, { fill: theme.ink, size: 10.5 });
      x += room;
    });
    surface.end();
    return y + 20;
  }

  function drawRow(surface, theme, row, top, width, compared, view) {
    const y = top + row.y;
    if (row.type === "heading") {
      surface.rect(MARGIN, y + 3, width - 2 * MARGIN, row.height - 4, { fill: theme.panel });
      surface.text(MARGIN + 6, y + 17, row.label, { fill: theme.ink, size: 11.5, bold: true });
    } else if (row.type === "lane") {
      const lane = row.lane, middle = y + row.height / 2 + 4;
      const mark = compared ? `${"AB"[row.trace]}  ` : "";
      const note = lane.capacity ? `${lane.note} ≤ ${lane.capacity}` : lane.note;
      const double = note && row.height >= 28;
      surface.text(MARGIN + 6, double ? middle - 6 : middle, T.shorten(mark + lane.label, 11, LABELS - 16), { fill: lane.absent ? theme.soft : theme.ink, size: 11 });
      if (double) surface.text(MARGIN + 6, middle + 7, T.shorten(note, 9.5, LABELS - 16), { fill: theme.soft, size: 9.5 });
      surface.clip(LABELS + MARGIN - 6, y, width - LABELS - 2 * MARGIN + 12, row.height);
      T.drawLane(view(row.trace), lane, y, row.height);
      surface.unclip();
    } else if (row.type === "silent") {
      surface.text(MARGIN + 6, y + 13, `${row.count} ${row.group === "transitions" ? "silent" : "idle"}`, { fill: theme.soft, size: 10.5 });
    } else surface.text(MARGIN + 16, y + 13, row.label, { fill: theme.soft, size: 10.5 });
  }

  /** What the marks mean, of those that occur. */
  function key(surface, theme, x, y, lanes, causes) {
    const kinds = new Set(lanes.map((row) => row.lane.kind));
    const drops = lanes.some((row) => row.lane.marks.some((mark) => mark[0] === "d"));
    const handlers = lanes.some((row) => row.lane.kind === "transition" && row.lane.marks.some((mark) => mark[0] === "f" && mark[1]));
    const open = lanes.some((row) => row.lane.calls.some((call) => call && call.response === undefined));
    const late = lanes.some((row) => row.lane.calls.some((call) => call && call.timeouts.length));
    const at = (draw) => (place, middle) => draw(place + 7, middle);
    const items = [];
    const item = (text, draw) => items.push([text, draw]);
    if (kinds.has("queue")) {
      item("publish", at((to, middle) => surface.path(T.shapes.triangle(to, middle, true), { fill: theme.topic, closed: true })));
      item("take", at((to, middle) => surface.path(T.shapes.triangle(to, middle, false), { stroke: theme.topic, width: 1.5, closed: true })));
      item("capacity", (to, middle) => surface.path([[to, middle], [to + 15, middle]], { stroke: theme.alarm, dash: [5, 4] }));
    }
    if (drops) item("message lost", at((to, middle) => T.shapes.cross(surface, to, middle, theme)));
    if (kinds.has("client")) {
      item("client waits (C)", (to, middle) => surface.path([[to, middle + 4], [to, middle - 4], [to + 14, middle - 4], [to + 14, middle + 4]], { stroke: theme.service, width: 1.6 }));
      item("server instance works (I)", (to, middle) => surface.rect(to, middle - 4, 14, 8, { fill: theme.serviceFill }));
    }
    if (open) item("not answered", (to, middle) => surface.path([[to, middle + 4], [to, middle - 4], [to + 15, middle - 4]], { stroke: theme.service, width: 1.6, dash: [4, 3] }));
    if (late) item("waits too long", at((to, middle) => T.shapes.hourglass(surface, to, middle, theme)));
    if (kinds.has("transition")) item("fires", at((to, middle) => surface.path([[to, middle - 6], [to, middle + 6]], { stroke: theme.soft, width: 2 })));
    if (handlers) item("fires with handlers", at((to, middle) => surface.path([[to - 5, middle], [to, middle - 5], [to + 5, middle], [to, middle + 5]], { fill: theme.handler, closed: true })));
    if (causes) item("brought the outcome about", (to, middle) => surface.rect(to, middle - 1, 14, 2.4, { fill: theme.cause }));
    surface.begin("key", "key", "");
    for (const [text, draw] of items) {
      draw(x, y + 7);
      surface.text(x + 20, y + 11, text, { fill: theme.soft, size: 10.5 });
      x += T.textWidth(text, 10.5) + 38;
    }
    surface.end();
    return y + 18;
  }
})((globalThis.DinerosTrace ??= {}));
