// The page of a net: shows a view, collapses and expands its pages in place, searches, shows neighbourhoods.
// Works from a file: everything it needs is in the page.

import { counted } from "../counting.js";
import { byId } from "../elements.js";
import { lookUp } from "../maps.js";
import { read, written } from "./address.js";
import { bindKeys, bindPointer, bindTools } from "./controls.js";
import { describe, listChanges } from "./detail.js";
import { netFigure } from "./figure.js";
import { areaOf, linesOf, outer, shownFor } from "./joined.js";
import { laidOut } from "./layout/engine.js";
import { around } from "./layout/shown.js";
import { Pan } from "./pan.js";
import { DrawnNet } from "./renderer.js";
import { Search } from "./search.js";
import { spoken } from "./words.js";

/** @import { Box, Edge, Item, Picture, Placed, View } from "./types.js" */

/** JSON that is in the page. @type {(id: string) => any} */
const data = (id) => JSON.parse(byId(id, HTMLScriptElement).text);

export class NetPage {
  svg = byId("picture", SVGSVGElement);
  hint = byId("hint", HTMLDivElement);
  state = byId("state", HTMLDivElement);
  side = byId("detail", HTMLElement);
  steps = byId("steps", HTMLInputElement);
  help = byId("help", HTMLDialogElement);
  /** A neighbourhood that is shown alone. @type {{ ids: string[], steps: number } | null} */
  part = null;
  /** @type {string | null} */
  selected = null;
  /** What the mouse or the keyboard is at. @type {string | null} */
  pointed = null;
  working = Promise.resolve();

  /**
   * @param {View} everything
   * @param {Picture} positioned its picture, to begin with
   */
  constructor(everything, positioned) {
    this.everything = everything;
    const { boxes, nodes, edges } = everything;
    /** Whether boxes are collapsed. */
    this.folded = new Map(boxes.map((box) => [box.id, Boolean(box.collapsed)]));
    this.boxes = new Map(boxes.map((box) => [box.id, box]));
    /** @type {Map<string, string>} */
    this.labels = new Map();
    for (const box of boxes) this.labels.set(box.id, box.title);
    for (const node of nodes) this.labels.set(node.id, node.label);
    /** @type {Map<string, Item>} */
    this.shapes = new Map([...boxes, ...nodes].map((item) => [item.id, item]));
    /** @type {Map<string, Item | Edge>} */
    this.items = new Map([...edges, ...boxes, ...nodes].map((item) => [item.id, item]));
    for (const edge of edges) if (edge.also) this.items.set(edge.also, edge);
    this.changes = [...boxes, ...nodes, ...edges].filter((item) => item.change);
    this.picture = positioned;
    this.drawn = new DrawnNet(this.svg, positioned);
    this.pan = new Pan(this.svg);
    this.search = new Search(this);
    bindPointer(this);
    bindKeys(this);
    bindTools(this);
    this.present();
    if (everything.compared) listChanges(this);
    addEventListener("hashchange", () => this.follow());
    if (location.hash) this.follow();
  }

  // Drawing

  /**
   * Shows another picture: `anchor`, or what stands for it, stays where it is in the window; or all is seen.
   *
   * @type {(positioned: Picture, anchor: string | null) => void}
   */
  show(positioned, anchor) {
    const before = anchor && this.cornerOf(anchor);
    this.hint.hidden = true;
    this.picture = positioned;
    this.drawn = new DrawnNet(this.svg, positioned);
    this.pan.redrawn();
    const after = anchor && this.cornerOf(anchor);
    const { at } = this.pan;
    if (before && after) this.pan.look({ ...at, x: at.x + after.x - before.x, y: at.y + after.y - before.y });
    else this.pan.fit();
    this.mark();
    this.present();
  }

  /** The right upper corner of what is shown for an element, where boxes have their sign. @type {(id: string) => { x: number, y: number } | null} */
  cornerOf(id) {
    const item = this.placed(id);
    if (!item) return null;
    const { x, y, width } = areaOf(item);
    return { x: x + width, y };
  }

  /** @type {(id: string) => Placed | null} */
  placed(id) {
    return shownFor(this.picture, this.shapes, id);
  }

  /** Points out what is chosen, and the lines of that and of what is pointed at. */
  mark() {
    const { selected, pointed, picture } = this;
    const shown = selected && (this.drawn.element(selected) ? selected : this.placed(selected)?.id);
    this.drawn.highlight(shown ? [shown] : []);
    this.drawn.highlight([...linesOf(picture, shown ?? null), ...linesOf(picture, pointed)], "near");
  }

  /** @param {string | null} id */
  point(id) {
    if (id === this.pointed) return;
    this.pointed = id;
    this.mark();
  }

  /** Makes what was drawn known to keyboards and screen readers, and says how much it is. */
  present() {
    const { everything, picture, part } = this;
    for (const { id } of [...picture.boxes, ...picture.nodes]) {
      const said = spoken(lookUp(this.shapes, id)); // in addition to its own texts
      const group = this.drawn.element(id);
      for (const [name, value] of Object.entries({ tabindex: "0", role: "button", ...said }))
        group?.setAttribute(name, value);
    }
    const hidden = everything.nodes.length - picture.nodes.length;
    this.say(
      `${picture.nodes.length} of ${everything.nodes.length} nodes shown` +
        (hidden ? "; open a page by its + sign" : "") +
        (part
          ? `; ${counted(part.steps, "step")} around ${part.ids.map((id) => this.labels.get(id) || id).join(", ")}`
          : ""),
    );
    document.body.dataset.ready = String(Number(document.body.dataset.ready || 0) + 1);
  }

  /** Lays out what is to be seen; see `show`. @type {(anchor?: string | null) => Promise<void>} */
  relayout(anchor = null) {
    /** @type {(box: Box) => Box} */
    const folded = (box) => ({ ...box, collapsed: this.folded.get(box.id) || undefined });
    let view = { ...this.everything, boxes: this.everything.boxes.map(folded) };
    if (this.part) view = around(view, this.part.ids, this.part.steps);
    document.body.classList.add("busy");
    this.say("laying out …");
    this.working = this.working
      .then(() => laidOut(view))
      .then(
        (positioned) => this.show(positioned, anchor),
        (error) => this.say(`the layout failed: ${error.message}`),
      )
      .finally(() => document.body.classList.remove("busy"));
    this.remember();
    return this.working;
  }

  /** @param {string} text */
  say(text) {
    this.state.textContent = text;
  }

  /** @param {string | null} id */
  select(id) {
    this.selected = id;
    this.side.hidden = !id && !this.everything.compared;
    this.mark();
    if (id) describe(this, lookUp(this.items, id));
    else if (this.everything.compared) listChanges(this);
    this.pan.keep(); // next to what was added or removed
    const item = id && this.picture.nodes.find((one) => one.id === id);
    if (item) this.pan.bringIn(areaOf(item));
    this.remember();
  }

  // Links

  /** Keeps what is seen in the address. */
  remember() {
    const { selected: element, part } = this;
    /** @type {(collapsed: boolean) => string[]} */
    const turned = (collapsed) =>
      this.everything.boxes
        .filter(
          ({ id, collapsed: first = false }) => first !== collapsed && this.folded.get(id) === collapsed,
        )
        .map(({ id }) => id);
    const said = written({ element, part, open: turned(false), closed: turned(true) });
    if (said !== location.hash.slice(1))
      history.replaceState(null, "", said ? `#${said}` : location.href.split("#")[0]);
  }

  /** Goes to where the address leads. */
  follow() {
    const { element, part, open, closed } = read(location.hash);
    const unknown = [element ?? [], part?.ids ?? [], open, closed].flat().filter((id) => !this.items.has(id));
    if (unknown.length) {
      this.say(`the link leads to ${unknown.join(", ")}, which is not here`);
      return;
    }
    this.part = part;
    for (const { id, collapsed = false } of this.everything.boxes) {
      const turned = collapsed ? open.includes(id) : closed.includes(id);
      this.folded.set(id, collapsed !== turned);
    }
    this.relayout().then(() => (element === null ? this.select(null) : this.find(element)));
  }

  // Going about

  /** @param {string} id */
  go(id) {
    const item = this.placed(id);
    if (item) this.pan.show(areaOf(item));
  }

  /**
   * Shows an element, opening what hides it.
   *
   * @param {string} id
   */
  find(id) {
    const item = this.items.get(id);
    if (!item) return;
    let opened = false;
    const { nodes, boxes } = this.picture;
    if (this.part && ![...nodes, ...boxes].some((one) => one.id === id)) {
      this.part = null;
      opened = true;
    }
    const shape = "source" in item ? lookUp(this.shapes, item.source) : item;
    let box = outer(shape);
    while (box !== undefined && box !== null) {
      if (this.folded.get(box)) {
        this.folded.set(box, false);
        opened = true;
      }
      box = lookUp(this.boxes, box).parent;
    }
    const finish = () => {
      this.select(id);
      this.go(shape.id);
    };
    if (opened) this.relayout().then(finish);
    else finish();
  }

  /** @param {string} id */
  toggle(id) {
    this.folded.set(id, !this.folded.get(id));
    this.part = null;
    const { pan } = this;
    this.relayout(pan.fitted ? null : id).then(() => {
      const box = this.placed(id);
      if (box && pan.scaleOf(box) >= pan.at.scale) pan.bringIn(areaOf(box));
      this.drawn.element(id)?.focus({ preventScroll: true });
      if (this.selected === id) describe(this, lookUp(this.items, id));
    });
  }

  /** @param {boolean} value */
  foldAll(value) {
    for (const id of this.folded.keys()) this.folded.set(id, value);
    this.part = null;
    this.relayout(this.pan.fitted ? null : (this.selected ?? this.middle()));
  }

  /** What is nearest to the middle of the window. @type {() => string | null} */
  middle() {
    const { x, y, width, height } = this.pan.view;
    /** @type {(item: Placed) => number} */
    const off = (item) => {
      const area = areaOf(item);
      return Math.hypot(area.x + area.width / 2 - x - width / 2, area.y + area.height / 2 - y - height / 2);
    };
    const { nodes, boxes } = this.picture;
    const items = [...nodes, ...boxes.filter((box) => box.collapsed)];
    return items.length ? items.reduce((a, b) => (off(a) <= off(b) ? a : b)).id : null;
  }

  /**
   * @param {string[]} ids
   * @param {number} steps
   */
  showAround(ids, steps) {
    this.part = { ids, steps };
    this.steps.value = String(steps);
    this.relayout();
  }

  showAroundSelected() {
    if (this.selected) this.showAround([this.selected], Number(this.steps.value));
    return this.selected !== null;
  }

  showEverything() {
    this.part = null;
    this.relayout();
  }

  /** @param {number} by */
  nextChange(by) {
    const { changes } = this;
    if (!changes.length) return;
    const at = changes.findIndex((item) => item.id === this.selected);
    this.find(changes[(at + by + changes.length + (at < 0 && by < 0 ? 1 : 0)) % changes.length].id);
  }

  /** What is shown, as a file in the colours of the page. */
  figure() {
    const theme = document.body.dataset.theme === "dark" ? "dark" : "light";
    return netFigure(this.picture, byId(`style-${theme}`, HTMLScriptElement).text, theme);
  }

  /** Of files. */
  get name() {
    return this.everything.id.replace(/[^\w.-]+/g, "_") || "net";
  }
}

new NetPage(data("view"), data("positioned"));
