// Lines between things that have their place: straight where nothing stands in the way, around what does; and where
// their labels go. Used by net_layout.js.
//
// NetLines.border(end, other)           where the line from the end of another, in an item, leaves its shape
// NetLines.crosses(one, other, area)    whether a piece of a line passes through an area
// NetLines.route(from, to, obstacles, turns)  the points of a line; turns counts the lines that turn at each obstacle
// NetLines.label(points, room, taken, lines)  the middle of a label; taken are areas it must not cover
//
// An end is {x, y, item, middle: [x, y]}, or {x, y, out: [dx, dy]} for a port; an area is [left, top, right, bottom].
"use strict";

var NetLines = (function () {
  const CLEAR = 6, APART = 4, BESIDE = 4, STUB = 8, TURN = 30, LONG = 30;

  const atCorner = (area, [x, y]) => (x === area[0] || x === area[2]) && (y === area[1] || y === area[3]);
  const grown = (area, by) => [area[0] - by, area[1] - by, area[2] + by, area[3] + by];
  const inside = (area, [x, y]) => x > area[0] && x < area[2] && y > area[1] && y < area[3];

  // Whether a piece of a line passes through an area.
  function crosses([x1, y1], [x2, y2], area) {
    let from = 0, to = 1;
    for (const [start, delta, low, high] of [[x1, x2 - x1, area[0], area[2]], [y1, y2 - y1, area[1], area[3]]]) {
      if (Math.abs(delta) < 1e-9) {
        if (start <= low || start >= high) return false;
      } else {
        const one = (low - start) / delta, other = (high - start) / delta;
        from = Math.max(from, Math.min(one, other));
        to = Math.min(to, Math.max(one, other));
      }
    }
    return to - from > 1e-9;
  }

  function holds(item, dx, dy) {
    const wide = item.width / 2, high = item.height / 2;
    if (/^place/.test(item.kind)) return dx * dx + dy * dy <= wide * wide;
    if (Math.abs(dx) > wide || Math.abs(dy) > high) return false;
    if (item.kind === "topic") {
      const round = Math.abs(dx) - (wide - high);
      return round <= 0 || round * round + dy * dy <= high * high;
    }
    return item.kind !== "service" || wide - Math.abs(dx) >= 12 * Math.abs(dy) / high;
  }

  function border({ x, y, item, middle }, other) {
    let low = 0, high = 1;
    const dx = other[0] - x, dy = other[1] - y;
    const within = (part) => holds(item, x + dx * part - middle[0], y + dy * part - middle[1]);
    if (within(1)) return other;
    for (let round = 0; round < 24; round += 1) {
      const part = (low + high) / 2;
      if (within(part)) low = part; else high = part;
    }
    return [x + dx * low, y + dy * low];
  }

  function route(from, to, obstacles, turns) {
    const ends = [from, to].map((end) => [end.x + (end.out ? end.out[0] * STUB : 0), end.y + (end.out ? end.out[1] * STUB : 0)]);
    // What stands too close to an end is passed closer; what covers it cannot be avoided.
    // Lines that turn at the same corner do so beside each other.
    const clear = (area) => [CLEAR + APART * ((turns.get(String(area)) || 0) % BESIDE), CLEAR, 2, 0];
    const walls = [];
    for (const area of obstacles) {
      const wall = clear(area).map((by) => grown(area, by)).find((one) => !ends.some((end) => inside(one, end)));
      if (wall) walls.push(Object.assign(wall, { area }));
    }
    const active = [];
    let path = ends;
    for (let round = 0; round < 40; round += 1) {
      const met = walls.filter((wall) => !active.includes(wall) && path.some((point, index) => index && crosses(path[index - 1], point, wall)));
      if (!met.length) break;
      active.push(...met);
      const found = shortest(ends, active);
      if (!found) break;
      path = found;
    }
    for (const { area } of active.filter((wall) => path.slice(1, -1).some((point) => atCorner(wall, point)))) turns.set(String(area), (turns.get(String(area)) || 0) + 1);
    const points = [...(from.out ? [[from.x, from.y]] : []), ...path, ...(to.out ? [[to.x, to.y]] : [])];
    if (from.item) points[0] = border(from, points[1]);
    const last = points.length - 1;
    if (to.item) points[last] = border(to, points[last - 1]);
    return points;
  }

  // The shortest way from one point to another along corners of the areas, by Dijkstra's algorithm.
  function shortest([start, end], walls) {
    const corners = walls.flatMap(([left, top, right, bottom]) => [[left, top], [right, top], [left, bottom], [right, bottom]]);
    const points = [start, end, ...corners.filter((corner) => !walls.some((wall) => inside(wall, corner)))];
    const length = points.map(() => Infinity), before = [], done = new Set();
    length[0] = 0;
    for (;;) {
      let best = -1;
      for (let index = 0; index < points.length; index += 1) {
        if (!done.has(index) && length[index] < Infinity && (best < 0 || length[index] < length[best])) best = index;
      }
      if (best < 0) return null;
      if (best === 1) break;
      done.add(best);
      for (let next = 1; next < points.length; next += 1) {
        if (done.has(next)) continue;
        const there = length[best] + Math.hypot(points[next][0] - points[best][0], points[next][1] - points[best][1]) + TURN;
        if (there < length[next] && !walls.some((wall) => crosses(points[best], points[next], wall))) {
          length[next] = there;
          before[next] = best;
        }
      }
    }
    const path = [];
    for (let index = 1; index !== undefined; index = before[index]) path.unshift(points[index]);
    return path;
  }

  const covered = (one, other) => Math.max(0, Math.min(one[2], other[2]) - Math.max(one[0], other[0])) * Math.max(0, Math.min(one[3], other[3]) - Math.max(one[1], other[1]));

  // On or beside the line, near its middle, off other things and, where possible, off other lines.
  function label(points, [wide, high], taken, lines) {
    const pieces = points.slice(1).map((point, index) => ({ from: points[index], to: point, length: Math.hypot(point[0] - points[index][0], point[1] - points[index][1]) }));
    const whole = pieces.reduce((sum, piece) => sum + piece.length, 0);
    let best = null, least = Infinity;
    for (let part = 0.5, index = 0; index <= 20; index += 1) {
      part = 0.5 + (index % 2 ? 1 : -1) * Math.ceil(index / 2) * 0.044;
      let rest = whole * part, piece = pieces[0];
      for (piece of pieces) {
        if (rest <= piece.length) break;
        rest -= piece.length;
      }
      const by = piece.length ? Math.min(1, rest / piece.length) : 0;
      const x = piece.from[0] + (piece.to[0] - piece.from[0]) * by, y = piece.from[1] + (piece.to[1] - piece.from[1]) * by;
      // A long text is read better above its line than on it.
      for (const [off, cost] of [[0, wide > LONG ? 12 : 0], [1, 6], [-1, 8], [2, 14], [-2, 16], [3, 22], [-3, 24]]) {
        // Square to the line, as far as the label reaches in that direction.
        const up = piece.to[0] < piece.from[0] ? -1 : 1, along = up / (piece.length || 1);
        const dx = (piece.to[1] - piece.from[1]) * along, dy = -(piece.to[0] - piece.from[0]) * along;
        const far = off * (Math.abs(dx) * wide / 2 + Math.abs(dy) * high / 2 + 2);
        const area = [x + dx * far - wide / 2, y + dy * far - high / 2, x + dx * far + wide / 2, y + dy * far + high / 2];
        let total = cost + Math.abs(part - 0.5) * 20;
        if (total < least) total += 50 * taken.reduce((sum, other) => sum + covered(area, other), 0);
        if (total < least) total += 12 * lines.filter((line) => line !== points && line.some((point, at) => at && crosses(line[at - 1], point, area))).length;
        if (total < least) [best, least] = [[x + dx * far, y + dy * far], total];
      }
    }
    return best;
  }

  return { border, crosses, route, label };
})();
