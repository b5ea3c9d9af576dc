// The captions of arranged nodes: below them as everywhere else, unless their own lines go through there and another
// side is free. Used by net_layout.js.
//
// NetCaptions.area(node)                  the rectangle around a node and its captions: [left, top, right, bottom]
// NetCaptions.choose(picture, plan, lines, paths)  moves captions: gives nodes `captionAt`, by how much, and a new glyph
"use strict";

var NetCaptions = (function () {
  const OWN = 10, OTHER = 3, SIDES = ["below", "above", "right", "left"];

  function caption(node, [dx, dy]) {
    const [wide, down] = node.room || [0, 0], top = node.y + node.height / 2 + dy;
    return [node.x + dx - wide / 2, top, node.x + dx + wide / 2, top + down];
  }

  const area = (node) => around(node, node.captionAt || [0, 0]);

  function around(node, at) {
    const shape = [node.x - node.width / 2, node.y - node.height / 2, node.x + node.width / 2, node.y + node.height / 2];
    if (!node.room || !node.room[0]) return shape;
    const text = caption(node, at);
    return [Math.min(shape[0], text[0]), Math.min(shape[1], text[1]), Math.max(shape[2], text[2]), Math.max(shape[3], text[3])];
  }

  function shift(node, side) {
    const [wide, down] = node.room, middle = -(node.height + down) / 2 - 1, aside = (node.width + wide) / 2 + 1;
    return { below: [0, 0], above: [0, -node.height - down - 2], right: [aside, middle], left: [-aside, middle] }[side];
  }

  const meet = (one, other) => one[0] < other[2] && other[0] < one[2] && one[1] < other[3] && other[1] < one[3];

  function choose(picture, plan, lines, paths) {
    const nodes = new Map(picture.nodes.map((node) => [node.id, node]));
    const boxes = new Map(picture.boxes.map((box) => [box.id, [box.x, box.y, box.x + box.width, box.y + box.height]]));
    for (const sheet of plan.sheets.values()) {
      if (!sheet.arranged) continue;
      const frame = sheet.box ? boxes.get(sheet.id) : [0, 0, picture.width, picture.height];
      const title = sheet.box ? [[frame[0], frame[1], frame[0] + sheet.box.header[0], frame[1] + sheet.box.header[1]]] : [];
      const near = [
        ...lines.filter((line) => line.sheets.includes(sheet)),
        ...sheet.edges.map(({ id, sources: [source], targets: [target] }) => ({ source, target, points: paths.get(id).points })),
      ];
      for (const { id } of sheet.members) {
        const node = nodes.get(id);
        if (!node || !node.room || !node.room[0]) continue;
        const others = [...title, ...sheet.members.filter((other) => other.id !== id).map((other) => boxes.get(other.id) || area(nodes.get(other.id)))];
        const cost = (side, rank) => {
          const text = caption(node, shift(node, side)), all = around(node, shift(node, side));
          const marked = (node.change || node.badge) && (side === "above" || side === "left");
          const within = text[0] > frame[0] && text[1] > frame[1] && text[2] < frame[2] && text[3] < frame[3];
          if (rank && (marked || !within || others.some((other) => meet(all, other)))) return Infinity;
          return near.reduce((sum, line) => sum + (passes(line, text) ? (line.source === id || line.target === id ? OWN : OTHER) : 0), rank);
        };
        const costs = SIDES.map(cost), best = costs.indexOf(Math.min(...costs));
        if (best > 0 && costs[0] - costs[best] >= OWN / 2) move(node, shift(node, SIDES[best]));
      }
    }
  }

  // Whether a line that runs straight from end to end, or by its bends, goes through an area.
  function passes(line, text) {
    const points = line.points || [[line.sourceEnd.x, line.sourceEnd.y], ...(line.bends || []), [line.targetEnd.x, line.targetEnd.y]];
    return points.some((point, index) => index && NetLines.crosses(points[index - 1], point, text));
  }

  function move(node, [dx, dy]) {
    const number = (value) => Math.round(value * 10) / 10;
    node.captionAt = [number(dx), number(dy)];
    node.glyph = node.glyph.replace(/(<text class="[a-z]+") y="([-\d.]+)"/g, (found, start, y) =>
      `${start}${dx ? ` x="${number(dx)}"` : ""} y="${number(Number(y) + dy)}"`);
  }

  return { area, choose };
})();
