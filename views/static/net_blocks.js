// What has no position on a sheet that was arranged: ELK lays it out, then each group that hangs together is put in
// one piece beside the rest. Used by net_layout.js.
//
// NetBlocks.split(laid, links, items)   the groups of a graph that ELK laid out, for NetStored.place, and what is in them
// NetBlocks.move(parts, at)             moves the content of the groups to where their items were put
// NetBlocks.ports(sheet, placed)        the ports of a sheet, as high as what they lead to
"use strict";

var NetBlocks = (function () {
  const APART = 9;

  function split(laid, links, items) {
    const group = new Map(laid.children.map((child) => [child.id, child.id]));
    const root = (id) => (group.get(id) === id ? id : root(group.get(id)));
    for (const [one, other] of links) if (group.has(one) && group.has(other)) group.set(root(one), root(other));
    const parts = new Map();
    for (const child of laid.children) {
      const key = root(child.id);
      if (!parts.has(key)) parts.set(key, { children: [], edges: [] });
      parts.get(key).children.push(child);
    }
    const owner = new Map(laid.children.flatMap((child) => [[child.id, child.id], ...(child.ports || []).map((port) => [port.id, child.id])]));
    for (const edge of laid.edges || []) parts.get(root(owner.get(edge.sources[0]))).edges.push(edge);
    const blocks = [...parts.values()].map((part) => {
      const points = part.edges.filter((edge) => !edge.id.startsWith(" ")).flatMap(corners);
      for (const child of part.children) {
        const [wide, down] = items.get(child.id).room || [0, 0], middle = child.x + child.width / 2, side = Math.max(child.width, child.ports ? 0 : wide) / 2;
        points.push([middle - side, child.y], [middle + side, child.y + child.height + (child.ports ? 0 : down)]);
      }
      const [left, top, right, bottom] = [Math.min(...points.map(([x]) => x)), Math.min(...points.map(([, y]) => y)), Math.max(...points.map(([x]) => x)), Math.max(...points.map(([, y]) => y))];
      const ids = new Set(part.children.map(({ id }) => id));
      const near = links.flatMap(([one, other]) => (ids.has(one) === ids.has(other) ? [] : [ids.has(one) ? other : one]));
      const single = part.children.length === 1 && items.get(part.children[0].id).position;
      return {
        width: right - left, height: bottom - top, near, anchor: single || null,
        parts: part.children.map((child) => ({ item: items.get(child.id), x: child.x + child.width / 2 - left, y: child.y + child.height / 2 - top })),
      };
    });
    return { blocks, parts: [...parts.values()] };
  }

  function corners(edge) {
    const points = (edge.sections || []).flatMap((section) => [section.startPoint, ...(section.bendPoints || []), section.endPoint]).map(({ x, y }) => [x, y]);
    for (const label of edge.labels || []) points.push([label.x, label.y], [label.x + label.width, label.y + label.height]);
    return points;
  }

  function move(parts, at) {
    for (const { children, edges } of parts) {
      const [first] = children, centre = at.get(first.id);
      const dx = centre.x - first.x - first.width / 2, dy = centre.y - first.y - first.height / 2;
      const points = edges.flatMap((edge) => [...(edge.labels || []), ...(edge.sections || []).flatMap((section) => [section.startPoint, ...(section.bendPoints || []), section.endPoint])]);
      for (const one of [...children, ...points]) {
        one.x += dx;
        one.y += dy;
      }
    }
  }

  function ports(sheet, placed) {
    const made = [];
    for (const side of ["WEST", "EAST"]) {
      const wanted = sheet.ports.filter((port) => port.side === side).map((port) => [placed.at.get(port.via).y, port]).sort((a, b) => a[0] - b[0]);
      let above = -Infinity;
      for (const [y, port] of wanted) {
        above = Math.max(y, above + APART);
        made.push({ id: port.id, side, x: side === "WEST" ? 0 : placed.width, y: above });
      }
    }
    return made;
  }

  return { split, move, ports };
})();
