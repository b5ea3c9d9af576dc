// The lanes on a canvas: only what the window shows is drawn, whenever something has changed.

import { byId } from "../../elements.js";
import { drawCauseBars, drawCauseFlag, drawCauseLine, drawStops } from "../explaining/causes.js";
import { fillTip } from "../explaining/detail.js";
import { drawGround, drawMinimap, drawRuler, drawStrip } from "./draw.js";
import { drawLabels } from "./labels.js";
import { drawLane } from "./lanes.js";
import { rowsOf } from "./rows.js";
import { isLane, Scale, stepsShown } from "./scale.js";
import { CanvasSurface, points } from "./surface.js";

/** @import { App } from "../page.js" */
/** @import { Row, Seen, Surface } from "../types.js" */

const LEAST_CELL = 7;
const MOST = 12e6; // pixels: of a step at first, and of all steps

export class LanesView {
  scroller = byId("scroller", HTMLDivElement);
  spacer = byId("spacer", HTMLDivElement);
  labels = byId("labels", HTMLDivElement);
  canvas = byId("lanes", HTMLCanvasElement);
  top = byId("top", HTMLCanvasElement);
  map = byId("minimap", HTMLCanvasElement);
  tip = byId("tip", HTMLDivElement);
  axis = byId("axis", HTMLSpanElement);
  /** The whole trace, as the minimap shows it. */
  mapPicture = document.createElement("canvas");
  /** Pictures drawn so far; the tests count them. */
  frames = 0;
  laidOut = 0;
  /** Whether a picture has been asked for. */
  asked = false;
  zoom = 0;
  total = 0;
  /** @type {Row[]} */
  rows = [];
  /** One for each trace; none before the first layout. @type {Scale[]} */
  scales = [];
  /** What the labels say. */
  said = "";
  /** What the minimap shows. */
  mapped = "";

  /** @param {App} app */
  constructor(app) {
    this.app = app;
    const { scroller, map } = this;
    const scrolled = () => {
      this.labels.scrollTop = scroller.scrollTop;
      this.draw();
    };
    scroller.addEventListener("scroll", scrolled, { passive: true });
    // The keyboard goes from label to label: their lanes come along, as far as they reach.
    const { labels } = this;
    const led = () => {
      scroller.scrollTop = labels.scrollTop;
      labels.scrollTop = scroller.scrollTop;
    };
    labels.addEventListener("scroll", led, { passive: true });
    labels.addEventListener("wheel", (event) => scroller.scrollBy(0, event.deltaY), { passive: true });
    scroller.addEventListener("click", (event) => app.select(this.stepAt(event)));
    scroller.addEventListener("mousemove", (event) => this.hover(event));
    scroller.addEventListener("mouseleave", () => {
      this.tip.hidden = true;
    });
    scroller.addEventListener(
      "wheel",
      (event) => {
        if (!event.ctrlKey && !event.metaKey) return;
        event.preventDefault();
        this.zoomBy(Math.exp(-event.deltaY / 300), this.offset(event));
      },
      { passive: false },
    );
    this.top.addEventListener("click", (event) => app.select(this.stepAt(event)));
    /** @type {(event: PointerEvent) => void} */
    const jump = (event) => {
      const box = map.getBoundingClientRect();
      scroller.scrollLeft = ((event.clientX - box.left) / box.width) * this.scale.width - this.width / 2;
    };
    map.addEventListener("pointerdown", (event) => {
      map.setPointerCapture(event.pointerId);
      jump(event);
    });
    map.addEventListener("pointermove", (event) => {
      if (map.hasPointerCapture(event.pointerId)) jump(event);
    });
    new ResizeObserver(() => this.resize()).observe(scroller);
  }

  get width() {
    return this.scroller.clientWidth || 600;
  }

  get scale() {
    return this.scales[0];
  }

  /** Rows, scales and sizes again: the trace, the filter, folding or the axis has changed. */
  layout() {
    const { app, scroller } = this;
    const before = this.scales.length
      ? { step: this.scale.step(scroller.scrollLeft), time: this.scale.time }
      : null;
    const { rows, height } = rowsOf(app.traces, app.options);
    this.rows = rows;
    this.laidOut += 1;
    const shown = stepsShown(app.traces, rows, { causes: app.onlyCauses, fold: app.fold });
    shown?.add(app.cursor);
    const least = app.onlyCauses ? 1 : undefined;
    this.scales = app.traces.map((data) => new Scale(data, { time: app.time, shown, least }));
    this.total = Math.max(...this.scales.map((scale) => scale.total));
    for (const scale of this.scales) scale.total = this.total; // both traces end at the same place
    this.setZoom(before?.time === this.scale.time ? this.zoom : this.fitting());
    this.axis.textContent = this.scale.time ? this.app.traces[0].axisOfTime : "firings";
    this.spacer.style.height = `${height + 8}px`;
    if (before?.time === this.scale.time) scroller.scrollLeft = this.scale.left(before.step);
    // A label that is rebuilt under the mouse would lose the click, so it is not while nothing about it
    // changed.
    const labels = rows.map((row) => (isLane(row) ? [row.type, row.key, row.y, row.trace] : row));
    const said = JSON.stringify([app.lane, app.themeName, app.traces.length, labels]);
    if (said !== this.said) {
      this.said = said;
      drawLabels(app, rows, this.labels);
    }
    this.draw();
  }

  fitting() {
    const fit = (this.width - 12) / this.total;
    return this.scale.time ? fit : Math.max(Math.min(fit, 40), LEAST_CELL);
  }

  /** @param {number} zoom */
  setZoom(zoom) {
    const { time } = this.scale;
    const least = Math.min((this.width - 12) / this.total, time ? Infinity : LEAST_CELL);
    const most = Math.min(time ? Infinity : 60, MOST / this.total);
    this.zoom = Math.max(least, Math.min(zoom, most));
    for (const scale of this.scales) scale.zoom = this.zoom;
    this.spacer.style.width = `${Math.ceil(this.scale.width) + 12}px`;
  }

  /** Enlarges around a point of the window. @type {(factor: number, at?: number) => void} */
  zoomBy(factor, at = this.width / 2) {
    const place = (this.scroller.scrollLeft + at) / this.zoom;
    this.setZoom(this.zoom * factor);
    this.scroller.scrollLeft = place * this.zoom - at;
    this.draw();
  }

  fit() {
    this.setZoom((this.width - 12) / this.total);
    this.scroller.scrollLeft = 0;
    this.draw();
  }

  resize() {
    if (!this.scales.length) return;
    this.setZoom(this.zoom);
    this.draw();
  }

  /** @type {(event: MouseEvent) => number} */
  offset(event) {
    return event.clientX - this.scroller.getBoundingClientRect().left;
  }

  /** @type {(event: MouseEvent) => number} */
  stepAt(event) {
    return this.scale.step(this.scroller.scrollLeft + this.offset(event));
  }

  /** Scrolls as little as shows a step with some room around it. @type {(step: number) => void} */
  reveal(step) {
    const x = this.scale.x(step);
    const left = this.scroller.scrollLeft;
    const room = Math.min(60, this.width / 4);
    if (x < left + room) this.scroller.scrollLeft = x - room * 2;
    else if (x > left + this.width - room) this.scroller.scrollLeft = x - this.width + room * 2;
  }

  draw() {
    if (this.asked) return;
    this.asked = true;
    requestAnimationFrame(() => {
      this.asked = false;
      this.paint();
    });
  }

  /**
   * An empty surface of some size.
   *
   * @type {(canvas: HTMLCanvasElement, width: number, height: number) => CanvasSurface}
   */
  surface(canvas, width, height) {
    const ratio = globalThis.devicePixelRatio || 1;
    if (canvas.width !== Math.round(width * ratio) || canvas.height !== Math.round(height * ratio)) {
      canvas.width = Math.round(width * ratio);
      canvas.height = Math.round(height * ratio);
      canvas.style.width = `${width}px`;
      canvas.style.height = `${height}px`;
    }
    const context = canvas.getContext("2d");
    if (!context) throw new Error("the browser draws on no canvas");
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
    context.clearRect(0, 0, width, height);
    return new CanvasSurface(context);
  }

  /** @type {(number: number, surface: Surface) => Seen} */
  seen(number, surface) {
    const scale = this.scales[number];
    const data = this.app.traces[number];
    const left = this.scroller.scrollLeft;
    return {
      surface,
      data,
      scale,
      theme: this.app.theme,
      dx: -left,
      left: 0,
      width: this.width,
      from: Math.max(0, scale.step(left) - 1),
      to: Math.min(data.length - 1, scale.step(left + this.width) + 1),
    };
  }

  /** What is seen of all traces. @type {(surface: Surface) => Seen[]} */
  seenAll(surface) {
    return this.scales.map((_, number) => this.seen(number, surface));
  }

  paint() {
    const { app, width } = this;
    const { theme } = app;
    const height = this.scroller.clientHeight;
    if (!this.scales.length || !height) return;
    this.frames++;
    const surface = this.surface(this.canvas, width, height);
    const views = this.seenAll(surface);
    drawGround(views[0], 0, height);
    drawCauseLine(views[0], 0, height);
    for (const row of this.rows) {
      const y = row.y - this.scroller.scrollTop;
      if (y + row.height < 0 || y > height) continue;
      if (row.type === "heading")
        surface.rect(0, y + 3, width, row.height - 4, { fill: theme.panel, opacity: 0.8 });
      else if (row.type === "lane" && views[row.trace].data.length) {
        if (row.key === app.lane)
          surface.rect(0, y, width, row.height, { fill: theme.cursor, opacity: 0.07 });
        surface.clip(0, y, width, row.height);
        drawLane(views[row.trace], row.lane, y, row.height);
        surface.unclip();
      }
    }
    this.cursorLine(surface, height);
    this.divergenceLine(surface, height);
    this.paintTop(width);
    this.paintMap();
  }

  /** @type {(surface: Surface, height: number) => void} */
  cursorLine(surface, height) {
    const x = this.scale.x(this.app.cursor) - this.scroller.scrollLeft;
    surface.path(points(x, 0, x, height), { stroke: this.app.theme.cursor, width: 1.5 });
  }

  /** @type {(surface: Surface, height: number) => void} */
  divergenceLine(surface, height) {
    const { divergence, theme } = this.app;
    if (!divergence) return;
    const x = this.scale.left(divergence.a) - this.scroller.scrollLeft;
    surface.path(points(x, 0, x, height), { stroke: theme.cursor, width: 2, dash: [6, 4] });
    const lettering = { fill: theme.cursor, size: 10.5, bold: true };
    surface.text(x + 4, 12, `first divergence: ${divergence.a + 1}`, lettering);
  }

  /** @param {number} width */
  paintTop(width) {
    const { app } = this;
    const height = 35 + 18 * app.traces.length;
    const surface = this.surface(this.top, width, height);
    const views = this.seenAll(surface);
    drawRuler(views[0], 0, 34);
    drawCauseFlag(views[0], 0, 34);
    drawStops(views[0], app.breakpoints.steps, 0, 34);
    views.forEach((view, number) => {
      if (!view.data.length) return;
      drawStrip(view, 36 + 18 * number, 13);
      drawCauseBars(view, 49.5 + 18 * number);
    });
    const x = this.scale.x(app.cursor) - this.scroller.scrollLeft;
    this.cursorLine(surface, height);
    surface.path(points(x - 5, 0, x + 5, 0, x, 7), { fill: app.theme.cursor, closed: true });
  }

  paintMap() {
    const { app, scale, scroller } = this;
    const width = this.map.parentElement?.clientWidth ?? 0;
    const height = 30;
    const surface = this.surface(this.map, width, height);
    // The trace in it is drawn once for each layout: it is all steps, while the window shows few.
    const said = JSON.stringify([this.laidOut, width, app.themeName]);
    if (said !== this.mapped) {
      this.mapped = said;
      const view = this.seen(0, this.surface(this.mapPicture, width, height));
      drawMinimap({ ...view, width, left: 0 }, 0, height);
    }
    surface.context.drawImage(this.mapPicture, 0, 0, width, height);
    const ratio = width / scale.width;
    const shown = Math.min(width, Math.max(4, this.width * ratio));
    const frame = { stroke: app.theme.ink, width: 1.5 };
    surface.rect(scroller.scrollLeft * ratio + 1, 1, shown - 2, height - 2, frame);
    const x = scale.x(app.cursor) * ratio;
    surface.path(points(x, 0, x, height), { stroke: app.theme.cursor, width: 1.5 });
  }

  /** @param {MouseEvent} event */
  hover(event) {
    const { tip } = this;
    const step = this.stepAt(event);
    const y = event.clientY - this.scroller.getBoundingClientRect().top + this.scroller.scrollTop;
    const row = this.rows.filter(isLane).find((one) => y >= one.y && y < one.y + one.height);
    if (step < 0 || !this.app.traces[0].length) return;
    fillTip(tip, this.app, step, row);
    tip.hidden = false;
    const box = tip.getBoundingClientRect();
    const below = event.clientY + 18 + box.height <= innerHeight;
    tip.style.left = `${Math.min(event.clientX + 14, innerWidth - box.width - 8)}px`;
    tip.style.top = `${below ? event.clientY + 18 : event.clientY - box.height - 8}px`;
  }
}
