// The canvas: a sheet of the model on diagram-js, which moves and bends nothing itself but says what is wanted.

import { describe } from "./describing.js";
import { modulesFor } from "./diagram.js";
import { onSign } from "./drawing.js";
import { route } from "./geometry.js";
import { Opened } from "./opening.js";
import { contentOf } from "./sheets.js";

/** @import { Model } from "../model.js" */
/** @import { Plane } from "./opening.js" */
/** @import { Box, CanvasElement, Command, DiagramInstance, Drawn, Point } from "../types.js" */

/**
 * What the canvas asks of the page.
 *
 * @typedef {object} Asked
 * @property {(commands: Command[], label: string) => void} act does something to the model
 * @property {(elements: string[]) => void} chosen receives the chosen elements
 * @property {(element: string | null, at: Point) => boolean} clicked receives clicks; returns whether it used this one
 * @property {(element: string) => void} opened receives double clicks
 * @property {(page: string) => void} toggled receives the page whose sign was clicked, to open it in place or to close it
 */

const LARGEST = 1.3; // a sheet of two places does not fill the window

export class Canvas {
  /** The sheet that is shown. */
  sheet = "";
  /** Where to put what no editor has put anywhere, by sheet. @type {Map<string, Map<string, Point>>} */
  computed = new Map();
  /** @type {Map<string, Box>} */
  views = new Map();
  /** The sheet and the pages that are open on it: where their points are seen. @type {Map<string, Plane>} */
  planes = new Map();
  /** The open page that stays where it is seen when something changes. @type {string | null} */
  held = null;

  /**
   * @param {HTMLElement} container
   * @param {Model} model
   * @param {Asked} asked
   */
  constructor(container, model, asked) {
    this.model = model;
    this.asked = asked;
    this.openPages = new Opened(model);
    /** @type {DiagramInstance} */
    this.diagram = new DiagramJS.Diagram({ canvas: { container }, modules: modulesFor(this) });
    this.bus = this.diagram.get("eventBus");
    this.canvas = this.diagram.get("canvas");
    this.registry = this.diagram.get("elementRegistry");
    this.selection = this.diagram.get("selection");
    const surface = container.querySelector("svg");
    surface?.setAttribute("role", "group");
    surface?.setAttribute("aria-label", "Sheet");
    this.bus.on("selection.changed", ({ newSelection }) => {
      if (!this.isDrawing) asked.chosen(newSelection.map(({ business }) => business.element));
    });
    // What is in an open page is seen to move with it.
    this.bus.on("shape.move.start", 600, ({ context }) => {
      context.shapes = [...new Set([...context.shapes, ...this.contentsOf(context.shapes)])];
    });
    // Before diagram-js chooses what was clicked.
    this.bus.on("element.click", 2000, ({ element, originalEvent }) => {
      if (element.business !== undefined && onSign(element, this.pointAt(originalEvent))) {
        asked.toggled(element.business.element);
        return false;
      }
      const used = asked.clicked(element.business?.element ?? null, this.pointAt(originalEvent));
      return used ? false : undefined;
    });
    this.bus.on("element.dblclick", ({ element, originalEvent }) => {
      if (element.business !== undefined && !onSign(element, this.pointAt(originalEvent)))
        asked.opened(element.business.element);
    });
  }

  isDrawing = false;

  /** Where something happened, on the sheet. @type {(event: MouseEvent) => Point} */
  pointAt(event) {
    const bounds = this.canvas.getContainer().getBoundingClientRect();
    const { x, y, scale } = this.canvas.viewbox();
    return { x: x + (event.clientX - bounds.left) / scale, y: y + (event.clientY - bounds.top) / scale };
  }

  /** The middle of what is seen of the sheet, or of a page that is open on it. @type {(page: string) => Point} */
  centre(page) {
    const { x, y, width, height } = this.registry.get(page) ?? this.canvas.viewbox();
    return { x: x + width / 2, y: y + height / 2 };
  }

  /** Where something new stands below everything else. @returns {Point} */
  below() {
    const shapes = this.shapes();
    if (shapes.length === 0) return { x: 120, y: 80 };
    return {
      x: Math.min(...shapes.map(({ x, width }) => x + width / 2)),
      y: Math.max(...shapes.map(({ y, height }) => y + height)) + 80,
    };
  }

  /** A point near another where nothing of a page stands. @type {(point: Point, page: string) => Point} */
  free(point, page) {
    const shapes = this.shapesOn(page);
    for (let ring = 0; ring < 40; ring += 1) {
      for (let turn = 0; turn < Math.max(1, 6 * ring); turn += 1) {
        const angle = (2 * Math.PI * turn) / Math.max(1, 6 * ring);
        const x = Math.round(point.x + 70 * ring * Math.cos(angle));
        const y = Math.round(point.y + 70 * ring * Math.sin(angle));
        const taken = shapes.some(
          (each) =>
            x > each.x - 45 &&
            x < each.x + each.width + 45 &&
            y > each.y - 40 &&
            y < each.y + each.height + 45,
        );
        if (!taken) return { x, y };
      }
    }
    return point;
  }

  /** Shows a sheet. @type {(sheet: string) => void} */
  show(sheet) {
    if (this.sheet !== sheet) {
      if (this.sheet) this.views.set(this.sheet, this.canvas.viewbox());
      this.isDrawing = true;
      this.diagram.clear();
      this.canvas.setRootElement(this.diagram.get("elementFactory").createRoot({ id: `sheet-${sheet}` }));
      this.isDrawing = false;
      this.sheet = sheet;
      this.draw();
      const view = this.views.get(sheet);
      if (view) this.canvas.viewbox(view);
      else this.fit();
    } else {
      this.draw();
    }
  }

  /** Shows the whole sheet, no larger than it is. */
  fit() {
    const shapes = this.shapes();
    const { clientWidth, clientHeight } = this.canvas.getContainer();
    const corners = shapes.length ? shapes : [{ x: 0, y: 0, width: clientWidth, height: clientHeight }];
    const box = {
      left: Math.min(...corners.map(({ x }) => x)) - 70,
      top: Math.min(...corners.map(({ y }) => y)) - 50,
      right: Math.max(...corners.map(({ x, width }) => x + width)) + 70,
      bottom: Math.max(...corners.map(({ y, height }) => y + height)) + 60,
    };
    const [across, down] = [box.right - box.left, box.bottom - box.top];
    const scale = Math.min(LARGEST, clientWidth / across, clientHeight / down) || 1;
    const [width, height] = [clientWidth / scale, clientHeight / scale];
    this.canvas.viewbox({
      x: (box.left + box.right - width) / 2,
      y: (box.top + box.bottom - height) / 2,
      width,
      height,
    });
  }

  /** Draws what the sheet shows now; what looks as before is left alone. */
  draw() {
    const held = this.registry.get(this.held ?? "")?.business;
    const { shapes, lines, planes } = contentOf(this.model, this.sheet, this.openPages, this.computed);
    this.planes = planes;
    const chosen = this.selection.get().map(({ id }) => id);
    this.isDrawing = true;
    const wanted = new Set([...shapes, ...lines].map(({ id }) => id));
    for (const old of this.registry.filter((each) => each.business !== undefined && !wanted.has(each.id))) {
      this.remove(old);
    }
    // Frames lie below lines, and lines below all other shapes: what leads past a place must not take its clicks.
    const frames = shapes.filter(({ isOpen }) => isOpen).sort((one, other) => one.depth - other.depth);
    frames.forEach((drawn, index) => {
      this.putShape(drawn, index);
    });
    const below = frames.length + this.registry.filter(({ waypoints }) => waypoints !== undefined).length;
    const others = shapes.filter(({ isOpen }) => !isOpen);
    others.forEach((drawn, index) => {
      this.putShape(drawn, below + index);
    });
    for (const drawn of lines) this.putLine(drawn, frames.length);
    this.selection.select(chosen.flatMap((id) => this.registry.get(id) ?? []));
    this.isDrawing = false;
    this.describe();
    if (held !== undefined) this.hold(held);
  }

  /** Keeps a page where it was seen, unless it was moved: what is around it may have grown. @type {(before: Drawn) => void} */
  hold({ element, stored, anchor }) {
    const now = this.registry.get(element)?.business;
    if (now === undefined || now.stored.x !== stored.x || now.stored.y !== stored.y) return;
    const [dx, dy] = [now.anchor.x - anchor.x, now.anchor.y - anchor.y];
    const view = this.canvas.viewbox();
    if (dx !== 0 || dy !== 0) this.canvas.viewbox({ ...view, x: view.x + dx, y: view.y + dy });
  }

  /** Opens a page in place, or closes it. @type {(page: string, focus: boolean) => void} */
  toggle(page, focus) {
    const known = this.registry.get(page);
    if (known?.business.isPage !== true) return;
    this.held = page;
    this.openPages.toggle(page);
    this.draw();
    this.choose(page, focus);
    const frame = this.registry.get(page);
    if (frame !== undefined && this.isOpen(page)) this.canvas.scrollToElement(frame, 10); // as far as it takes to see it
  }

  /** @type {(element: string) => boolean} */
  isOpen(element) {
    return this.planes.has(element) && element !== this.sheet;
  }

  /** The page at hand: an open one that is looked at, or that on which stands what is looked at; else the sheet. @type {(element: string | null) => string} */
  pageOf(element) {
    if (element === null || !this.model.objects.has(element)) return this.sheet;
    const page = this.isOpen(element) ? element : this.model.sheetOf(element);
    return this.planes.has(page) ? page : this.sheet;
  }

  /** @type {(old: CanvasElement) => void} */
  remove(old) {
    if (old.waypoints === undefined) {
      // Its lines have to go first.
      for (const line of this.registry.filter((each) => each.source === old || each.target === old)) {
        this.canvas.removeConnection(line);
      }
      this.canvas.removeShape(old);
    } else if (this.registry.get(old.id) === old) {
      this.canvas.removeConnection(old);
    }
  }

  /** @type {(drawn: Drawn, index: number) => void} */
  putShape(drawn, index) {
    const { at, size } = drawn;
    const box = { x: at.x - size.width / 2, y: at.y - size.height / 2, ...size };
    let known = this.registry.get(drawn.id);
    if (
      known !== undefined &&
      (known.business.isOpen !== drawn.isOpen || known.business.depth !== drawn.depth)
    ) {
      this.remove(known); // it comes back below other things, or above them
      known = undefined;
    }
    if (known === undefined) {
      const made = this.diagram.get("elementFactory").createShape({ id: drawn.id, ...box, business: drawn });
      this.canvas.addShape(made, this.canvas.getRootElement(), this.indexed(index));
    } else if (JSON.stringify([known.business, known.x, known.y]) !== JSON.stringify([drawn, box.x, box.y])) {
      Object.assign(known, box, { business: drawn });
      this.bus.fire("element.changed", { element: known });
    }
  }

  /** An index for diagram-js, which puts first what has one beyond the end. @type {(index: number) => number | undefined} */
  indexed(index) {
    return index < this.canvas.getRootElement().children.length ? index : undefined;
  }

  /** @type {(drawn: Drawn, index: number) => void} */
  putLine(drawn, index) {
    const [source, target] = [this.registry.get(drawn.from), this.registry.get(drawn.to)];
    if (source === undefined || target === undefined) return;
    const waypoints = route(source, target, drawn.bends);
    const known = this.registry.get(drawn.id);
    if (known !== undefined && (known.source !== source || known.target !== target)) this.remove(known);
    const still = this.registry.get(drawn.id);
    if (still === undefined) {
      const values = { id: drawn.id, waypoints, source, target, business: drawn };
      const made = this.diagram.get("elementFactory").createConnection(values);
      this.canvas.addConnection(made, this.canvas.getRootElement(), this.indexed(index));
    } else if (JSON.stringify([still.business, still.waypoints]) !== JSON.stringify([drawn, waypoints])) {
      Object.assign(still, { waypoints, business: drawn });
      this.bus.fire("element.changed", { element: still });
    }
  }

  /** Gives all that is drawn its name and its mark. */
  describe() {
    const drawn = this.registry.filter((each) => each.business !== undefined);
    describe(this.model, drawn, (element) => this.canvas.getGraphics(element));
  }

  /** Chooses an element of the sheet. @type {(element: string | null, focus?: boolean) => void} */
  choose(element, focus = false) {
    const found = this.registry.filter(
      (each) => each.business?.element === element && each.business.isOwn,
    )[0];
    this.selection.select(found ?? null);
    if (found && focus) {
      if (!this.isSeen(found)) this.canvas.scrollToElement(found); // else everything would slide away at each click
      this.canvas.getGraphics(found).focus({ preventScroll: true });
    }
  }

  /** @type {(element: CanvasElement) => boolean} */
  isSeen({ x, y, width, height, waypoints }) {
    const view = this.canvas.viewbox();
    const points = waypoints ?? [
      { x, y },
      { x: x + width, y: y + height },
    ];
    return points.some(
      (each) =>
        each.x >= view.x &&
        each.x <= view.x + view.width &&
        each.y >= view.y &&
        each.y <= view.y + view.height,
    );
  }

  /** Elements that are chosen. @returns {string[]} */
  chosen() {
    return this.selection
      .get()
      .filter(({ business }) => business.isOwn)
      .map(({ business }) => business.element);
  }

  /** Shapes that are chosen; without lines. @returns {string[]} */
  chosenShapes() {
    const shapes = this.selection.get().filter((each) => each.waypoints === undefined);
    return shapes.map(({ business }) => business.element);
  }

  chooseAll() {
    this.selection.select(this.shapes());
  }

  /** Chooses an element too, or no more. @type {(element: string) => void} */
  chooseToo(element) {
    const found = this.registry.get(element);
    if (found === undefined) return;
    const chosen = this.selection.get();
    this.selection.select(
      chosen.includes(found) ? chosen.filter((each) => each !== found) : [...chosen, found],
    );
  }

  /** Chooses several elements of the sheet. @type {(elements: string[]) => void} */
  chooseThese(elements) {
    this.selection.select(elements.flatMap((each) => this.registry.get(each) ?? []));
  }

  shapes() {
    return this.registry.filter((each) => each.business !== undefined && each.waypoints === undefined);
  }

  /** Shapes of one page. @type {(page: string) => CanvasElement[]} */
  shapesOn(page) {
    return this.shapes().filter(({ business }) => business.page === page);
  }

  /** Commands that give elements without a place a visible one. @type {(page: string) => Command[]} */
  settled(page) {
    const loose = this.shapesOn(page).filter((each) => !this.isStored(each));
    return loose.map(({ business }) => moveTo(business.element, business.stored));
  }

  /** Commands that move shapes by the same way. @type {(shapes: CanvasElement[], delta: Point) => Command[]} */
  moves(shapes, delta) {
    return this.moved(new Map(shapes.map((shape) => [shape, delta])));
  }

  /**
   * Commands that move shapes, each on its page; what is in an open page goes with that. On a page that no user has
   * arranged, everything is put where it is seen.
   *
   * @type {(shifts: Map<CanvasElement, Point>) => Command[]}
   */
  moved(shifts) {
    const elements = new Set([...shifts.keys()].map(({ business }) => business.element));
    const going = [...shifts].filter(([{ business }]) => !this.isWithin(business, elements));
    const pages = new Set(going.map(([{ business }]) => business.page));
    const moving = new Set(going.map(([{ business }]) => business.element));
    const settled = [...pages].flatMap((page) => this.settled(page));
    return [
      ...settled.filter(({ element }) => !moving.has(String(element))),
      ...going.map(([{ business }, { x, y }]) => {
        const plane = this.planes.get(business.page);
        if (plane === undefined) throw new Error("what is moved must be on a page");
        const from = plane.to(business.stored, moving);
        return moveTo(business.element, plane.from({ x: from.x + x, y: from.y + y }, moving));
      }),
    ];
  }

  /** Whether something is in one of some pages that are open. @type {(drawn: Drawn, pages: Set<string>) => boolean} */
  isWithin({ page }, pages) {
    for (let at = page; at !== this.sheet; at = this.registry.get(at)?.business.page ?? this.sheet) {
      if (pages.has(at)) return true;
    }
    return false;
  }

  /** What is in open pages among some shapes. @type {(shapes: CanvasElement[]) => CanvasElement[]} */
  contentsOf(shapes) {
    const pages = new Set(shapes.map(({ business }) => business.element));
    return this.shapes().filter(({ business }) => this.isWithin(business, pages));
  }

  /** @type {(shape: CanvasElement) => boolean} */
  isStored({ business }) {
    const graphics = this.model.link(business.element, "graphics");
    return graphics !== null && this.model.links(graphics, "positions").length > 0;
  }
}

/** @type {(element: string, point: Point) => Command} */
export const moveTo = (element, { x, y }) => ({ kind: "move", element, x: Math.round(x), y: Math.round(y) });
