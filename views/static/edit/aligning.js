// Where shapes go that are aligned or distributed; all of it as moves, which Python does.

/** @import { Box } from "./types.js" */

/** Which side shapes are aligned at, or along which they are spread. @typedef {"left" | "centre" | "right" | "top" | "middle" | "bottom" | "across" | "down"} Way */

/**
 * How far each shape moves.
 *
 * @type {(shapes: Box[], way: Way) => { x: number, y: number }[]}
 */
export function shifts(shapes, way) {
  if (way === "across" || way === "down") return spread(shapes, way);
  const isAcross = way === "left" || way === "centre" || way === "right";
  const share = way === "left" || way === "top" ? 0 : way === "centre" || way === "middle" ? 0.5 : 1;
  const at = (/** @type {Box} */ shape) =>
    isAcross ? shape.x + share * shape.width : shape.y + share * shape.height;
  const places = shapes.map(at);
  const [low, high] = [Math.min(...places), Math.max(...places)];
  const goal = share === 0 ? low : share === 1 ? high : (low + high) / 2;
  return places.map((place) => (isAcross ? { x: goal - place, y: 0 } : { x: 0, y: goal - place }));
}

/** Equal distances between centres; the outermost two stay. @type {(shapes: Box[], way: "across" | "down") => { x: number, y: number }[]} */
function spread(shapes, way) {
  const places = shapes.map(({ x, y, width, height }) => (way === "across" ? x + width / 2 : y + height / 2));
  const order = places.map((_, index) => index).sort((one, other) => places[one] - places[other]);
  const [low, high] = [Math.min(...places), Math.max(...places)];
  const step = (high - low) / Math.max(1, shapes.length - 1);
  const found = shapes.map(() => ({ x: 0, y: 0 }));
  order.forEach((index, rank) => {
    found[index][way === "across" ? "x" : "y"] = low + rank * step - places[index];
  });
  return found;
}
