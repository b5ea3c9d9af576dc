// Breakpoints: set by the user, kept by the browser for each model, shown as a list and as stop signs on the
// ruler.

import { byId, make } from "../../elements.js";
import { laneKey, lastAtMost } from "../data.js";
import { namesOf, parseCondition, unknownIn, Watch } from "./conditions.js";

/** @import { Condition } from "./conditions.js" */
/** @import { App } from "../page.js" */

const UNNAMED = "dineros.breakpoints."; // where those are kept that were set before a model was known

/** @type {(count: number, word: string) => string} */
const counted = (count, word) => `${count} ${word}${count === 1 ? "" : "s"}`;

export class Breakpoints {
  /** @type {Watch[]} */
  watches = [];
  /** All steps at which a breakpoint is hit, ascending. @type {number[]} */
  steps = [];
  /** Whether the list is shown though it is empty. */
  shown = false;
  /** Whether the browser keeps them. */
  stored = true;
  loadedFrom = "";
  /** What the list says. */
  said = "";
  names = make("datalist", { id: "break-names" });
  list = make("ul", { "aria-label": "breakpoints set" });
  message = make("span", { id: "break-message", role: "status" });
  field = make("input", {
    id: "break",
    type: "text",
    list: "break-names",
    autocomplete: "off",
    spellcheck: "false",
    placeholder: "Place >= 3, T, !signal(S), drop",
    "aria-label": "new breakpoint",
    title:
      "Place >= 3; a transition; a signal, signal(S) or !signal(S); a kind of record: drop, error, timeout …",
  });
  button = make("button", {
    id: "breaks-button",
    "aria-controls": "breaks",
    "aria-expanded": "false",
    title: "breakpoints (b)",
    onclick: () => (this.watches.length ? this.field.focus() : this.toggle()),
  });

  /** @param {App} app */
  constructor(app) {
    this.app = app;
    /** @type {(event: SubmitEvent) => void} */
    const onsubmit = (event) => {
      event.preventDefault();
      this.submit();
    };
    /** @type {(text: string, title: string, direction: 1 | -1) => HTMLElement} */
    const step = (text, title, direction) => {
      const onclick = () => this.jump(direction);
      return make("button", { type: "button", title, "aria-label": title, onclick }, text);
    };
    const before = step("‹", "to the previous breakpoint (,)", -1);
    const after = step("›", "to the next breakpoint (.)", 1);
    this.box = make(
      "section",
      { id: "breaks", "aria-label": "breakpoints" },
      make("form", { onsubmit }, this.field, this.names, make("button", {}, "Add")),
      make("span", { class: "finder" }, before, after),
      this.list,
      this.message,
    );
    byId("tools", HTMLElement).after(this.box);
    addEventListener("storage", (event) => {
      if (event.key === this.key) this.load();
    });
    this.load();
  }

  get data() {
    return this.app.traces[0];
  }

  /** Where the browser keeps them. */
  get key() {
    return `${UNNAMED}${this.app.views[0].model}`;
  }

  /**
   * Reads what the browser has kept for this model; what a page set before it knew its model is kept as
   * well.
   */
  load() {
    const before = this.loadedFrom === UNNAMED ? this.watches.map((watch) => watch.condition.text) : [];
    /** @type {string[]} */
    let texts = [];
    try {
      const kept = JSON.parse(localStorage.getItem(this.key) ?? "[]");
      if (this.key !== UNNAMED && this.loadedFrom === UNNAMED) localStorage.removeItem(UNNAMED);
      if (Array.isArray(kept)) texts = kept.filter((text) => typeof text === "string");
    } catch (error) {
      if (!(error instanceof SyntaxError)) this.stored = false; // a page from a file may have no storage
    }
    this.loadedFrom = this.key;
    /** @type {Map<string, Condition>} */
    const conditions = new Map();
    for (const condition of [...texts, ...before].map((text) => parseCondition(text, this.data.view.events)))
      if (condition) conditions.set(condition.text, condition);
    this.watches = [...conditions.values()].map((condition) => new Watch(condition));
    if (before.length) this.save();
    this.update();
  }

  save() {
    try {
      localStorage.setItem(this.key, JSON.stringify(this.watches.map((watch) => watch.condition.text)));
    } catch {
      this.stored = false;
    }
  }

  /** Looks at the steps that have come; another model has other breakpoints. */
  look() {
    if (this.loadedFrom !== this.key) this.load();
    else this.update();
  }

  /**
   * The first hit at a step or after it, with the texts of its breakpoints.
   *
   * @type {(index: number) => { step: number, texts: string[] } | null}
   */
  hitFrom(index) {
    const step = this.steps[lastAtMost(this.steps, index - 1) + 1];
    return step === undefined ? null : { step, texts: this.textsAt(step) };
  }

  /** @type {(step: number) => string[]} */
  textsAt(step) {
    return this.watches
      .filter((watch) => watch.hits[lastAtMost(watch.hits, step)] === step)
      .map((watch) => watch.condition.text);
  }

  submit() {
    const text = this.field.value.trim();
    const condition = parseCondition(text, this.data.view.events);
    if (!condition) {
      const forms = "say Place >= 3, a transition, a signal, or a kind of record";
      this.refuse(text ? `${text} is not a breakpoint: ${forms}` : "say what to stop at");
      return;
    }
    // Before a run has begun, nothing is known.
    const unknown = this.app.views[0].model ? unknownIn(this.data, condition) : null;
    if (unknown) {
      this.refuse(unknown);
      return;
    }
    this.field.value = "";
    this.add(condition);
  }

  /** @param {string} text */
  refuse(text) {
    this.field.setAttribute("aria-invalid", "true");
    this.say(text, "wrong");
  }

  /** @param {Condition} condition */
  add(condition) {
    let watch = this.watches.find((one) => one.condition.text === condition.text);
    if (!watch) {
      watch = new Watch(condition);
      this.watches.push(watch);
    }
    this.save();
    this.update();
    const hits = watch.hits.length;
    this.say(`${condition.text}: ${hits ? `hit ${counted(hits, "time")} so far` : "not hit so far"}`);
    this.field.focus();
  }

  /** @param {string} text */
  remove(text) {
    this.watches = this.watches.filter((watch) => watch.condition.text !== text);
    this.save();
    this.update();
    this.say(`${text} removed`);
    (this.list.querySelector("button") ?? this.field).focus();
  }

  /**
   * Says something; a kind decides how it looks.
   *
   * @type {(text: string, kind?: "" | "wrong" | "hit") => void}
   */
  say(text, kind = "") {
    if (kind !== "wrong") this.field.removeAttribute("aria-invalid");
    this.message.textContent = text;
    this.message.dataset.kind = kind;
  }

  /** @type {(on?: boolean) => void} */
  toggle(on = !this.shown) {
    this.shown = on;
    this.update();
    if (on) this.field.focus();
  }

  /** Opens the list, with what is chosen in the field. */
  open() {
    this.toggle(true);
    const lane = this.data.lanes.find((one) => laneKey(one) === this.app.lane);
    if (lane?.kind === "transition") this.field.value = `fired(${lane.id})`;
    else if (lane?.kind === "signal")
      this.field.value = `signal(${lane.id}${lane.values ? `.${lane.values[this.data.level(lane, this.app.cursor)]}` : ""})`;
    else if (lane?.kind === "place")
      this.field.value = `${lane.id} >= ${this.data.level(lane, this.app.cursor) + 1}`;
    this.field.select();
  }

  /**
   * Goes to the next step at which one is hit, or to the one before.
   *
   * @type {(direction: 1 | -1, hits?: number[]) => void}
   */
  jump(direction, hits = this.steps) {
    const { cursor } = this.app;
    const step = hits[direction > 0 ? lastAtMost(hits, cursor) + 1 : lastAtMost(hits, cursor - 1)];
    if (!this.watches.length) this.say("no breakpoint is set: press b");
    else if (!hits.length) this.say("no breakpoint is hit so far");
    else if (step === undefined)
      this.say(`no breakpoint is hit ${direction > 0 ? "after" : "before"} this step`);
    else {
      this.app.select(step);
      this.say(`step ${step + 1}: ${this.textsAt(step).join(", ")}`, "hit");
    }
  }

  update() {
    const hits = this.watches.map((watch) => watch.look(this.data));
    if (hits.length === 1) this.steps = [...hits[0]];
    else this.steps = [...new Set(hits.flat())].sort((a, b) => a - b);
    const count = this.watches.length;
    const open = this.shown || count > 0;
    this.button.textContent = count ? `Breakpoints ${count}` : "Breakpoints";
    this.button.setAttribute("aria-expanded", String(open));
    this.box.hidden = !open;
    const said = JSON.stringify([
      this.stored,
      this.watches.map((watch) => [watch.condition.text, watch.hits.length, this.unknown(watch)]),
    ]);
    if (said !== this.said) {
      this.said = said;
      this.drawList();
    }
    if (this.shown && !this.names.childElementCount) this.suggest();
    this.app.view.draw();
  }

  /** @type {(watch: Watch) => string | null} */
  unknown(watch) {
    return this.data.length && this.app.views[0].model ? unknownIn(this.data, watch.condition) : null;
  }

  drawList() {
    const focused = document.activeElement;
    const text = focused?.closest("#breaks li")?.getAttribute("data-text");
    this.list.replaceChildren(...this.watches.map((watch) => this.lineOf(watch)));
    if (!this.stored && this.watches.length) {
      const said = "kept until this page is closed: the browser stores nothing for it";
      this.list.append(make("li", { class: "unstored" }, said));
    }
    // The list was drawn again under the keyboard.
    if (!focused || !text) return;
    const line = [...this.list.children].find((item) => item.getAttribute("data-text") === text);
    /** @type {HTMLElement | null | undefined} */ (line?.querySelector(`.${focused.className}`))?.focus();
  }

  /** @type {(watch: Watch) => HTMLElement} */
  lineOf(watch) {
    const { text } = watch.condition;
    const unknown = this.unknown(watch);
    return make(
      "li",
      { "data-text": text, class: unknown ? "unknown" : "" },
      make(
        "button",
        {
          class: "goto",
          title: unknown ?? `to the next step where ${text}`,
          onclick: () => this.jump(1, watch.hits),
        },
        make("i", { "aria-hidden": "true" }),
        make("code", {}, text),
        make("small", {}, unknown ? " not in this trace" : ` ${counted(watch.hits.length, "hit")}`),
      ),
      make(
        "button",
        {
          class: "remove",
          title: `remove ${text}`,
          "aria-label": `remove breakpoint ${text}`,
          onclick: () => this.remove(text),
        },
        "×",
      ),
    );
  }

  /** Fills the list that the field completes from. */
  suggest() {
    const { transitions, places, signals } = namesOf(this.data);
    /** @type {(value: string, label: string) => HTMLElement} */
    const option = (value, label) => make("option", { value, label });
    this.names.replaceChildren(
      ...["drop", "error", "timeout"].map((name) => option(name, "kind of record")),
      ...transitions.map((name) => option(`fired(${name})`, "transition")),
      ...signals.flatMap((name) => [
        option(`signal(${name})`, "becomes true"),
        option(`!signal(${name})`, "becomes false"),
      ]),
      ...places.filter((name) => this.data.inModel(name)).map((name) => option(`${name} >= 1`, "place")),
    );
  }
}
