// Draws a net that layout.js has put on a plane: as markup, in pages and, for Python, in V8; and into an <svg>
// element, where marking, signals and highlights change by id without drawing again.

import { lookUp, lookUpOrAdd } from "../maps.js";
import { SIGNS } from "./words.js";

/** @import { Change, Node, Picture, PlacedBox, PlacedEdge, PlacedNode, Point } from "./types.js" */
/** @typedef {Record<string, number>} Marking  tokens by id of place */
/**
 * @typedef {object} Overlay  what is shown of a state; places and signals that are not named show their initial one
 * @property {Marking} [marking]
 * @property {Record<string, boolean | string>} [signals] values by id
 * @property {string[]} [highlights] ids of what is pointed out
 */
/** @typedef {{ marking: Map<string, number>, signals: Map<string, boolean | string>, marked: Set<string> }} Shown */
/** @typedef {{ id: string, change?: Change, badge?: string }} Signed */

/** How up to four tokens are drawn. @type {Point[][]} */
const DOTS = [
  [],
  [[0, 0]],
  [
    [-4.5, 0],
    [4.5, 0],
  ],
  [
    [0, -4.5],
    [-4.5, 4],
    [4.5, 4],
  ],
  [
    [-4.5, -4.5],
    [4.5, -4.5],
    [-4.5, 4.5],
    [4.5, 4.5],
  ],
];
/** @type {Record<string, string>} */
const ENTITIES = { "&": "&amp;", "<": "&lt;", ">": "&gt;", '"': "&quot;", "'": "&#x27;" };

/** @type {(text: string) => string} */
export const escaped = (text) => text.replace(/[&<>"']/g, (found) => ENTITIES[found]);
/** A number with at most one decimal. @type {(value: number) => string} */
export const number = (value) => String(Math.floor(value * 10 + 0.5) / 10 + 0);

/** @type {(count: number) => string} */
function tokens(count) {
  if (count < DOTS.length)
    return DOTS[count].map(([x, y]) => `<circle cx="${x}" cy="${y}" r="3.2"/>`).join("");
  const text = String(count);
  const size = text.length < 3 ? 12 : text.length < 4 ? 10 : 7;
  return `<text y="${number(size * 0.36)}" style="font-size:${size}px">${text}</text>`;
}

/** The beginning of the group of an element. @type {(classes: string, item: Signed, shown: Shown) => string} */
function named(classes, item, { marked }) {
  const all = [classes, item.change, marked.has(item.id) && "marked"].filter(Boolean).join(" ");
  return `<g class="${all}" data-id="${escaped(item.id)}">`;
}

/**
 * How an element differs from another model, and its badge.
 *
 * @type {(item: Signed, x: number, y: number) => string}
 */
function signs(item, x, y) {
  let at = x;
  let drawn = "";
  if (item.change) {
    drawn += `<g class="change ${item.change}" transform="translate(${number(at)},${number(y)})"><circle r="7"/><text y="4">${SIGNS[item.change]}</text></g>`;
    at -= 18;
  }
  if (item.badge) {
    drawn += `<g class="badge" transform="translate(${number(at)},${number(y)})"><circle r="9"/><text y="3.5">${escaped(item.badge)}</text></g>`;
  }
  return drawn;
}

/** The lettering of a box, with the values of its signals. @type {(item: PlacedBox, text: string, shown: Shown) => string} */
function lettering(item, text, { signals, marked }) {
  const named = text.replace(
    /(data-id="([^"]*)">(?:(?!<\/g>).)*?<tspan class="value">)[^<]*/g,
    (all, begin, id) => {
      const value = [...signals].find(([each]) => escaped(each) === id)?.[1];
      return typeof value === "string" ? begin + escaped(value) : all;
    },
  );
  const groups = new Map(
    item.signals?.map(({ id, initial }) => {
      const all = ["signal", (signals.get(id) ?? initial) && "true", marked.has(id) && "marked"];
      return [escaped(id), all.filter(Boolean).join(" ")];
    }),
  );
  return named.replace(
    /<g class="signal[^"]*" data-id="([^"]*)"/g,
    (_, id) => `<g class="${lookUp(groups, id)}" data-id="${id}"`,
  );
}

/** @type {(item: PlacedBox, shown: Shown) => string} */
function box(item, shown) {
  const { x, y, width, height } = item;
  const right = x + width;
  /** @type {(name: string, by: number) => string} */
  const rectangle = (name, by) =>
    `<rect class="${name}" x="${number(x - by)}" y="${number(y - by)}" width="${number(width + 2 * by)}" height="${number(height + 2 * by)}" rx="${(item.kind === "node" ? 8 : 4) + by}"/>`;
  const knob =
    `<g class="fold"><rect class="knob" x="${number(right - 18)}" y="${number(y + 6)}" width="12" height="12" rx="2"/>` +
    `<line x1="${number(right - 15)}" y1="${number(y + 12)}" x2="${number(right - 9)}" y2="${number(y + 12)}"/>` +
    (item.collapsed
      ? `<line x1="${number(right - 12)}" y1="${number(y + 9)}" x2="${number(right - 12)}" y2="${number(y + 15)}"/>`
      : "") +
    "</g>";
  const text = item.collapsed
    ? `<g transform="translate(${number(x + width / 2)},${number(y + height / 2)})">${item.glyph}</g>`
    : `<g transform="translate(${number(x)},${number(y)})">${lettering(item, item.head, shown)}</g>`;
  const classes = `box ${item.kind}${item.collapsed ? " collapsed" : ""}`;
  return `${named(classes, item, shown) + rectangle("frame", 0) + rectangle("halo", 4) + knob + text}</g>`;
}

/** @type {(item: PlacedNode, shown: Shown) => string} */
function node(item, shown) {
  let content = "";
  if (/^place/.test(item.kind)) {
    content = `<g class="tokens">${tokens(tokensOf(item, shown))}</g>`;
  }
  const wide = item.width / 2 + 4;
  const high = item.height / 2 + 4;
  const halo = `<rect class="halo" x="${number(-wide)}" y="${number(-high)}" width="${number(2 * wide)}" height="${number(2 * high)}" rx="6"/>`;
  return (
    `<g transform="translate(${number(item.x)},${number(item.y)})">` +
    named(item.kind, item, shown) +
    item.glyph +
    halo +
    content +
    "</g></g>"
  );
}

/** @type {(item: Node, shown: Shown) => number} */
const tokensOf = (item, { marking }) => marking.get(item.target ?? item.id) ?? item.tokens ?? 0;

/**
 * Arrow head, or the ring of an inhibitor arc, at the end of a line.
 *
 * @type {(points: Point[], shape: "arrow" | "ring") => string}
 */
function head(points, shape) {
  const [x, y] = points[points.length - 1];
  const [fromX, fromY] = points[points.length - 2];
  const length = Math.hypot(x - fromX, y - fromY) || 1;
  const dx = (x - fromX) / length;
  const dy = (y - fromY) / length;
  if (shape === "ring")
    return `<circle class="ring" cx="${number(x - 4 * dx)}" cy="${number(y - 4 * dy)}" r="4"/>`;
  /** @type {(side: number) => string} */
  const corner = (side) => `${number(x - 8 * dx - side * dy)},${number(y - 8 * dy + side * dx)}`;
  return `<polygon class="head" points="${number(x)},${number(y)} ${corner(3.4)} ${corner(-3.4)}"/>`;
}

/** @type {(item: PlacedEdge, shown: Shown) => string} */
function edge(item, shown) {
  const points = item.points;
  if (points.length < 2) return "";
  const line = points.map(([x, y], index) => `${index ? "L" : "M"}${number(x)} ${number(y)}`).join("");
  let drawn = `${named(`edge ${item.kind}`, item, shown)}<path d="${line}"/>`;
  if (item.kind !== "reference") drawn += head(points, item.kind === "inhibitor" ? "ring" : "arrow");
  if (item.kind === "read") drawn += head([points[1], points[0]], "arrow");
  if (item.label && item.labelAt) {
    drawn += `<text x="${number(item.labelAt[0])}" y="${number(item.labelAt[1] + 3)}">${escaped(item.label)}</text>`;
  }
  return `${drawn}</g>`;
}

/** The edge that an arc is drawn by, or else an id itself. @type {(picture: Picture, id: string) => string} */
const drawnBy = (picture, id) =>
  picture.edges.find(({ also, stands }) => also === id || stands?.includes(id))?.id ?? id;

/** What stands inside the SVG element. @type {(picture: Picture, overlay?: Overlay) => string} */
export function netMarkup(picture, { marking = {}, signals = {}, highlights = [] } = {}) {
  const shown = {
    marking: new Map(Object.entries(marking)), // an element may be called `constructor`
    signals: new Map(Object.entries(signals)),
    marked: new Set(highlights.map((id) => drawnBy(picture, id))),
  };
  const allSigns = [
    ...picture.boxes.map((item) => signs(item, item.x + item.width - 30, item.y + 1)),
    ...picture.nodes.map((item) => signs(item, item.x - item.width / 2 - 4, item.y - item.height / 2 - 2)),
    ...picture.edges
      .filter((item) => item.change && item.points.length > 1)
      .map((item) => signs(item, ...beside(item))),
  ];
  return [
    `<rect class="paper" width="${number(picture.width)}" height="${number(picture.height)}"/>`,
    ...picture.boxes.map((item) => box(item, shown)),
    ...picture.edges.map((item) => edge(item, shown)),
    ...picture.nodes.map((item) => node(item, shown)),
    ...allSigns,
  ].join("");
}

/** Where the sign of a line stands: left of its label, or on it. @type {(item: PlacedEdge) => Point} */
function beside(item) {
  if (item.label && item.labelAt) return [item.labelAt[0] - (item.room?.[0] ?? 0) / 2 - 8, item.labelAt[1]];
  return middle(item.points);
}

/** The middle of the longest piece of a line. @type {(points: Point[]) => Point} */
function middle(points) {
  let best = 0;
  let at = points[0];
  for (let i = 1; i < points.length; i += 1) {
    const [x, y] = points[i - 1];
    const [nextX, nextY] = points[i];
    const length = Math.abs(nextX - x) + Math.abs(nextY - y);
    if (length > best) {
      best = length;
      at = [(x + nextX) / 2, (y + nextY) / 2];
    }
  }
  return at;
}

/** A net that was drawn into an element. */
export class DrawnNet {
  /** @type {Map<string, SVGElement>} */
  groups = new Map();
  /** Ids of the references to a place. @type {Map<string, string[]>} */
  references = new Map();
  /** @type {Map<string, number>} */
  shown = new Map();
  /** What is pointed out, by how. @type {Map<string, SVGElement[]>} */
  marked = new Map();

  /**
   * @param {SVGSVGElement} svg
   * @param {Picture} picture
   * @param {Marking} [marking]
   */
  constructor(svg, picture, marking) {
    svg.classList.add("net");
    svg.setAttribute("viewBox", `0 0 ${number(picture.width)} ${number(picture.height)}`);
    svg.innerHTML = netMarkup(picture, { marking });
    for (const group of /** @type {NodeListOf<SVGElement>} */ (svg.querySelectorAll("[data-id]")))
      this.groups.set(group.dataset.id ?? "", group);
    for (const item of picture.edges) {
      const group = this.groups.get(item.id);
      for (const other of [item.also, ...(item.stands ?? [])])
        if (other !== undefined && group && !this.groups.has(other)) this.groups.set(other, group);
    }
    for (const { id, target } of picture.nodes)
      if (target !== undefined) lookUpOrAdd(this.references, target, () => []).push(id);
  }

  /**
   * The group of a node, box or edge, or of the collapsed box that hides it.
   *
   * @type {(id: string) => SVGElement | undefined}
   */
  element(id) {
    return this.groups.get(id);
  }

  /**
   * Shows tokens by id of place; places that are not named keep theirs.
   *
   * @type {(changes: Marking) => void}
   */
  setMarking(changes) {
    for (const [id, count] of Object.entries(changes)) {
      if (this.shown.get(id) === count) continue;
      this.shown.set(id, count);
      for (const one of [id, ...(this.references.get(id) ?? [])]) {
        const group = this.groups.get(one)?.querySelector(".tokens");
        if (group) group.innerHTML = tokens(count);
      }
    }
  }

  /** Shows values by id of signal. @type {(values: Record<string, boolean | string>) => void} */
  setSignals(values) {
    for (const [id, value] of Object.entries(values)) {
      const group = this.groups.get(id);
      const shown = group?.querySelector("tspan.value");
      if (shown) shown.textContent = String(value);
      else group?.classList.toggle("true", Boolean(value));
    }
  }

  /** Shows the states that managed nodes are in, by id of box and number. @type {(states: Record<string, number>) => void} */
  setStates(states) {
    for (const [id, state] of Object.entries(states))
      this.groups
        .get(id)
        ?.querySelectorAll(".life > .state")
        .forEach((one, number) => {
          one.classList.toggle("now", number === state);
        });
  }

  /**
   * Marks elements by id (nodes, boxes, arcs), and unmarks all others.
   *
   * @type {(ids: Iterable<string>, how?: "marked" | "near") => void}
   */
  highlight(ids, how = "marked") {
    for (const group of this.marked.get(how) ?? []) group.classList.remove(how);
    const found = [...ids].flatMap((id) => this.groups.get(id) ?? []);
    for (const group of found) group.classList.add(how);
    this.marked.set(how, found);
  }
}
