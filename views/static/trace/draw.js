// How lanes, ruler, node strip and minimap look. Everything takes `view`: {surface, data, scale, theme, dx, left, width, from, to},
// where `dx` is where the trace begins on the surface, and `from`..`to` the steps that can be seen.
(function (T) {
  "use strict";

  T.HEIGHTS = { heading: 24, signal: 20, queue: 30, client: 30, transition: 18, place: 30 };

  const clampX = (view, x) => Math.max(view.left - 20, Math.min(view.left + view.width + 20, x));

  /** Calls `visit(step, mark)` for the marks of a lane that can be seen, once for each pixel when they are dense. */
  function visible(view, lane, letters, visit) {
    let column = -Infinity;
    for (let i = Math.max(0, T.lastAtMost(lane.at, view.from - 1) + 1); i < lane.at.length && lane.at[i] <= view.to; i++) {
      if (letters && !letters.includes(lane.marks[i][0])) continue;
      const x = view.dx + view.scale.x(lane.at[i]);
      if (letters && lane.marks[i][0] !== "d" && x - column < 1) continue;
      column = x;
      visit(lane.at[i], lane.marks[i], x);
    }
  }

  /** The values of a lane as [x, value] where they change, from the left edge of what is seen to the right. */
  function levels(view, lane) {
    const points = [[view.dx + view.scale.x(Math.max(view.from - 1, -1)), view.data.level(lane, view.from - 1)]];
    let first = Math.max(0, T.lastAtMost(lane.at, view.from - 1) + 1);
    for (; first < lane.at.length && lane.at[first] <= view.to; first++) {
      const x = view.dx + view.scale.x(lane.at[first]), value = lane.marks[first][1];
      const last = points[points.length - 1], before = points[points.length - 2];
      if (value === last[1]) continue;
      if (before && x - before[0] < 0.5) { // many changes in one pixel: the highest and the last of them
        before[1] = Math.max(before[1], last[1]);
        last[1] = value;
        continue;
      }
      points.push([x, value]);
    }
    const end = view.dx + (view.to >= view.data.length - 1 ? view.scale.width : view.scale.x(view.to + 1));
    points.push([end, points[points.length - 1][1]]);
    return points;
  }

  function steps(points, yOf) {
    const line = [];
    points.forEach(([x, value], i) => {
      if (i) line.push([x, yOf(points[i - 1][1])]);
      line.push([x, yOf(value)]);
    });
    return line;
  }

  function signal(view, lane, y, height) {
    const { surface, theme } = view;
    const top = y + 4, low = y + height - 4;
    const points = levels(view, lane);
    for (let i = 0; i + 1 < points.length; i++) {
      if (points[i][1]) surface.rect(points[i][0], top, points[i + 1][0] - points[i][0], low - top, { fill: theme.signalFill });
    }
    surface.path(steps(points, (value) => (value ? top : low)), { stroke: theme.signal, width: 1.6 });
  }

  const triangle = (x, y, up) => (up ? [[x - 4.5, y + 4], [x + 4.5, y + 4], [x, y - 4]] : [[x - 4.5, y - 4], [x + 4.5, y - 4], [x, y + 4]]);

  function cross(surface, x, y, theme) {
    surface.path([[x - 4, y - 4], [x + 4, y + 4]], { stroke: theme.alarm, width: 2.4 });
    surface.path([[x - 4, y + 4], [x + 4, y - 4]], { stroke: theme.alarm, width: 2.4 });
  }

  /** A request that waits too long. */
  function hourglass(surface, x, y, theme) {
    surface.path([[x - 4, y - 5], [x + 4, y - 5], [x - 4, y + 5], [x + 4, y + 5]], { fill: theme.alarm, closed: true });
  }

  /** Tokens that are left aside. */
  function bars(surface, x, y, theme) {
    for (const at of [x - 3, x + 1]) surface.rect(at, y - 5, 2.5, 10, { fill: theme.alarm });
  }

  function highest(lane) {
    let most = 1;
    for (const mark of lane.marks) if (mark[1] > most) most = mark[1];
    return most;
  }

  function queue(view, lane, y, height) {
    const { surface, theme } = view;
    const base = y + height - 4, top = y + 6;
    const most = Math.max(lane.capacity || 0, highest(lane));
    const yOf = (value) => base - ((base - top) * value) / most;
    if (lane.kind === "place" || lane.marks.some((mark) => mark[1])) {
      const points = levels(view, lane), line = steps(points, yOf);
      surface.path([...line, [line[line.length - 1][0], base], [line[0][0], base]], { fill: theme.topicFill, closed: true });
      surface.path(line, { stroke: theme.topic, width: 1.2 });
      // The number stands where the level stays long enough to be read.
      for (let i = 0; i + 1 < points.length; i++) {
        const from = Math.max(points[i][0], view.left), to = Math.min(points[i + 1][0], view.left + view.width);
        if (points[i][1] && to - from > 26) surface.text(from + 12, base - 2, points[i][1], { fill: theme.ink, size: 9.5 });
      }
    } else surface.path([[view.dx, base], [view.dx + view.scale.width, base]].map(([x, at]) => [clampX(view, x), at]), { stroke: theme.line });
    if (lane.capacity) surface.path([[view.dx, yOf(lane.capacity)], [view.dx + view.scale.width, yOf(lane.capacity)]].map(([x, at]) => [clampX(view, x), at]), { stroke: theme.alarm, dash: [5, 4], opacity: 0.75 });
    visible(view, lane, "pkd", (step, mark, x) => {
      if (mark[0] === "d") {
        cross(surface, x, y + height / 2, theme);
        if (mark[2] > 1) surface.text(x + 6, y + height / 2 + 4, mark[2], { fill: theme.alarm, size: 10, bold: true });
      } else if (mark[0] === "p") surface.path(triangle(x, y + height / 2 - 2, true), { fill: theme.topic, closed: true });
      else surface.path(triangle(x, y + height / 2 - 2, false), { fill: theme.back, stroke: theme.topic, width: 1.5, closed: true });
    });
  }

  function client(view, lane, y, height) {
    const { surface, theme, scale, data } = view;
    const top = y + 5, low = y + height - 3;
    let free = -Infinity;
    // Calls follow one another: the first that can be seen is the last that began before the window, or later.
    let first = Math.max(0, T.lastAtMost(lane.calls.map((call) => (call ? call.first : -1)), view.from) - 1);
    for (const call of lane.calls.slice(first)) {
      if (!call) continue;
      if (call.first > view.to) break;
      const answered = call.response !== undefined;
      const ended = answered || call.reply !== undefined;
      const start = call.request ?? call.serve ?? call.first;
      const stop = answered ? call.response : data.length;
      const x = view.dx + scale.x(start), end = view.dx + scale.x(stop);
      if (end < view.left - 20) continue;
      if (end - x < 1.5 && x - free < 1) continue;
      free = end;
      const dash = answered ? undefined : [4, 3];
      const left = clampX(view, x), right = clampX(view, end);
      const outline = [[left, top], [right, top]];
      if (left === x) outline.unshift([x, low]);
      if (right === end && answered) outline.push([end, low]);
      surface.path(outline, { stroke: theme.service, width: 1.6, dash });
      if (call.serve !== undefined) {
        const from = view.dx + scale.x(call.serve), to = view.dx + scale.x(call.reply !== undefined ? call.reply : data.length);
        const a = clampX(view, from), b = clampX(view, to);
        surface.rect(a, top + 4, Math.max(b - a, 1), low - top - 5, { fill: theme.serviceFill });
        if (call.reply === undefined && !ended) surface.path([[b, top + 4], [a, top + 4], [a, low - 1], [b, low - 1]], { stroke: theme.service, dash: [4, 3] });
        const text = `I${call.instance ?? "?"} C ${lane.id}`;
        const room = Math.min(b, view.left + view.width) - Math.max(a, view.left);
        const short = T.textWidth(text, 9.5) + 6 <= room ? text : `I${call.instance ?? "?"}`;
        if (T.textWidth(short, 9.5) + 4 <= room) surface.text(Math.max(a, view.left) + 3, low - 4, short, { fill: theme.ink, size: 9.5 });
      }
      for (const step of call.timeouts) hourglass(surface, view.dx + scale.x(step), top + 5, theme);
    }
  }

  function transition(view, lane, y, height) {
    const { surface, theme, scale, data } = view;
    const colour = T.nodeColour(theme, data, lane.node ?? -1);
    const middle = y + height / 2;
    surface.path([[view.dx, middle], [view.dx + scale.width, middle]].map(([x, at]) => [clampX(view, x), at]), { stroke: theme.grid, width: 1 });
    visible(view, lane, "fezu", (step, mark, x) => {
      if (mark[0] === "e") return cross(surface, x, middle, theme);
      if (mark[0] === "z") return bars(surface, x, middle, theme);
      if (mark[0] === "u") return surface.path([[x - 4, middle - 5], [x + 5, middle], [x - 4, middle + 5]], { stroke: theme.alarm, width: 1.5, closed: true });
      const took = scale.time ? (data.steps[step].d || {}).duration : 0;
      if (took) surface.rect(clampX(view, x - took * scale.zoom), middle - 3, x - clampX(view, x - took * scale.zoom), 6, { fill: theme.handler, opacity: 0.35 });
      if (mark[1]) surface.path([[x - 5, middle], [x, middle - 5], [x + 5, middle], [x, middle + 5]], { fill: theme.handler, stroke: theme.back, width: 0.8, closed: true });
      else surface.path([[x, middle - 6], [x, middle + 6]], { stroke: colour, width: 2 });
    });
  }

  const drawers = { signal, queue, client, transition, place: queue };

  T.shapes = { triangle, cross, hourglass };

  T.nodeColour = (theme, data, node) => {
    const index = typeof node === "number" ? node : data.nodes.indexOf(node);
    return index === undefined || index < 0 ? theme.soft : theme.nodes[index % theme.nodes.length];
  };

  /** One or two letters that tell a node from the others. */
  T.nodeLetter = (data, index) => {
    if (index === undefined || index < 0) return "·";
    const name = data.nodes[index];
    const unique = !data.nodes.some((other, i) => i < index && other[0].toLowerCase() === name[0].toLowerCase());
    return unique ? name[0].toUpperCase() : name[0].toUpperCase() + (name[1] || "");
  };

  T.drawLane = function (view, lane, y, height) {
    view.surface.begin(`lane ${lane.kind}`, lane.id, `${lane.label} ${lane.note || ""}`.trim());
    if (!lane.absent) drawers[lane.kind](view, lane, y, height); // otherwise only the other trace has it
    view.surface.end();
  };

  /** Backgrounds that go through all lanes: the loop, and what is folded. */
  T.drawGround = function (view, y, height) {
    const { surface, scale, theme, data } = view;
    if (data.loop !== null && data.loop !== undefined) {
      const x = clampX(view, view.dx + scale.left(data.loop)), end = clampX(view, view.dx + scale.width);
      surface.rect(x, y, end - x, height, { fill: theme.loop });
    }
    for (const fold of scale.folds) {
      const x = view.dx + fold.start * scale.zoom, end = view.dx + fold.end * scale.zoom;
      if (end < view.left || x > view.left + view.width) continue;
      surface.rect(x + 1, y, Math.max(end - x - 2, 1), height, { fill: theme.fold, opacity: 0.8 });
    }
  };

  T.drawRuler = function (view, y, height, offset = 0) {
    const { surface, scale, theme, data } = view;
    surface.begin("ruler", "ruler", "");
    const unit = scale.ticks(scale.time ? 90 : 60);
    surface.path([[view.left, y + height - 0.5], [view.left + view.width, y + height - 0.5]], { stroke: theme.line });
    const mark = (x, text) => {
      if (x < view.left - 40 || x > view.left + view.width + 40) return;
      surface.path([[x, y + height - 6], [x, y + height]], { stroke: theme.soft });
      const atEdge = x < view.left + 12;
      surface.text(atEdge ? Math.max(x, view.left + 1) : x, y + height - 8, text, { fill: theme.soft, size: 10, anchor: atEdge ? "start" : "middle" });
    };
    if (scale.time) {
      const first = Math.max(0, Math.floor((view.left - view.dx) / scale.zoom / unit));
      for (let i = first; view.dx + i * unit * scale.zoom <= view.left + view.width + 40 && i * unit <= scale.total * 1.0001; i++) mark(view.dx + i * unit * scale.zoom, T.seconds(+(i * unit).toFixed(9), scale.total));
    } else {
      const first = Math.max(0, Math.floor(view.from / unit) * unit);
      for (let step = first; step <= view.to; step += unit) {
        if (step === 0 && unit > 1) continue; // steps count from 1
        const index = unit === 1 ? step : step - 1;
        if (scale.folds.some((fold) => fold.from <= index && index <= fold.to)) continue;
        mark(view.dx + scale.x(index), index + 1);
      }
      for (const fold of scale.folds) {
        const x = view.dx + ((fold.start + fold.end) / 2) * scale.zoom;
        if (fold.to - fold.from < 3 && (fold.end - fold.start) * scale.zoom < 16) continue; // no room to say how many
        if (x > view.left - 30 && x < view.left + view.width + 30) surface.text(x, y + height - 18, `…${fold.to - fold.from + 1}`, { fill: theme.soft, size: 9, anchor: "middle" });
      }
    }
    if (data.loop !== null && data.loop !== undefined) {
      const x = view.dx + scale.left(data.loop), end = view.dx + scale.width;
      surface.path([[x, y + 13], [x, y + 3], [end, y + 3], [end, y + 13]].map(([at, line]) => [clampX(view, at), line]), { stroke: theme.loopInk, width: 1.6 });
      const said = `for ever: ${data.loop + 1}–${data.length}`, room = Math.min(end, view.left + view.width) - Math.max(x, view.left);
      const beside = T.textWidth(said, 10.5) + 10 > room && x - view.left > 120; // a short loop has its text before it
      surface.text(beside ? x - 5 : Math.max(x, view.left) + 5, y + 14, said, { fill: theme.loopInk, size: 10.5, bold: true, anchor: beside ? "end" : "start" });
      if (x - view.dx > 200) surface.text(Math.max(view.dx, view.left) + 4, y + 14, "stem", { fill: theme.soft, size: 10.5 });
    }
    surface.end();
  };

  T.drawStrip = function (view, y, height) {
    const { surface, scale, theme, data } = view;
    surface.begin("strip", "nodes", "fired by node");
    let column = -Infinity;
    for (let step = view.from; step <= view.to; step++) {
      const x = view.dx + scale.left(step);
      const width = scale.time ? 3 : scale.right(step) - scale.left(step);
      if (x + width - column < 1) continue;
      column = x + width;
      const node = data.steps[step].n;
      surface.rect(x, y, Math.max(width - (width > 4 ? 0.6 : 0), 0.6), height, { fill: T.nodeColour(theme, data, node ?? -1), opacity: node === undefined ? 0.35 : 1 });
      if (width >= 13 && node !== undefined) surface.text(x + width / 2, y + height - 3.5, T.nodeLetter(data, node), { fill: theme.back, size: 9, anchor: "middle", bold: true });
    }
    surface.end();
  };

  /** The whole trace in the width of the page: nodes, loop, alarms in red. */
  T.drawMinimap = function (view, y, height) {
    const { surface, theme, data } = view;
    const width = view.width, scale = view.scale, ratio = width / scale.width;
    const count = data.length;
    surface.rect(view.left, y, width, height, { fill: theme.panel });
    let column = -Infinity;
    for (let step = 0; step < count; step++) {
      const x = view.left + scale.x(step) * ratio;
      if (x - column < 1) continue;
      column = x;
      surface.rect(x, y + height * 0.35, Math.max(1, scale.time ? 1 : ratio * scale.zoom), height * 0.65, { fill: T.nodeColour(theme, data, data.steps[step].n ?? -1), opacity: 0.75 });
    }
    if (data.loop !== null && data.loop !== undefined) surface.rect(view.left + scale.left(data.loop) * ratio, y, (scale.width - scale.left(data.loop)) * ratio, 3, { fill: theme.loopInk });
    for (const step of data.alarms) surface.rect(view.left + scale.x(step) * ratio - 1, y, 2.5, height, { fill: theme.alarm });
    if (data.cause && data.cause.first >= 0) {
      const x = view.left + scale.left(data.cause.first) * ratio;
      surface.path([[x, y + height], [x, y], [x + 8, y + 4], [x, y + 8]], { stroke: theme.cause, fill: theme.cause, width: 1.6 });
    }
  };
})((globalThis.DinerosTrace ??= {}));
