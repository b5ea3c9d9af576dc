// Where lines meet the shapes they lead to.

/** @import { Box, Point } from "../types.js" */

/** @type {(box: Box) => Point} */
export const middle = (box) => ({ x: box.x + box.width / 2, y: box.y + box.height / 2 });

/**
 * The points of a line between two shapes, over bend points, cut off where the shapes begin.
 *
 * @type {(from: Box, to: Box, bends: Point[]) => Point[]}
 */
export function route(from, to, bends) {
  const all = [middle(from), ...bends, middle(to)];
  const last = all.length - 1;
  all[0] = border(from, all[1]);
  all[last] = border(to, last > 1 ? all[last - 1] : middle(from));
  return all;
}

/** The point of a shape's border in the direction of another point; squares are circles. @type {(box: Box, towards: Point) => Point} */
export function border(box, towards) {
  const centre = middle(box);
  const [dx, dy] = [towards.x - centre.x, towards.y - centre.y];
  if (dx === 0 && dy === 0) return centre;
  const share =
    box.width === box.height
      ? box.width / 2 / Math.hypot(dx, dy)
      : Math.min(
          dx === 0 ? Number.POSITIVE_INFINITY : box.width / 2 / Math.abs(dx),
          dy === 0 ? Number.POSITIVE_INFINITY : box.height / 2 / Math.abs(dy),
        );
  return { x: centre.x + dx * Math.min(1, share), y: centre.y + dy * Math.min(1, share) };
}
