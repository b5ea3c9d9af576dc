// The parts of diagram-js that are used, with ours in place of those that would change something themselves.

import { drawLine, drawShape, pathOf } from "./drawing.js";

/** @import { Canvas } from "./canvas.js" */
/** @import { CanvasElement, DiagramInstance, Point } from "../types.js" */

/** @type {(canvas: Canvas) => object[]} */
export function modulesFor(canvas) {
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
      const plane = canvas.planes.get(line.business.page);
      const stored = points.slice(1, -1).map((point) => plane?.from(point) ?? point);
      const bends = stored.map(({ x, y }) => [Math.round(x), Math.round(y)]);
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
