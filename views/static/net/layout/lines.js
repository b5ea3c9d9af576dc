// Lines between things that have their place: straight where nothing is in the way, around what does; and
// where their labels go.

/** @import { Area, End, Point, Size } from "../types.js" */
/** @typedef {Area & { area: Area }} Wall  an area, and what is in it */

const CLEAR = 6;
const APART = 4;
const BESIDE = 4;
const STUB = 8;
const TURN = 30;
const LONG = 30;

/** @type {(area: Area, point: Point) => boolean} */
const atCorner = (area, [x, y]) => (x === area[0] || x === area[2]) && (y === area[1] || y === area[3]);
/** @type {(area: Area, by: number) => Area} */
const grown = (area, by) => [area[0] - by, area[1] - by, area[2] + by, area[3] + by];
/** @type {(area: Area, point: Point) => boolean} */
const inside = (area, [x, y]) => x > area[0] && x < area[2] && y > area[1] && y < area[3];

/**
 * Whether a piece of a line passes through an area.
 *
 * @type {(one: Point, other: Point, area: Area) => boolean}
 */
export function crosses([x1, y1], [x2, y2], area) {
  let from = 0;
  let to = 1;
  for (const [start, delta, low, high] of [
    [x1, x2 - x1, area[0], area[2]],
    [y1, y2 - y1, area[1], area[3]],
  ]) {
    if (Math.abs(delta) < 1e-9) {
      if (start <= low || start >= high) return false;
    } else {
      const one = (low - start) / delta;
      const other = (high - start) / delta;
      from = Math.max(from, Math.min(one, other));
      to = Math.min(to, Math.max(one, other));
    }
  }
  return to - from > 1e-9;
}

/**
 * Whether a shape covers a point, given from its centre.
 *
 * @type {(item: NonNullable<End["item"]>, dx: number, dy: number) => boolean}
 */
function holds(item, dx, dy) {
  const wide = item.width / 2;
  const high = item.height / 2;
  if (/^place/.test(item.kind)) return dx * dx + dy * dy <= wide * wide;
  if (Math.abs(dx) > wide || Math.abs(dy) > high) return false;
  if (item.kind === "topic") {
    const round = Math.abs(dx) - (wide - high);
    return round <= 0 || round * round + dy * dy <= high * high;
  }
  return item.kind !== "service" || wide - Math.abs(dx) >= (12 * Math.abs(dy)) / high;
}

/**
 * Where the line from somewhere else to an end leaves the end's shape.
 *
 * @type {(end: End, other: Point) => Point}
 */
export function borderPoint({ x, y, item, middle = [x, y] }, other) {
  if (!item) return [x, y];
  let low = 0;
  let high = 1;
  const dx = other[0] - x;
  const dy = other[1] - y;
  /** @type {(part: number) => boolean} */
  const within = (part) => holds(item, x + dx * part - middle[0], y + dy * part - middle[1]);
  if (within(1)) return other;
  for (let round = 0; round < 24; round += 1) {
    const part = (low + high) / 2;
    if (within(part)) low = part;
    else high = part;
  }
  return [x + dx * low, y + dy * low];
}

/**
 * The points of a line; `turns` counts the lines that turn at each obstacle.
 *
 * @type {(from: End, to: End, obstacles: Area[], turns: Map<string, number>) => Point[]}
 */
export function routeLine(from, to, obstacles, turns) {
  /** @type {(end: End) => Point} */
  const start = ({ x, y, out = [0, 0] }) => [x + out[0] * STUB, y + out[1] * STUB];
  /** @type {[Point, Point]} */
  const ends = [start(from), start(to)];
  // What stands too close to an end is passed closer; what covers it cannot be avoided.
  // Lines that turn at the same corner do so next to each other.
  /** @type {(area: Area) => number[]} */
  const clear = (area) => [CLEAR + APART * ((turns.get(String(area)) || 0) % BESIDE), CLEAR, 2, 0];
  /** @type {Wall[]} */
  const walls = [];
  for (const area of obstacles) {
    const wall = clear(area)
      .map((by) => grown(area, by))
      .find((one) => !ends.some((end) => inside(one, end)));
    if (wall) walls.push(Object.assign(wall, { area }));
  }
  /** @type {Wall[]} */
  const active = [];
  /** @type {Point[]} */
  let path = ends;
  for (let round = 0; round < 40; round += 1) {
    const met = walls.filter(
      (wall) =>
        !active.includes(wall) &&
        path.some((point, index) => index > 0 && crosses(path[index - 1], point, wall)),
    );
    if (!met.length) break;
    active.push(...met);
    const found = shortest(ends, active);
    if (!found) break;
    path = found;
  }
  for (const { area } of active.filter((wall) => path.slice(1, -1).some((point) => atCorner(wall, point))))
    turns.set(String(area), (turns.get(String(area)) || 0) + 1);
  const points = [...path];
  if (from.out) points.unshift([from.x, from.y]);
  if (to.out) points.push([to.x, to.y]);
  if (from.item) points[0] = borderPoint(from, points[1]);
  const last = points.length - 1;
  if (to.item) points[last] = borderPoint(to, points[last - 1]);
  return points;
}

/**
 * The shortest way from one point to another along corners of the areas, by Dijkstra's algorithm.
 *
 * @type {(ends: [Point, Point], walls: Area[]) => Point[] | null}
 */
function shortest([start, end], walls) {
  /** @type {Point[]} */
  const corners = walls.flatMap(([left, top, right, bottom]) => [
    [left, top],
    [right, top],
    [left, bottom],
    [right, bottom],
  ]);
  /** @type {Point[]} */
  const points = [start, end, ...corners.filter((corner) => !walls.some((wall) => inside(wall, corner)))];
  const length = points.map(() => Infinity);
  /** @type {number[]} */
  const before = [];
  const done = new Set();
  length[0] = 0;
  for (;;) {
    let best = -1;
    for (let index = 0; index < points.length; index += 1) {
      if (!done.has(index) && length[index] < Infinity && (best < 0 || length[index] < length[best]))
        best = index;
    }
    if (best < 0) return null;
    if (best === 1) break;
    done.add(best);
    for (let next = 1; next < points.length; next += 1) {
      if (done.has(next)) continue;
      const there =
        length[best] +
        Math.hypot(points[next][0] - points[best][0], points[next][1] - points[best][1]) +
        TURN;
      if (there < length[next] && !walls.some((wall) => crosses(points[best], points[next], wall))) {
        length[next] = there;
        before[next] = best;
      }
    }
  }
  /** @type {Point[]} */
  const path = [];
  for (let index = 1; index !== undefined; index = before[index]) path.unshift(points[index]);
  return path;
}

/** How much two areas share. @type {(one: Area, other: Area) => number} */
const covered = (one, other) =>
  Math.max(0, Math.min(one[2], other[2]) - Math.max(one[0], other[0])) *
  Math.max(0, Math.min(one[3], other[3]) - Math.max(one[1], other[1]));

/**
 * The middle of a label: on or next to its line, near its middle, off other things and, where possible, off
 * other lines.
 *
 * @type {(points: Point[], room: Size, taken: Area[], lines: Point[][]) => Point}
 */
export function placeLabel(points, [wide, high], taken, lines) {
  const pieces = points.slice(1).map((point, index) => ({
    from: points[index],
    to: point,
    length: Math.hypot(point[0] - points[index][0], point[1] - points[index][1]),
  }));
  const whole = pieces.reduce((sum, piece) => sum + piece.length, 0);
  /** @type {Point} */
  let best = points[0];
  let least = Infinity;
  for (let part = 0.5, index = 0; index <= 20; index += 1) {
    part = 0.5 + (index % 2 ? 1 : -1) * Math.ceil(index / 2) * 0.044;
    let rest = whole * part;
    let piece = pieces[0];
    for (piece of pieces) {
      if (rest <= piece.length) break;
      rest -= piece.length;
    }
    const by = piece.length ? Math.min(1, rest / piece.length) : 0;
    const x = piece.from[0] + (piece.to[0] - piece.from[0]) * by;
    const y = piece.from[1] + (piece.to[1] - piece.from[1]) * by;
    // A long text is read better above its line than on it.
    for (const [off, cost] of [
      [0, wide > LONG ? 12 : 0],
      [1, 6],
      [-1, 8],
      [2, 14],
      [-2, 16],
      [3, 22],
      [-3, 24],
    ]) {
      // Square to the line, as far as the label reaches in that direction.
      const up = piece.to[0] < piece.from[0] ? -1 : 1;
      const along = up / (piece.length || 1);
      const dx = (piece.to[1] - piece.from[1]) * along;
      const dy = -(piece.to[0] - piece.from[0]) * along;
      const far = off * ((Math.abs(dx) * wide) / 2 + (Math.abs(dy) * high) / 2 + 2);
      /** @type {Area} */
      const area = [
        x + dx * far - wide / 2,
        y + dy * far - high / 2,
        x + dx * far + wide / 2,
        y + dy * far + high / 2,
      ];
      let total = cost + Math.abs(part - 0.5) * 20;
      if (total < least) total += 50 * taken.reduce((sum, other) => sum + covered(area, other), 0);
      if (total < least)
        total +=
          12 *
          lines.filter(
            (line) =>
              line !== points && line.some((point, at) => at > 0 && crosses(line[at - 1], point, area)),
          ).length;
      if (total < least) [best, least] = [[x + dx * far, y + dy * far], total];
    }
  }
  return best;
}
