// The net beside the trace, at the marking of the cursor: what the step changed is pointed out.

import { byId, make } from "../elements.js";
import { DrawnNet } from "../net/renderer.js";
import { prototypeOf } from "./data.js";

/** @import { Picture } from "../net/types.js" */
/** @import { Data } from "./data.js" */
/** @import { ThemeName } from "./types.js" */

/** @type {(text: string, title: string, onclick: () => void) => HTMLButtonElement} */
const button = (text, title, onclick) => make("button", { title, onclick }, text);

export class NetPane {
  box = byId("net", HTMLElement);
  svg = document.createElementNS("http://www.w3.org/2000/svg", "svg");
  /** Whether the picture moves to what a step changes. */
  follow = true;
  /**
   * The left upper corner of what is seen, and its scale: none before there is room.
   *
   * @type {{ x: number, y: number, scale: number } | null}
   */
  view = null;
  /** @type {[Data, number] | null} */
  last = null;

  /**
   * @param {Picture} content
   * @param {ThemeName} theme
   */
  constructor(content, theme) {
    this.content = content;
    this.drawn = new DrawnNet(this.svg, content);
    this.following = button("Follow", "keep the step's elements in sight", () => {
      this.setFollow(!this.follow);
      this.refresh();
    });
    const whole = button("Fit", "the whole net", () => {
      this.setFollow(false);
      this.fit();
    });
    const smaller = button("−", "smaller", () => this.zoom(1 / 1.4));
    const larger = button("+", "larger", () => this.zoom(1.4));
    const tools = make("div", { class: "nettools" }, this.following, smaller, larger, whole);
    this.box.replaceChildren(this.svg, tools);
    this.setFollow(true);
    this.bind();
    this.setTheme(theme);
    new ResizeObserver(() => {
      if (this.view === null) {
        this.fit();
        this.refresh();
      } else this.look(this.view);
    }).observe(this.box);
  }

  /** @param {boolean} on */
  setFollow(on) {
    this.follow = on;
    this.following.setAttribute("aria-pressed", String(on));
  }

  bind() {
    const { svg } = this;
    /** @type {PointerEvent | null} */
    let last = null;
    svg.addEventListener("pointerdown", (event) => {
      last = event;
      svg.setPointerCapture(event.pointerId);
    });
    svg.addEventListener("pointermove", (event) => {
      if (!last || !this.view) return;
      this.setFollow(false);
      const { x, y, scale } = this.view;
      const [dx, dy] = [event.clientX - last.clientX, event.clientY - last.clientY];
      this.look({ x: x - dx / scale, y: y - dy / scale, scale });
      last = event;
    });
    svg.addEventListener("pointerup", () => {
      last = null;
    });
    svg.addEventListener(
      "wheel",
      (event) => {
        event.preventDefault();
        const box = this.box.getBoundingClientRect();
        this.zoom(Math.exp(-event.deltaY / 400), event.clientX - box.left, event.clientY - box.top);
      },
      { passive: false },
    );
  }

  get room() {
    return [this.box.clientWidth || 300, this.box.clientHeight || 300];
  }

  fit() {
    const [wide, high] = this.room;
    const { width, height } = this.content;
    const scale = Math.min(wide / width, high / height) * 0.98;
    this.look({ x: (width - wide / scale) / 2, y: (height - high / scale) / 2, scale });
  }

  /** Enlarges around a point of the pane. @type {(factor: number, x?: number, y?: number) => void} */
  zoom(factor, x = this.room[0] / 2, y = this.room[1] / 2) {
    if (!this.view) return;
    const before = this.view.scale;
    const scale = Math.max(0.05, Math.min(4, before * factor));
    this.look({ x: this.view.x + x / before - x / scale, y: this.view.y + y / before - y / scale, scale });
  }

  /** @param {{ x: number, y: number, scale: number }} view */
  look(view) {
    this.view = view;
    const [wide, high] = this.room;
    const { x, y, scale } = view;
    this.svg.setAttribute("viewBox", `${x} ${y} ${wide / scale} ${high / scale}`);
  }

  /** @param {ThemeName} name */
  setTheme(name) {
    this.svg.dataset.theme = name;
  }

  /** Shows the marking after a step, and what it changed. @type {(data: Data, step: number) => void} */
  show(data, step) {
    this.last = [data, step];
    /** @type {Record<string, number>} */
    const marking = {};
    for (const name of data.places) marking[prototypeOf(name)] = 0;
    for (const node of this.content.nodes) if (node.kind === "place") marking[node.id] = 0;
    // The picture has each server page once: a place's tokens are those of all instances.
    for (const [number, tokens] of data.marking(Math.min(step, data.length - 1)))
      marking[prototypeOf(data.places[number])] += tokens;
    this.drawn.setMarking(marking);
    const signals = data.lanes.filter((lane) => lane.kind === "signal");
    this.drawn.setSignals(
      Object.fromEntries(signals.map((lane) => [lane.id, Boolean(data.level(lane, step))])),
    );
    const states = data.lanes.filter((lane) => lane.kind === "state");
    this.drawn.setStates(Object.fromEntries(states.map((lane) => [lane.id, data.level(lane, step)])));
    const touched = this.touched(data, step);
    this.drawn.highlight(touched);
    this.box.dataset.step = String(step);
    if (this.follow) this.sight(touched);
  }

  refresh() {
    if (this.last) this.show(...this.last);
  }

  /**
   * Ids of what a step is about: the transition or channel, places that changed, the signal, the managed node.
   *
   * @type {(data: Data, step: number) => string[]}
   */
  touched(data, step) {
    if (step < 0 || step >= data.length) return [];
    const { e: event, c: change = [], m: marks = [] } = data.steps[step];
    /** @type {Set<string>} */
    const found = new Set();
    const transition = data.transition(step);
    if (transition && (event === "fire" || event === "error")) found.add(prototypeOf(transition));
    for (let i = 0; i < change.length; i += 2) found.add(prototypeOf(data.places[change[i]]));
    for (const [index] of marks) {
      const lane = data.lanes[index];
      if (lane.channel) found.add(lane.channel);
      else if (lane.kind === "signal" || lane.kind === "state") found.add(lane.id);
    }
    return [...found].filter((id) => this.drawn.element(id));
  }

  /**
   * Moves the picture so that elements can be seen, at a size that can be read.
   *
   * @type {(ids: string[]) => void}
   */
  sight(ids) {
    const [wide, high] = this.room;
    if (!this.view || wide < 40 || high < 40) return;
    const heads = this.content.boxes
      .filter(({ id, signals = [] }) => ids.includes(id) || signals.some((signal) => ids.includes(signal.id)))
      .map(({ x, y, header }) => ({ x: x + header[0] / 2, y: y + header[1] / 2 }));
    const nodes = this.content.nodes.filter(
      (node) => ids.includes(node.id) || (node.target && ids.includes(node.target) && ids.length < 2),
    );
    const spots = [...heads, ...nodes];
    if (!spots.length) return;
    const left = Math.min(...spots.map((spot) => spot.x)) - 70;
    const right = Math.max(...spots.map((spot) => spot.x)) + 70;
    const top = Math.min(...spots.map((spot) => spot.y)) - 50;
    const bottom = Math.max(...spots.map((spot) => spot.y)) + 60;
    const { x, y, scale } = this.view;
    const inside = left >= x && top >= y && right <= x + wide / scale && bottom <= y + high / scale;
    if (inside && scale > 0.5) return;
    const fitting = Math.max(0.15, Math.min(1.1, wide / (right - left), high / (bottom - top)));
    this.look({
      x: (left + right) / 2 - wide / fitting / 2,
      y: (top + bottom) / 2 - high / fitting / 2,
      scale: fitting,
    });
  }
}
