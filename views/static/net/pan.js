// Moving about in an <svg>: drag, wheel and pinch; and, when they are asked for, by keys.

/** @typedef {{ x: number, y: number, width: number, height: number }} Part  of the plane */

const MOST = 6;

export class Pan {
  /** @type {Map<number, PointerEvent>} */
  pointers = new Map();
  /** How far the pointers have moved since they went down. */
  moved = 0;
  /** The left upper corner of what is seen, and pixels of the window per unit of the plane. */
  at = { x: 0, y: 0, scale: 1 };
  /** Whether everything is shown, as it is at first. */
  fitted = true;

  /** @param {SVGSVGElement} svg its viewBox is all it holds */
  constructor(svg) {
    this.svg = svg;
    this.whole = this.viewBox();
    this.bind();
    this.fit();
  }

  /** @type {() => Part} */
  viewBox() {
    const [x, y, width, height] = (this.svg.getAttribute("viewBox") ?? "").split(" ").map(Number);
    return { x, y, width, height };
  }

  get size() {
    return { width: this.svg.clientWidth || 800, height: this.svg.clientHeight || 600 };
  }

  /** What is seen: a part with the form of the window. @type {Part} */
  get view() {
    const { x, y, scale } = this.at;
    return { x, y, width: this.size.width / scale, height: this.size.height / scale };
  }

  /** @param {{ x: number, y: number, scale: number }} at */
  look(at) {
    this.at = at;
    this.fitted = false;
    const { x, y, width, height } = this.view;
    this.svg.setAttribute("viewBox", [x, y, width, height].join(" "));
  }

  /** Shows all of a part, in the middle. @type {(part: Part) => void} */
  frame({ x, y, width, height }) {
    const scale = this.scaleOf({ width, height });
    const { size } = this;
    this.look({ x: x - (size.width / scale - width) / 2, y: y - (size.height / scale - height) / 2, scale });
  }

  /** The largest scale at which something can be seen as a whole. @type {(part: Pick<Part, "width" | "height">) => number} */
  scaleOf({ width, height }) {
    return Math.min(this.size.width / width, this.size.height / height);
  }

  /** Shows everything. */
  fit() {
    const { x, y, width, height } = this.whole;
    this.frame({ x: x - 8, y: y - 8, width: width + 16, height: height + 16 });
    this.fitted = true;
  }

  /** Goes on looking at the same part, from the same corner: the picture or the window has another size. */
  keep() {
    const { fitted } = this;
    this.look(this.at);
    this.fitted = fitted;
  }

  /** Takes the size of a picture that was drawn again. */
  redrawn() {
    this.whole = this.viewBox();
    this.keep();
  }

  /**
   * Enlarges around a point of the window, or its middle.
   *
   * @type {(factor: number, atX?: number, atY?: number) => void}
   */
  zoom(factor, atX, atY) {
    const { at, size } = this;
    const box = this.svg.getBoundingClientRect();
    const along = atX === undefined ? size.width / 2 : atX - box.left;
    const down = atY === undefined ? size.height / 2 : atY - box.top;
    const least = Math.min(this.scaleOf(this.whole) / 2, at.scale);
    const scale = Math.max(least, Math.min(at.scale * factor, Math.max(MOST, at.scale)));
    const by = 1 / at.scale - 1 / scale;
    this.look({ x: at.x + along * by, y: at.y + down * by, scale });
  }

  /** Moves by parts of what is seen. @type {(dx: number, dy: number) => void} */
  move(dx, dy) {
    const { x, y, width, height } = this.view;
    this.look({ ...this.at, x: x + dx * width, y: y + dy * height });
  }

  /** Moves a part, at the same scale, no further than brings it into sight; of what is too large, its corner. @type {(part: Part) => void} */
  bringIn(part) {
    const { view } = this;
    /** @type {(from: number, length: number, start: number, room: number) => number} */
    const by = (from, length, start, room) =>
      Math.min(from - start, Math.max(0, from + length - start - room));
    const dx = by(part.x, part.width, view.x, view.width);
    const dy = by(part.y, part.height, view.y, view.height);
    if (dx || dy) this.look({ ...this.at, x: view.x + dx, y: view.y + dy });
  }

  /** Shows a part in the middle, enlarged as far as it stays readable. @type {(part: Part) => void} */
  show({ x, y, width, height }) {
    const readable = Math.min(1.2, this.scaleOf({ width: width * 1.5, height: height * 1.5 }));
    const scale = Math.min(
      Math.max(this.at.scale, readable),
      this.scaleOf({ width: width * 1.1, height: height * 1.1 }),
    );
    const { size } = this;
    this.look({
      x: x + width / 2 - size.width / scale / 2,
      y: y + height / 2 - size.height / scale / 2,
      scale,
    });
  }

  bind() {
    const { svg, pointers } = this;
    svg.addEventListener("pointerdown", (event) => {
      if (event.button) return;
      if (!pointers.size) this.moved = 0;
      pointers.set(event.pointerId, event);
    });
    svg.addEventListener("pointermove", (event) => this.drag(event));
    /** @type {(event: PointerEvent) => void} */
    const lift = (event) => {
      pointers.delete(event.pointerId);
    };
    svg.addEventListener("pointerup", lift);
    svg.addEventListener("pointercancel", lift);
    // What ends a drag is not a click.
    svg.addEventListener(
      "click",
      (event) => {
        if (this.moved <= 4) return;
        event.stopImmediatePropagation();
        this.moved = 0;
      },
      true,
    );
    svg.addEventListener(
      "wheel",
      (event) => {
        event.preventDefault();
        const by = event.deltaY * (event.deltaMode ? 0.05 : 0.0015);
        this.zoom(Math.exp(-by), event.clientX, event.clientY);
      },
      { passive: false },
    );
    // A window of another size shows everything again if it did before; a panel that opens moves nothing.
    addEventListener("resize", () => this.fitted && this.fit());
    new ResizeObserver(() => this.keep()).observe(svg);
  }

  /** Moves with one pointer, enlarges with two. @type {(event: PointerEvent) => void} */
  drag(event) {
    const { svg, pointers, size } = this;
    const last = pointers.get(event.pointerId);
    if (!last) return;
    const other = [...pointers.values()].find((one) => one.pointerId !== event.pointerId);
    const dx = event.clientX - last.clientX;
    const dy = event.clientY - last.clientY;
    this.moved += Math.hypot(dx, dy);
    if (this.moved > 4 && !svg.hasPointerCapture(event.pointerId)) svg.setPointerCapture(event.pointerId);
    if (other) {
      /** @type {(one: PointerEvent) => number} */
      const apart = (one) => Math.hypot(one.clientX - other.clientX, one.clientY - other.clientY) || 1;
      const by = apart(event) / apart(last);
      this.zoom(by, (event.clientX + other.clientX) / 2, (event.clientY + other.clientY) / 2);
    } else this.move(-dx / size.width, -dy / size.height);
    pointers.set(event.pointerId, event);
  }
}
