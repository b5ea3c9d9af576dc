// Moving about in an <svg>: drag, wheel and pinch; and, when they are asked for, by keys.

/** @typedef {{ x: number, y: number, width: number, height: number }} Part  of the plane */

const MOST = 6;

export class Pan {
  /** @type {Map<number, PointerEvent>} */
  pointers = new Map();
  /** How far the pointers have moved since they went down. */
  moved = 0;

  /** @param {SVGSVGElement} svg its viewBox is all it holds */
  constructor(svg) {
    this.svg = svg;
    this.whole = this.viewBox();
    this.view = this.whole;
    this.bind();
    this.fit();
  }

  /** @type {() => Part} */
  viewBox() {
    const [x, y, width, height] = (this.svg.getAttribute("viewBox") ?? "").split(" ").map(Number);
    return { x, y, width, height };
  }

  /** @param {Part} view */
  look(view) {
    this.view = view;
    this.svg.setAttribute("viewBox", [view.x, view.y, view.width, view.height].join(" "));
  }

  get size() {
    return { width: this.svg.clientWidth || 800, height: this.svg.clientHeight || 600 };
  }

  /** A part of the plane with the form of the window. @type {(part: Part) => Part} */
  framed(part) {
    const by = Math.min(this.size.width / part.width, this.size.height / part.height);
    const width = this.size.width / by;
    const height = this.size.height / by;
    return { x: part.x - (width - part.width) / 2, y: part.y - (height - part.height) / 2, width, height };
  }

  /** Shows everything. */
  fit() {
    const { x, y, width, height } = this.whole;
    this.look(this.framed({ x: x - 8, y: y - 8, width: width + 16, height: height + 16 }));
  }

  /** Shows everything that has been drawn anew. */
  redrawn() {
    this.whole = this.viewBox();
    this.fit();
  }

  /**
   * Enlarges around a point of the window, or its middle.
   *
   * @type {(factor: number, atX?: number, atY?: number) => void}
   */
  zoom(factor, atX, atY) {
    const { view, size } = this;
    const box = this.svg.getBoundingClientRect();
    const along = atX === undefined ? 0.5 : (atX - box.left) / box.width;
    const down = atY === undefined ? 0.5 : (atY - box.top) / box.height;
    const most = this.framed(this.whole).width * 2;
    const width = Math.min(Math.max(view.width / factor, size.width / MOST), most);
    const by = width / view.width;
    this.look({
      x: view.x + view.width * (1 - by) * along,
      y: view.y + view.height * (1 - by) * down,
      width,
      height: view.height * by,
    });
  }

  /** Moves by parts of what is seen. @type {(dx: number, dy: number) => void} */
  move(dx, dy) {
    const { x, y, width, height } = this.view;
    this.look({ x: x + dx * width, y: y + dy * height, width, height });
  }

  /**
   * Brings a part into view, enlarged as far as it stays readable.
   *
   * @type {(x: number, y: number, width: number, height: number) => void}
   */
  show(x, y, width, height) {
    const { view, size } = this;
    const scale = Math.min(size.width / view.width, size.height / view.height);
    const wanted = Math.max(scale, Math.min(1.2, size.width / (width * 1.5), size.height / (height * 1.5)));
    const wide = Math.max(size.width / wanted, width * 1.1);
    const high = Math.max(size.height / wanted, height * 1.1);
    const left = x + width / 2 - wide / 2;
    this.look(this.framed({ x: left, y: y + height / 2 - high / 2, width: wide, height: high }));
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
    // What ends a drag is no click.
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
    new ResizeObserver(() => this.look(this.framed(this.view))).observe(svg);
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
