// Pages that are open in place: which, by this tab alone, and where what is in them goes.
//
// An open page makes the strips of the plane in which it stands as wide as what is in it needs, and moves on what
// is beyond, as pictures of nets do (net/layout/stored.js): order is kept, and nothing comes nearer to anything.

import { stretched } from "../../net/layout/stored.js";

/** @import { Model } from "../model.js" */
/** @import { Drawn, Extent, Opening, Point } from "../types.js" */

/** Between the frame of a page and what is in it. */
const PADDING = 22;
const HEADER = 24;
const LEAST = { width: 150, height: 90 };

/** What is open, kept for as long as the tab is. */
export class Opened {
  /** The element of the contents at the place of the closed page; null: not yet determined. @type {Map<string, Point | null>} */
  pages = new Map();

  /** @param {Model} model */
  constructor(model) {
    this.model = model;
  }

  /** @type {(page: string) => boolean} */
  has(page) {
    return this.pages.has(page);
  }

  /** Opens a page, or closes it. @type {(page: string) => void} */
  toggle(page) {
    if (!this.pages.delete(page)) this.pages.set(page, null);
    const ids = [...this.pages.keys()].filter((each) => this.model.objects.has(each));
    sessionStorage.setItem(this.key(), JSON.stringify(ids.map((each) => this.model.value(each, "id"))));
  }

  /** Puts the middle of what is in an open page where the page stands. @type {(page: string) => void} */
  centre(page) {
    if (this.pages.has(page)) this.pages.set(page, null);
  }

  /** Opens what was open, when the model was read again: by ids, since handles are others then. */
  recall() {
    const ids = new Set(JSON.parse(sessionStorage.getItem(this.key()) ?? "[]"));
    const pages = this.model.all("pn.Page").filter((each) => ids.has(this.model.value(each, "id")));
    this.pages = new Map(pages.map((each) => [each, null]));
  }

  key() {
    return `open pages of ${this.model.state.file}`;
  }
}

/** Where points of a page are seen, and which point of it is seen where; the page's own stretching included. */
export class Plane {
  /**
   * @param {Opening[]} openings the open pages on this one
   * @param {Point} shift where the page's own plane begins, on the sheet
   */
  constructor(openings, shift) {
    this.openings = openings;
    this.shift = shift;
  }

  /** @type {(axis: "x" | "y", without?: Set<string>) => (value: number) => number} */
  along(axis, without) {
    const open = this.openings.filter(({ page }) => !without?.has(page));
    return stretched(open.flatMap((opening) => opening[axis]));
  }

  /**
   * Where a point is seen.
   *
   * @param {Point} point
   * @param {Set<string>} [without] open pages that are taken as if they were closed
   * @returns {Point}
   */
  to({ x, y }, without) {
    return {
      x: this.along("x", without)(x) + this.shift.x,
      y: this.along("y", without)(y) + this.shift.y,
    };
  }

  /** Which point is seen there. @type {(point: Point, without?: Set<string>) => Point} */
  from({ x, y }, without) {
    return {
      x: turned(this.along("x", without), x - this.shift.x),
      y: turned(this.along("y", without), y - this.shift.y),
    };
  }
}

/** Where a map that grows everywhere, by as much as its argument at least, has a value. @type {(map: (value: number) => number, wanted: number) => number} */
function turned(map, wanted) {
  let [low, high] = [wanted - (map(wanted) - wanted) - 1, wanted];
  if (map(high) === wanted) return high;
  for (let step = 0; step < 60; step += 1) {
    const half = (low + high) / 2;
    if (map(half) < wanted) low = half;
    else high = half;
  }
  return high;
}

/** What the strips of an open page are. @type {(page: string, at: Point, closed: { width: number, height: number }, extent: Extent) => Opening} */
export function openingOf(page, at, closed, extent) {
  const strips = (
    /** @type {number} */ value,
    /** @type {number} */ half,
    /** @type {[number, number]} */ [before, after],
  ) => [
    { from: value - half, to: value, rate: before / half - 1 },
    { from: value, to: value + half, rate: after / half - 1 },
  ];
  return {
    page,
    x: strips(at.x, closed.width / 2, [extent.left, extent.right]),
    y: strips(at.y, closed.height / 2, [extent.up, extent.down]),
  };
}

/**
 * How far the frame of an open page reaches from the point where the page stands.
 *
 * @param {Drawn} page
 * @param {Drawn[]} items what is in it, in its own plane
 * @param {Point} middle what of that plane stands where the page does
 * @param {Point | null} frame the size of a frame that is stored
 * @returns {Extent}
 */
export function extentOf(page, items, middle, frame) {
  const side = Math.max(page.size.width, LEAST.width, frame?.x ?? 0) / 2;
  const half = Math.max(page.size.height, LEAST.height, frame?.y ?? 0) / 2;
  const extent = { left: side, right: side, up: half, down: half };
  for (const { at, size, kind, title, lines } of items) {
    const [x, y] = [at.x - middle.x, at.y - middle.y];
    const hasCaption = /^(place|transition)/.test(kind);
    const widest = hasCaption ? Math.max(6.5 * title.length, ...lines.map((text) => 4.6 * text.length)) : 0;
    const side = Math.max(size.width, widest) / 2 + PADDING;
    const below = hasCaption ? 14 + 11 * lines.length : 0;
    extent.left = Math.max(extent.left, side - x);
    extent.right = Math.max(extent.right, side + x);
    extent.up = Math.max(extent.up, size.height / 2 + PADDING / 2 + HEADER - y);
    extent.down = Math.max(extent.down, size.height / 2 + PADDING / 2 + below + y);
  }
  return extent;
}

/** The middle of what is on a page. @type {(items: Drawn[]) => Point} */
export function middleOf(items) {
  if (items.length === 0) return { x: 120, y: 80 };
  const [across, down] = [items.map(({ stored }) => stored.x), items.map(({ stored }) => stored.y)];
  return {
    x: (Math.min(...across) + Math.max(...across)) / 2,
    y: (Math.min(...down) + Math.max(...down)) / 2,
  };
}

/**
 * The frame that an editor has drawn around the contents of a page, as `dineros.views.nets` reads it: its size,
 * and its centre, which is the page's position, or has that as its left upper corner; null where they are not in it.
 *
 * @type {(model: Model, page: string, items: Drawn[]) => { size: Point, centre: Point } | null}
 */
export function frameOf(model, page, items) {
  const graphics = model.link(page, "graphics");
  const given = graphics === null ? null : model.link(graphics, "dimension");
  const position = graphics === null ? null : model.link(graphics, "positions");
  if (given === null || position === null || items.length === 0) return null;
  const point = (/** @type {string} */ of) => ({
    x: Number(model.value(of, "x")),
    y: Number(model.value(of, "y")),
  });
  const [size, at] = [point(given), point(position)];
  const centres = [{ x: at.x + size.x / 2, y: at.y + size.y / 2 }, at];
  const centre = centres.find(({ x, y }) =>
    items.every(({ stored }) => Math.abs(stored.x - x) <= size.x / 2 && Math.abs(stored.y - y) <= size.y / 2),
  );
  return centre === undefined ? null : { size, centre };
}
