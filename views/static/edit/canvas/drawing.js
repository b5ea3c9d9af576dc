// Drawing shapes and lines as pictures of nets do; colours and dashes are those of the style sheets.

/** @import { CanvasElement, Drawn, Point, Port } from "../types.js" */

const NAMESPACE = "http://www.w3.org/2000/svg";

/** @type {(name: string, attributes: Record<string, string | number>, text?: string) => SVGElement} */
function svg(name, attributes, text) {
  const element = /** @type {SVGElement} */ (document.createElementNS(NAMESPACE, name));
  for (const [key, value] of Object.entries(attributes)) element.setAttribute(key, String(value));
  if (text !== undefined) element.textContent = text;
  return element;
}

/** Draws in a group of the canvas the shape that an element stands for. @type {(group: SVGElement, element: CanvasElement) => SVGElement} */
export function drawShape(group, element) {
  const { business, width, height } = element;
  group.setAttribute("class", `djs-visual drawn ${business.kind}${business.isOpen ? " open" : ""}`);
  const shape = outline(business, width, height);
  group.append(shape);
  if (business.isPage) group.append(sign(business.isOpen, width));
  if (business.isOpen) {
    const [words] = business.lines;
    group.append(svg("text", { class: "name", x: 10, y: 17 }, shortened(business.title, width - 20)));
    const beside = 22 + 8.2 * business.title.length;
    if (words !== undefined && beside + 5.2 * words.length < width - 24) {
      group.append(" ", svg("text", { class: "note", x: beside, y: 17 }, words));
    }
  } else if (business.kind.startsWith("place") || business.kind.startsWith("transition")) {
    captions(group, business, width / 2, height);
    if (business.tokens !== 0) tokens(group, business.tokens, width / 2, height / 2);
  } else {
    const lines = [business.title, ...business.lines];
    lines.forEach((text, index) => {
      const y = height / 2 + 13 * (index - (lines.length - 1) / 2) + 4;
      group.append(
        " ", // between words that are read aloud
        svg("text", { class: index === 0 ? "name" : "note", x: width / 2, y }, shortened(text, width)),
      );
    });
  }
  return shape;
}

const SIGN = 13; // its width and height
const EDGE = 4; // how far from the corner it is

/** The sign in the corner of a page that a click opens or closes it by. @type {(isOpen: boolean, width: number) => SVGElement} */
function sign(isOpen, width) {
  const group = svg("g", { class: "sign", transform: `translate(${width - SIGN - EDGE} ${EDGE})` });
  const bars = isOpen ? "M3.5 6.5h6" : "M3.5 6.5h6M6.5 3.5v6";
  group.append(
    svg("rect", { class: "knob", width: SIGN, height: SIGN, rx: 2 }),
    svg("path", { class: "bars", d: bars }),
  );
  return group;
}

/** Whether a point of the sheet is on the sign of a page. @type {(element: CanvasElement, at: Point) => boolean} */
export const onSign = ({ business, x, y, width }, at) =>
  business.isPage &&
  at.x >= x + width - SIGN - 2 * EDGE &&
  at.x <= x + width &&
  at.y >= y &&
  at.y <= y + SIGN + 2 * EDGE;

/** @type {(business: Drawn, width: number, height: number) => SVGElement} */
function outline({ kind }, width, height) {
  if (kind.startsWith("place")) {
    return svg("circle", { class: "shape", cx: width / 2, cy: height / 2, r: width / 2 - 1 });
  }
  if (kind === "service" || kind === "action") {
    const half = height / 2;
    const corners = [0, half, 12, 0, width - 12, 0, width, half, width - 12, height, 12, height];
    return svg("polygon", { class: "shape", points: corners.join(" ") });
  }
  const radius = kind === "topic" ? height / 2 : kind.startsWith("transition") ? 1 : 3;
  return svg("rect", { class: "shape", width, height, rx: radius });
}

/** @type {(text: string, width: number) => string} */
const shortened = (text, width) => {
  const most = Math.floor((width - 8) / 6);
  return text.length > most ? `${text.slice(0, most - 1)}…` : text;
};

/** @type {(group: SVGElement, business: Drawn, x: number, top: number) => void} */
function captions(group, { title, lines, kind }, x, top) {
  group.append(svg("text", { class: "name", x, y: top + 13 }, title));
  lines.forEach((line, index) => {
    group.append(
      svg("text", { class: kind === "transition" ? "clause" : "note", x, y: top + 25 + 11 * index }, line),
    );
  });
}

/** Where so many tokens are in a place. */
const SPOTS = ["0,0", "-5,0 5,0", "-5,3 5,3 0,-5", "-5,-5 5,-5 -5,5 5,5"].map((spots) =>
  spots.split(" ").map((spot) => spot.split(",").map(Number)),
);

/** @type {(group: SVGElement, count: number, x: number, y: number) => void} */
function tokens(group, count, x, y) {
  const marks = svg("g", { class: "tokens" });
  if (count > 0 && count <= 4) {
    for (const [dx, dy] of SPOTS[count - 1]) marks.append(svg("circle", { cx: x + dx, cy: y + dy, r: 3 }));
  } else {
    marks.append(svg("text", { x, y: y + 4 }, String(count)));
  }
  group.append(marks);
}

/** @type {(group: SVGElement, element: CanvasElement) => SVGElement} */
export function drawLine(group, { business, waypoints }) {
  group.setAttribute("class", `djs-visual drawn edge ${business.kind}${business.isOwn ? "" : " of-others"}`);
  const path = svg("path", { d: pathOf(waypoints) });
  group.append(path);
  const [before, end] = waypoints.slice(-2);
  if (business.kind === "inhibitor") group.append(ring(before, end));
  else if (business.kind !== "reference") group.append(head(before, end));
  if (business.kind === "read") group.append(head(waypoints[1], waypoints[0])); // it takes and gives back
  if (business.ports.length > 0) group.append(port(business, waypoints));
  if (business.weight !== 1) {
    const [one, other] = waypoints.slice(Math.floor((waypoints.length - 1) / 2));
    const label = { x: (one.x + other.x) / 2, y: (one.y + other.y) / 2 - 5 };
    group.append(svg("text", { ...label, class: "weight" }, String(business.weight)));
  }
  return path;
}

/** Moves and turns what is drawn at the end of a line. @type {(before: Point, end: Point) => string} */
function at(before, end) {
  const angle = (Math.atan2(end.y - before.y, end.x - before.x) * 180) / Math.PI;
  return `translate(${end.x} ${end.y}) rotate(${angle})`;
}

/** @type {(before: Point, end: Point) => SVGElement} */
const head = (before, end) =>
  svg("path", { class: "head", d: "M0 0 L-9 -3.6 L-9 3.6 Z", transform: at(before, end) });

/** @type {(before: Point, end: Point) => SVGElement} */
const ring = (before, end) =>
  svg("circle", { class: "ring", cx: -4, cy: 0, r: 4, transform: at(before, end) });

/** The end of a topic at its place: a box with the limit of the queue; of several, the smallest. @type {(business: Drawn, waypoints: Point[]) => SVGElement} */
function port({ ports, kind }, waypoints) {
  const isOut = kind === "publish";
  const [end, next] = isOut ? waypoints : [...waypoints].reverse();
  const length = Math.hypot(next.x - end.x, next.y - end.y) || 1;
  const away = Math.min(16, length / 3);
  const x = end.x + ((next.x - end.x) / length) * away;
  const y = end.y + ((next.y - end.y) / length) * away;
  const limits = ports.map(({ limit }) => limit);
  const text = `${Math.min(...limits)}${new Set(limits).size > 1 ? "…" : ""}`;
  const names = ["port", ports.some(({ isBestEffort }) => isBestEffort) && "best-effort"];
  const group = svg("g", {
    class: [...names, ports.some(({ isKept }) => isKept) && "kept"].filter(Boolean).join(" "),
  });
  const width = 8 + 6 * text.length;
  group.append(
    svg("title", {}, ports.map((each) => inShort(each)).join("\n")),
    svg("rect", { x: x - width / 2, y: y - 7, width, height: 14, rx: 2 }),
    svg("text", { x, y: y + 3.5 }, text),
  );
  return group;
}

/** How many messages wait at the end of a topic at most, and what is promised of them. @type {(port: Port) => string} */
export const inShort = ({ limit, isBestEffort, isKept, times }) =>
  [`≤${limit}`, isBestEffort && "best effort", isKept && "kept for late joiners", ...times]
    .filter(Boolean)
    .join(", ");

/** @type {(points: Point[]) => string} */
export const pathOf = (points) => points.map(({ x, y }, index) => `${index ? "L" : "M"}${x} ${y}`).join(" ");
