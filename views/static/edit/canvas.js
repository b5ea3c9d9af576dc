// The canvas: a sheet of the model on diagram-js, which moves and bends nothing itself but says what is wanted.

import { drawLine, drawShape, inShort, pathOf } from "./drawing.js";
import { route } from "./geometry.js";
import { contentOf } from "./sheets.js";

/** @import { Model } from "./model.js" */
/** @import { Box, CanvasElement, Command, DiagramInstance, Drawn, Point } from "./types.js" */

/**
 * What the canvas asks of the page.
 *
 * @typedef {object} Asked
 * @property {(commands: Command[], label: string) => void} act does something to the model
 * @property {(elements: string[]) => void} chosen is told what was chosen
 * @property {(element: string | null, at: Point) => boolean} clicked is told of clicks; whether it used this one
 * @property {(element: string) => void} opened is told of double clicks
 */

const LARGEST = 1.3; // a sheet of two places does not fill the window

export class Canvas {
  /** The sheet that is shown. */
  sheet = "";
  /** Where to put what no editor has put anywhere, by sheet. @type {Map<string, Map<string, Point>>} */
  computed = new Map();
  /** @type {Map<string, Box>} */
  views = new Map();

  /**
   * @param {HTMLElement} container
   * @param {Model} model
   * @param {Asked} asked
   */
  constructor(container, model, asked) {
    this.model = model;
    this.asked = asked;
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
    // Before diagram-js chooses what was clicked.
    this.bus.on("element.click", 2000, ({ element, originalEvent }) => {
      const used = asked.clicked(element.business?.element ?? null, this.pointAt(originalEvent));
      return used ? false : undefined;
    });
    this.bus.on("element.dblclick", ({ element }) => {
      if (element.business !== undefined) asked.opened(element.business.element);
    });
  }

  isDrawing = false;
  /** What was said of graphics last. @type {WeakMap<SVGGElement, string>} */
  described = new WeakMap();

  /** Where something happened, on the sheet. @type {(event: MouseEvent) => Point} */
  pointAt(event) {
    const bounds = this.canvas.getContainer().getBoundingClientRect();
    const { x, y, scale } = this.canvas.viewbox();
    return { x: x + (event.clientX - bounds.left) / scale, y: y + (event.clientY - bounds.top) / scale };
  }

  /** The middle of what is seen. @returns {Point} */
  centre() {
    const { x, y, width, height } = this.canvas.viewbox();
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

  /** A point near another where nothing stands. @type {(point: Point) => Point} */
  free(point) {
    const shapes = this.shapes();
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
    const computed = this.computed.get(this.sheet) ?? new Map();
    const { shapes, lines } = contentOf(this.model, this.sheet, computed);
    const chosen = this.selection.get().map(({ id }) => id);
    this.isDrawing = true;
    const wanted = new Set([...shapes, ...lines].map(({ id }) => id));
    for (const old of this.registry.filter((each) => each.business !== undefined && !wanted.has(each.id))) {
      this.remove(old);
    }
    let spare = 0;
    for (const drawn of shapes) {
      const at = drawn.at ?? { x: 60 + 90 * (spare % 8), y: 40 + 80 * Math.floor(spare++ / 8) };
      this.putShape(drawn, at);
    }
    for (const drawn of lines) this.putLine(drawn);
    this.selection.select(chosen.flatMap((id) => this.registry.get(id) ?? []));
    this.isDrawing = false;
    this.describe();
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

  /** @type {(drawn: Drawn, at: Point) => void} */
  putShape(drawn, at) {
    const box = { x: at.x - drawn.size.width / 2, y: at.y - drawn.size.height / 2, ...drawn.size };
    const known = this.registry.get(drawn.id);
    if (known === undefined) {
      const made = this.diagram.get("elementFactory").createShape({ id: drawn.id, ...box, business: drawn });
      this.canvas.addShape(made, this.canvas.getRootElement());
    } else if (JSON.stringify([known.business, known.x, known.y]) !== JSON.stringify([drawn, box.x, box.y])) {
      Object.assign(known, box, { business: drawn });
      this.bus.fire("element.changed", { element: known });
    }
  }

  /** @type {(drawn: Drawn) => void} */
  putLine(drawn) {
    const [source, target] = [this.registry.get(drawn.from), this.registry.get(drawn.to)];
    if (source === undefined || target === undefined) return;
    const waypoints = route(source, target, drawn.bends);
    const known = this.registry.get(drawn.id);
    if (known !== undefined && (known.source !== source || known.target !== target)) this.remove(known);
    const still = this.registry.get(drawn.id);
    if (still === undefined) {
      const values = { id: drawn.id, waypoints, source, target, business: drawn };
      const made = this.diagram.get("elementFactory").createConnection(values);
      // Below all shapes: what leads past a place must not take its clicks.
      this.canvas.addConnection(made, this.canvas.getRootElement(), 0);
    } else if (JSON.stringify([still.business, still.waypoints]) !== JSON.stringify([drawn, waypoints])) {
      Object.assign(still, { waypoints, business: drawn });
      this.bus.fire("element.changed", { element: still });
    }
  }

  /** Gives all that is drawn a role, a name, a place in the order of Tab, and its mark. */
  describe() {
    /** @type {Map<string | null, string>} */
    const worst = new Map();
    for (const { at, severity } of this.model.marks.marks) {
      for (const up of at === null ? [] : this.model.around(at)) {
        if (worst.get(up) !== "error") worst.set(up, severity);
      }
    }
    for (const { elements, severity } of this.model.findings) {
      for (const up of severity === "note" ? [] : this.model.around(elements[0] ?? "")) {
        if (worst.get(up) !== "error") worst.set(up, severity);
      }
    }
    const { enabled, fired } = played(this.model);
    for (const element of this.registry.filter((each) => each.business !== undefined)) {
      const { business } = element;
      const graphics = this.canvas.getGraphics(element);
      const mark = worst.get(business.element);
      const ends =
        element.waypoints === undefined
          ? ""
          : ` from ${element.source.business.title} to ${element.target.business.title}`;
      const isEnabled = enabled.has(business.element) && element.waypoints === undefined;
      const count = business.tokens ? `, ${business.tokens} tokens` : "";
      const { words } = this.model.kind(business.element);
      // What can be read on a shape stands in its name, for those who speak to the page (WCAG 2, 2.5.3).
      const read = /^(place|transition)/.test(business.kind) ? [] : (business.lines ?? []);
      const name = [business.title, ...read, ...(business.ports ?? []).map(inShort)].join(", ");
      const state = `${mark ? `, ${mark}` : ""}${isEnabled ? ", enabled" : ""}`;
      const says = `${words} ${name}${ends}${count}${state}`;
      graphics.classList.toggle("is-enabled", isEnabled);
      graphics.classList.toggle("is-fired", fired.has(business.element) && element.waypoints === undefined);
      graphics.classList.toggle("has-error", mark === "error");
      graphics.classList.toggle("has-warning", mark === "warning");
      if (this.described.get(graphics) === `${business.element} ${says}`) continue;
      this.described.set(graphics, `${business.element} ${says}`);
      graphics.setAttribute("role", "button");
      graphics.setAttribute("tabindex", "0");
      graphics.dataset.element = business.element;
      graphics.setAttribute("aria-label", says);
    }
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

  /** Commands that move shapes by the same way. @type {(shapes: CanvasElement[], delta: Point) => Command[]} */
  moves(shapes, delta) {
    return this.moved(new Map(shapes.map((shape) => [shape, delta])));
  }

  /**
   * Commands that move shapes; on a sheet that nobody has arranged, everything is put where it is seen.
   *
   * @type {(shifts: Map<CanvasElement, Point>) => Command[]}
   */
  moved(shifts) {
    const concerned = this.shapes().filter((each) => shifts.has(each) || !this.isStored(each));
    return concerned.map((each) => ({
      kind: "move",
      element: each.business.element,
      x: Math.round(each.x + each.width / 2 + (shifts.get(each)?.x ?? 0)),
      y: Math.round(each.y + each.height / 2 + (shifts.get(each)?.y ?? 0)),
    }));
  }

  /** @type {(shape: CanvasElement) => boolean} */
  isStored({ business }) {
    const graphics = this.model.link(business.element, "graphics");
    return graphics !== null && this.model.links(graphics, "positions").length > 0;
  }
}

/** What can be fired in the game that is played, and what was fired last, with all that they are in. @type {(model: Model) => { enabled: Set<string>, fired: Set<string> }} */
function played(model) {
  const game = model.played;
  const last = game?.steps[game.at - 1 - game.first];
  const around = (/** @type {string[]} */ elements) => elements.flatMap((each) => model.around(each));
  const firings = (game?.firings ?? []).filter(({ kind }) => kind !== "signal");
  return {
    enabled: new Set(firings.flatMap(({ elements }) => around(elements))),
    fired: new Set(around(last?.elements ?? [])),
  };
}

/** The parts of diagram-js that are used, with ours. @type {(canvas: Canvas) => object[]} */
function modulesFor(canvas) {
  class Renderer extends DiagramJS.BaseRenderer {
    /** @param {DiagramInstance["get"] extends (name: "eventBus") => infer B ? B : never} eventBus */
    constructor(eventBus) {
      super(/** @type {never} */ (eventBus), 1500);
    }
    canRender() {
      return true;
    }
    /** @type {typeof drawShape} */
    drawShape(group, element) {
      return drawShape(group, element);
    }
    /** @type {typeof drawLine} */
    drawConnection(group, element) {
      return drawLine(group, element);
    }
    /** @type {(shape: CanvasElement) => string} */
    getShapePath({ x, y, width, height }) {
      return `M${x} ${y}h${width}v${height}h${-width}z`;
    }
    /** @type {(line: CanvasElement) => string} */
    getConnectionPath({ waypoints }) {
      return pathOf(waypoints);
    }
  }
  Object.assign(Renderer, { $inject: ["eventBus"] });

  const modeling = {
    /** @type {(shapes: CanvasElement[], delta: Point) => void} */
    moveElements(shapes, delta) {
      const nodes = shapes.filter((each) => each.waypoints === undefined);
      canvas.asked.act(canvas.moves(nodes, delta), "move");
    },
    /** @type {(line: CanvasElement, points: Point[]) => void} */
    updateWaypoints(line, points) {
      const bends = points.slice(1, -1).map(({ x, y }) => [Math.round(x), Math.round(y)]);
      canvas.asked.act([{ kind: "bend", element: line.business.element, points: bends }], "bend");
    },
    /** @type {(line: CanvasElement, source: CanvasElement, target: CanvasElement) => void} */
    reconnect(line, source, target) {
      const ends = Object.entries({ source, target });
      const commands = ends.map(([feature, end]) => ({
        kind: "set",
        element: line.business.element,
        feature,
        value: end.business.element,
      }));
      canvas.asked.act(commands, "lead elsewhere");
    },
  };
  const isArc = (/** @type {CanvasElement | undefined} */ line) =>
    line?.business?.isOwn === true &&
    canvas.model.isA(canvas.model.get(line.business.element).type, "pn.Arc");
  const rules = {
    /** @type {(action: string, context: { connection?: CanvasElement, target?: CanvasElement }) => boolean} */
    allowed(action, { connection, target }) {
      if (action === "connection.updateWaypoints") return isArc(connection);
      if (action.startsWith("connection.reconnect"))
        return isArc(connection) && target?.business !== undefined;
      return action === "elements.move";
    },
  };
  return [
    {
      __init__: ["ours"],
      ours: ["type", Renderer],
      modeling: ["value", modeling],
    },
    DiagramJS.ChangeSupportModule,
    DiagramJS.MoveModule,
    DiagramJS.BendpointsModule,
    DiagramJS.LassoToolModule,
    DiagramJS.OutlineModule,
    DiagramJS.SnappingModule,
    DiagramJS.MoveCanvasModule,
    DiagramJS.ZoomScrollModule,
    { rules: ["value", rules] },
  ];
}
