// Pages whose nodes were arranged in an editor keep that arrangement; used by net_layout.js.
//
// NetStored.arrangement(items, header, neighbours, bendPoints)  where the items of a page go, or null where positions are missing or useless
// NetStored.line(from, to, bends)       a line between two shapes or points
"use strict";

var NetStored = (function () {
  const GAP = 14, PADDING = 18, MOST_SCALE = 3, SHARE = 0.6;

  // How far an item and its captions reach from its centre.
  function reach(item) {
    const room = item.room || [0, 0];
    return { side: Math.max(item.width, room[0]) / 2, up: item.height / 2, down: item.height / 2 + room[1] };
  }

  function overlap(a, b, one, other, gap) {
    const first = reach(a), second = reach(b);
    return Math.abs(one.x - other.x) < first.side + second.side + gap &&
      (one.y < other.y ? one.y + first.down + gap > other.y - second.up : other.y + second.down + gap > one.y - first.up);
  }

  // By how much the plane must grow for two items not to overlap.
  function neededScale(a, b) {
    const dx = Math.abs(a.position[0] - b.position[0]), dy = b.position[1] - a.position[1];
    const first = reach(a), second = reach(b);
    const across = (first.side + second.side + GAP) / dx;
    const along = (dy > 0 ? first.down + second.up + GAP : second.down + first.up + GAP) / Math.abs(dy);
    return Math.min(across, along);
  }

  function arrangement(items, header, neighbours, bendPoints) {
    const placed = [];
    for (const item of items) {
      const taken = ([x, y]) => placed.some((other) => Math.hypot(other.position[0] - x, other.position[1] - y) < 1);
      if (item.position && !taken(item.position)) placed.push(item);
    }
    if (placed.length < 2 || placed.length < SHARE * items.length) return null;
    let scale = 1;
    placed.forEach((item, index) => {
      for (let other = 0; other < index; other += 1) scale = Math.max(scale, neededScale(item, placed[other]));
    });
    if (!(scale <= MOST_SCALE)) return null;
    const at = new Map(placed.map((item) => [item.id, { x: item.position[0] * scale, y: item.position[1] * scale }]));
    for (const item of items) if (!at.has(item.id)) at.set(item.id, freePlace(item, items, at, neighbours(item.id)));
    const none = { side: 0, up: 0, down: 0 };
    const edge = (pick, side) => pick(
      ...items.map((item) => side(at.get(item.id), reach(item))),
      ...bendPoints.map(([x, y]) => side({ x: x * scale, y: y * scale }, none)),
    );
    const left = edge(Math.min, (point, room) => point.x - room.side) - PADDING;
    const top = edge(Math.min, (point, room) => point.y - room.up) - PADDING - header[1];
    const right = edge(Math.max, (point, room) => point.x + room.side) + PADDING;
    const bottom = edge(Math.max, (point, room) => point.y + room.down) + PADDING;
    for (const point of at.values()) {
      point.x -= left;
      point.y -= top;
    }
    const bends = (points) => (points || []).map(([x, y]) => [x * scale - left, y * scale - top]);
    return { at, bends, width: Math.max(right - left, header[0]), height: bottom - top };
  }

  // The nearest place to an item's neighbours where it overlaps nothing.
  function freePlace(item, items, at, neighbours) {
    const near = neighbours.map((id) => at.get(id)).filter(Boolean);
    const from = near.length ? near : [...at.values()];
    const centre = { x: from.reduce((sum, one) => sum + one.x, 0) / from.length, y: from.reduce((sum, one) => sum + one.y, 0) / from.length };
    for (let ring = 0; ring < 200; ring += 1) {
      for (let turn = 0; turn < 8 * ring || turn < 1; turn += 1) {
        const angle = (2 * Math.PI * turn) / Math.max(8 * ring, 1);
        const point = { x: centre.x + 12 * ring * Math.cos(angle), y: centre.y + 12 * ring * Math.sin(angle) };
        if (!items.some((other) => at.has(other.id) && overlap(item, other, point, at.get(other.id), GAP))) return point;
      }
    }
    return centre;
  }

  // Where the line from an item's centre to another point leaves its shape.
  function border(item, x, y, other) {
    if (!item) return [x, y];
    const dx = other[0] - x, dy = other[1] - y, distance = Math.hypot(dx, dy);
    if (!distance) return [x, y];
    const part = /^place/.test(item.kind)
      ? item.width / 2 / distance
      : Math.min(dx ? item.width / 2 / Math.abs(dx) : Infinity, dy ? item.height / 2 / Math.abs(dy) : Infinity);
    return [x + dx * Math.min(part, 1), y + dy * Math.min(part, 1)];
  }

  // from and to: {x, y, item}, the item absent for a port; aside shifts one of several lines between the same two.
  function line(from, to, bends, aside) {
    const length = Math.hypot(to.x - from.x, to.y - from.y) || 1;
    const [dx, dy] = [(-(to.y - from.y) / length) * aside, ((to.x - from.x) / length) * aside];
    const points = [[from.x + dx, from.y + dy], ...bends, [to.x + dx, to.y + dy]];
    const last = points.length - 1;
    const start = border(from.item, from.x + dx, from.y + dy, points[1]);
    const end = border(to.item, to.x + dx, to.y + dy, points[last - 1]);
    points[0] = start;
    points[last] = end;
    return points;
  }

  return { arrangement, line };
})();
