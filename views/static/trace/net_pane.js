// The net next to the trace, at the marking of the cursor, with the changes of the step.

import { byId, make } from "../elements.js";
import { Pan } from "../net/pan.js";
import { DrawnNet } from "../net/renderer.js";
import { prototypeOf, settingOf } from "./data.js";

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
      this.pan.fit();
    });
    const smaller = button("−", "smaller", () => this.pan.zoom(1 / 1.4));
    const larger = button("+", "larger", () => this.pan.zoom(1.4));
    const tools = make("div", { class: "nettools" }, this.following, smaller, larger, whole);
    this.box.replaceChildren(this.svg, tools);
    this.pan = new Pan(this.svg);
    this.svg.addEventListener("pointermove", () => {
      if (this.pan.pointers.size) this.setFollow(false); // who drags it looks at something else
    });
    this.setFollow(true);
    this.setTheme(theme);
    // How much room there is shows when the step's detail stands above.
    const sized = new ResizeObserver(() => {
      sized.disconnect();
      this.pan.fit();
      this.refresh();
    });
    sized.observe(this.box);
  }

  /** @param {boolean} on */
  setFollow(on) {
    this.follow = on;
    this.following.setAttribute("aria-pressed", String(on));
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
      Object.fromEntries(signals.map((lane) => [lane.id, settingOf(lane, data.level(lane, step))])),
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
    const { pan } = this;
    const { size, view } = pan;
    if (size.width < 40 || size.height < 40) return;
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
    const [width, height] = [right - left, bottom - top];
    const inside =
      left >= view.x && top >= view.y && right <= view.x + view.width && bottom <= view.y + view.height;
    if (inside && pan.at.scale > 0.5) return;
    const scale = Math.max(0.15, Math.min(1.1, pan.scaleOf({ width, height })));
    pan.look({
      x: left + (width - size.width / scale) / 2,
      y: top + (height - size.height / scale) / 2,
      scale,
    });
  }
}
