// The page of a net: shows a view, collapses and expands its pages in place, searches, shows neighbourhoods.
// Works from a file: everything it needs stands in the page.

import { byId, isInField, make } from "../elements.js";
import { lookUp } from "../maps.js";
import { describe, listChanges } from "./detail.js";
import { layout } from "./layout.js";
import { Pan } from "./pan.js";
import { DrawnNet } from "./renderer.js";
import { Search } from "./search.js";
import { around } from "./shown.js";
import { facts, heading, spoken, WORDS } from "./words.js";

/** @import { Box, Edge, Engine, Item, Picture, View } from "./types.js" */

/** JSON that stands in the page. @type {(id: string) => any} */
const data = (id) => JSON.parse(byId(id, HTMLScriptElement).text);

/** @type {Promise<Engine> | undefined} */
let engine;

/** Unpacks ELK, when it is needed for the first time. */
async function loadElk() {
  const letters = atob(byId("elk", HTMLScriptElement).text.trim());
  const packed = Uint8Array.from(letters, (letter) => letter.charCodeAt(0));
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("gzip"));
  const script = document.createElement("script");
  script.textContent = await new Response(stream).text();
  document.head.append(script);
  return new ELK();
}

/** The drawn element that something happened to. @type {(event: Event) => SVGElement | null} */
const groupAt = ({ target }) => (target instanceof Element ? target.closest("#picture g[data-id]") : null);

/** @type {(group: SVGElement) => string} */
const idOf = (group) => group.dataset.id ?? "";

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
    this.bindPointer();
    this.bindKeys();
    this.bindTools();
    this.present();
    if (everything.compared) listChanges(this);
  }

  // Drawing

  /** @param {Picture} positioned */
  show(positioned) {
    this.picture = positioned;
    this.drawn = new DrawnNet(this.svg, positioned);
    if (this.selected) this.drawn.highlight([this.selected]);
    this.pan.redrawn();
    this.present();
  }

  /** Makes what was drawn known to keyboards and screen readers, and says how much it is. */
  present() {
    const { everything, picture, part } = this;
    for (const item of [...picture.boxes, ...picture.nodes]) {
      const group = this.drawn.element(item.id);
      group?.setAttribute("tabindex", "0");
      group?.setAttribute("role", "button");
      group?.setAttribute("aria-label", spoken(lookUp(this.shapes, item.id)));
    }
    const hidden = everything.nodes.length - picture.nodes.length;
    this.say(
      `${picture.nodes.length} of ${everything.nodes.length} nodes shown` +
        (hidden ? "; open a page by its + sign" : "") +
        (part
          ? `; ${part.steps} steps around ${part.ids.map((id) => this.labels.get(id) || id).join(", ")}`
          : ""),
    );
    document.body.dataset.ready = String(Number(document.body.dataset.ready || 0) + 1);
  }

  relayout() {
    /** @type {(box: Box) => Box} */
    const folded = (box) => ({ ...box, collapsed: this.folded.get(box.id) || undefined });
    let view = { ...this.everything, boxes: this.everything.boxes.map(folded) };
    if (this.part) view = around(view, this.part.ids, this.part.steps);
    document.body.classList.add("busy");
    this.say("laying out …");
    this.working = this.working
      .then(() => layout(view, () => (engine ??= loadElk())))
      .then(
        (positioned) => this.show(positioned),
        (error) => this.say(`the layout failed: ${error.message}`),
      )
      .finally(() => document.body.classList.remove("busy"));
    return this.working;
  }

  /** @param {string} text */
  say(text) {
    this.state.textContent = text;
  }

  /** @param {string | null} id */
  select(id) {
    this.selected = id;
    this.drawn.highlight(id ? [id] : []);
    this.side.hidden = !id && !this.everything.compared;
    if (id) describe(this, lookUp(this.items, id));
    else if (this.everything.compared) listChanges(this);
  }

  // Going about

  /** @param {string} id */
  go(id) {
    const node = this.picture.nodes.find((one) => one.id === id);
    if (node) {
      this.pan.show(node.x - node.width / 2, node.y - node.height / 2, node.width, node.height);
      return;
    }
    const box = this.picture.boxes.find((one) => one.id === id);
    if (box) this.pan.show(box.x, box.y, box.width, box.height);
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
    let box = "title" in shape ? shape.parent : shape.box;
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
    this.relayout().then(() => {
      this.drawn.element(id)?.focus({ preventScroll: true });
      if (this.selected === id) describe(this, lookUp(this.items, id));
    });
  }

  /** @param {boolean} value */
  foldAll(value) {
    for (const id of this.folded.keys()) this.folded.set(id, value);
    this.part = null;
    this.relayout();
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

  // Pointer, keys and tools

  bindPointer() {
    const { svg, hint } = this;
    svg.addEventListener("click", (event) => {
      const group = groupAt(event);
      if (!group) this.select(null);
      else if (event.target instanceof Element && event.target.closest(".fold")) this.toggle(idOf(group));
      else if (this.items.has(idOf(group))) this.select(idOf(group));
    });
    svg.addEventListener("dblclick", (event) => {
      const group = groupAt(event);
      if (group && this.folded.has(idOf(group))) this.toggle(idOf(group));
    });
    svg.addEventListener("pointermove", (event) => {
      const group = event.buttons ? null : groupAt(event);
      const item = group && this.items.get(idOf(group));
      hint.hidden = !item;
      if (item) this.showHint(item, event.clientX, event.clientY);
    });
    svg.addEventListener("pointerleave", () => {
      hint.hidden = true;
    });
  }

  /**
   * Shows in short what is under the mouse.
   *
   * @param {Item | Edge} item
   * @param {number} x
   * @param {number} y
   */
  showHint(item, x, y) {
    const { hint } = this;
    const stands = this.picture.edges.find((edge) => edge.id === item.id)?.stands ?? [];
    const isEdge = "source" in item;
    const title = stands.length > 1 ? `${stands.length} lines` : isEdge ? WORDS[item.kind] : heading(item);
    const lines = facts(item, this.labels)
      .filter(([name]) => name !== "Id" || heading(item) !== item.id)
      .map(([name, text]) => make("div", {}, `${name}: ${text}`));
    hint.replaceChildren(make("b", {}, title), ` ${isEdge ? "" : WORDS[item.kind]}`, ...lines);
    const right = Math.min(x + 14, window.innerWidth - hint.offsetWidth - 8);
    const below = y + 16 + hint.offsetHeight <= window.innerHeight;
    hint.style.left = `${Math.max(4, right)}px`;
    hint.style.top = `${Math.max(4, below ? y + 16 : y - hint.offsetHeight - 10)}px`;
  }

  bindKeys() {
    const { pan } = this;
    /** @type {Record<string, () => unknown>} */
    const keys = {
      ArrowLeft: () => pan.move(-0.1, 0),
      ArrowRight: () => pan.move(0.1, 0),
      ArrowUp: () => pan.move(0, -0.1),
      ArrowDown: () => pan.move(0, 0.1),
      "+": () => pan.zoom(1.25),
      "=": () => pan.zoom(1.25),
      "-": () => pan.zoom(0.8),
      0: () => pan.fit(),
      "/": () => this.search.field.focus(),
      f: () => this.search.field.focus(),
      a: () => this.showAroundSelected(),
      e: () => this.showEverything(),
      x: () => this.foldAll(false),
      c: () => this.foldAll(true),
      n: () => this.nextChange(1),
      p: () => this.nextChange(-1),
      "?": () => this.help.showModal(),
      Escape: () => this.select(null),
    };
    document.addEventListener("keydown", (event) => {
      if (event.ctrlKey || event.metaKey || event.altKey || isInField(event) || this.help.open) return;
      const presses = event.key === "Enter" || event.key === " ";
      const group = groupAt(event);
      if (group && presses) {
        if (this.folded.has(idOf(group)) && event.key === " ") this.toggle(idOf(group));
        else this.select(idOf(group));
      } else if (presses && event.target instanceof HTMLButtonElement) return;
      else if (keys[event.key]) keys[event.key]();
      else return;
      event.preventDefault();
    });
  }

  bindTools() {
    /** @type {(id: string, work: () => void) => void} */
    const onClick = (id, work) => byId(id, HTMLButtonElement).addEventListener("click", work);
    onClick("around", () => {
      if (!this.showAroundSelected()) this.say("choose an element first: click it, or search for it");
    });
    onClick("everything", () => this.showEverything());
    onClick("expand", () => this.foldAll(false));
    onClick("collapse", () => this.foldAll(true));
    onClick("fit", () => this.pan.fit());
    onClick("keys", () => this.help.showModal());
    const dark = matchMedia("(prefers-color-scheme: dark)");
    const theme = byId("theme", HTMLSelectElement);
    const paint = () => {
      const automatic = dark.matches ? "dark" : "light";
      document.body.dataset.theme = theme.value === "auto" ? automatic : theme.value;
    };
    theme.addEventListener("change", paint);
    dark.addEventListener("change", paint);
    paint();
  }
}

new NetPage(data("view"), data("positioned"));
