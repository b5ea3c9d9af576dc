// Draws the lines of arranged sheets once everything has its place, and their labels. Used by net_layout.js.
//
// NetDrawn.route(picture, plan, sizes, found)   adds the paths of lines to those that ELK found
// NetDrawn.label(picture, plan)                 gives their labels a place off everything else
"use strict";

var NetDrawn = (function () {
  const APART = 10, NEAR = 0.4;

  const rectangle = (box) => [box.x, box.y, box.x + box.width, box.y + box.height];
  const title = (box) => [box.x, box.y, box.x + box.header[0], box.y + box.header[1]];

  function route(picture, plan, sizes, found) {
    const shapes = new Map([...picture.boxes, ...picture.nodes].map((item) => [item.id, item]));
    const nodes = new Set(picture.nodes.map((node) => node.id));
    const covers = (id) => (nodes.has(id) ? NetCaptions.area(shapes.get(id)) : rectangle(shapes.get(id)));
    const lines = [...plan.sheets.values()].flatMap((sheet) => sheet.lines);
    for (const line of lines) line.key = [line.source, line.target].sort().join("\n");
    for (const line of lines) for (const side of ["source", "target"]) line[side + "End"] = end(line[side], line, shapes, nodes, found);
    for (const line of lines) if (line.bent) line.bends = bends(line, shapes, sizes);
    NetCaptions.choose(picture, plan, lines, found.paths);
    spread(lines);
    const turns = new Map();
    for (const line of lines) {
      const from = line.sourceEnd, to = line.targetEnd;
      if (line.bent) {
        const last = line.bends[line.bends.length - 1];
        found.paths.set(line.id, { points: [NetLines.border(from, line.bends[0]), ...line.bends, NetLines.border(to, last)] });
        continue;
      }
      for (const one of [from, to]) if (one.shift) [one.x, one.y] = [one.x + one.shift[0], one.y + one.shift[1]];
      const through = new Set(line.sheets.map((sheet) => sheet.id));
      const obstacles = line.sheets.flatMap((sheet) => [
        ...(sheet.box ? [title(shapes.get(sheet.id))] : []),
        ...sheet.children.filter((id) => id !== line.source && id !== line.target && !through.has(id)).map(covers),
      ]);
      found.paths.set(line.id, { points: NetLines.route(from, to, obstacles, turns) });
    }
  }

  // Lines that come to a shape from about the same direction end beside each other, in an order that crosses none.
  function spread(lines) {
    const ends = new Map();
    for (const line of lines) {
      for (const [one, other, turn] of [[line.sourceEnd, line.targetEnd, line.source < line.target], [line.targetEnd, line.sourceEnd, line.target < line.source]]) {
        if (!one.item) continue;
        const found = { one, angle: Math.atan2(other.y - one.y, other.x - one.x), turn: turn ? 1 : -1, key: line.key };
        ends.set(one.item, [...(ends.get(one.item) || []), found]);
      }
    }
    for (const [item, found] of ends) {
      const wide = !/^(place|transition)/.test(item.kind);
      found.forEach((one, index) => { one.index = index; });
      found.sort((a, b) => (Math.abs(a.angle - b.angle) > 1e-6 ? a.angle - b.angle : (a.index - b.index) * a.turn));
      for (let first = 0, next; first < found.length; first = next) {
        for (next = first + 1; next < found.length; next += 1) {
          if (wide ? found[next].angle - found[next - 1].angle > NEAR : found[next].key !== found[first].key) break;
        }
        const group = found.slice(first, next);
        const angle = group.reduce((sum, one) => sum + one.angle, 0) / group.length, [x, y] = [-Math.sin(angle), Math.cos(angle)];
        const step = Math.min(APART, (0.75 * Math.min(item.width / Math.max(Math.abs(x), 1e-6), item.height / Math.max(Math.abs(y), 1e-6))) / group.length);
        group.forEach(({ one }, index) => {
          const by = (index - (group.length - 1) / 2) * step;
          one.shift = [x * by, y * by];
        });
      }
    }
  }

  function bends(line, shapes, sizes) {
    const [sheet] = line.sheets, { x, y } = sheet.id ? shapes.get(sheet.id) : { x: 0, y: 0 };
    const found = sizes.get(sheet.id).bent(line.edge.bends).map(([bendX, bendY]) => [bendX + x, bendY + y]);
    return line.back ? found.reverse() : found;
  }

  function end(id, line, shapes, nodes, found) {
    const item = shapes.get(id);
    if (item) {
      const [x, y] = nodes.has(id) ? [item.x, item.y] : [item.x + item.width / 2, item.y + item.height / 2];
      return { x, y, item, middle: [x, y] };
    }
    for (const sheet of line.sheets) {
      const own = sheet.ports.find((port) => port.id === id);
      if (own) return { ...found.ports.get(id), out: NetPieces.OUT[own.side].map((part) => -part) };
    }
    return { ...found.ports.get(id), out: NetPieces.OUT[found.sides.get(id)] };
  }

  function label(picture, plan) {
    const wanted = new Set([...plan.sheets.values()].flatMap((sheet) => sheet.lines).filter((line) => line.labelled).map((line) => line.edge.id));
    const around = (edge) => [edge.labelAt[0] - edge.room[0] / 2, edge.labelAt[1] - edge.room[1] / 2, edge.labelAt[0] + edge.room[0] / 2, edge.labelAt[1] + edge.room[1] / 2];
    const taken = [
      ...picture.nodes.map(NetCaptions.area),
      ...picture.boxes.map((box) => (box.collapsed ? rectangle(box) : title(box))),
      ...picture.edges.filter((edge) => edge.labelAt).map(around),
      [-1e6, -1e6, 0, 1e6], [picture.width, -1e6, 1e6, 1e6], [-1e6, -1e6, 1e6, 0], [-1e6, picture.height, 1e6, 1e6],
    ];
    const lines = picture.edges.map((edge) => edge.points);
    for (const edge of picture.edges) {
      if (!wanted.has(edge.id)) continue;
      const at = NetLines.label(edge.points, edge.room, taken, lines);
      edge.labelAt = at.map((value) => Math.round(value * 10) / 10);
      taken.push(around(edge));
    }
  }

  return { route, label };
})();
