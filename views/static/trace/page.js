// The page: one cursor for lanes, detail and net.

import { counted } from "../counting.js";
import { byId, make } from "../elements.js";
import { Data, laneKey, lastAtMost } from "./data.js";
import { Breakpoints } from "./explaining/breakpoints.js";
import { causeButton } from "./explaining/cause_detail.js";
import { detailOf } from "./explaining/detail.js";
import { figure } from "./figures/figure.js";
import { bindKeys } from "./keys.js";
import { isLane } from "./lanes/scale.js";
import { LanesView } from "./lanes/view.js";
import { NetPane } from "./net_pane.js";
import { THEMES } from "./themes.js";
import { Tools } from "./tools.js";

/** @import { Choice, Content, Divergence, ThemeName } from "./types.js" */

/**
 * Keeps something for the next page; one from a file may have no storage.
 *
 * @type {(name: string, value: string) => void}
 */
function remember(name, value) {
  try {
    localStorage.setItem(`dineros.${name}`, value);
  } catch {}
}

/** @type {(name: string) => string | null} */
function recall(name) {
  try {
    return localStorage.getItem(`dineros.${name}`);
  } catch {
    return null;
  }
}

export class App {
  /** @type {Choice} */
  options = { filter: "", closed: new Set(), open: new Set(), nodes: new Set(), hidden: new Set() };
  /** Key of the chosen lane. @type {string | null} */
  lane = null;
  fold = false;
  /** Whether only steps are shown that brought the outcome about. */
  onlyCauses = false;
  /** Whether the page stays at the last step. */
  following = false;
  /** Called when the user goes elsewhere. */
  onfollow = () => {};
  /** @type {ThemeName} */
  themeName = "light";

  /** @param {Content} content */
  constructor(content) {
    this.views = content.other ? [content.view, content.other] : [content.view];
    this.traces = this.views.map((view) => new Data(view));
    /** @type {Divergence | null} */
    this.divergence = content.divergence ?? null;
    this.live = Boolean(content.live);
    /** Whether steps are at their times. */
    this.time = this.traces[0].timed;
    this.cursor = this.traces[0].length ? 0 : -1;
    this.view = new LanesView(this);
    this.breakpoints = new Breakpoints(this);
    this.tools = new Tools(this);
    this.net = content.net ? new NetPane(content.net, this.themeName) : null;
    bindKeys(this);
    const preferred = matchMedia("(prefers-color-scheme: dark)").matches ? "dark" : "light";
    this.setTheme((recall("theme") ?? preferred) === "dark" ? "dark" : "light");
    const asked = /^#(\d+)$/.exec(location.hash);
    if (asked) this.select(Math.min(Number(asked[1]) - 1, this.traces[0].length - 1));
    else this.select(this.divergence?.a ?? this.cursor);
    addEventListener("beforeprint", () => byId("print", HTMLDivElement).replaceChildren(this.printed()));
    this.head();
    this.bindGrip();
  }

  /** The border between lanes and detail can be moved. */
  bindGrip() {
    const grip = byId("grip", HTMLDivElement);
    grip.addEventListener("pointerdown", (event) => grip.setPointerCapture(event.pointerId));
    grip.addEventListener("pointermove", (event) => {
      if (!grip.hasPointerCapture(event.pointerId)) return;
      const width = Math.max(200, Math.min(innerWidth - event.clientX - 4, innerWidth - 300));
      grip.parentElement?.style.setProperty("--side", `${Math.round(width)}px`);
    });
  }

  get theme() {
    return THEMES[this.themeName];
  }

  /** Writes what the page is about. */
  head() {
    document.title = `${this.views[0].title} – trace`;
    const lines = this.views.map((view, number) => {
      const bad = /violated|unreachable|does not/.test(view.verdict ?? "");
      return make(
        "div",
        { class: "titles" },
        this.views.length > 1 && make("b", { class: "side" }, "AB"[number]),
        make("h1", {}, view.title),
        view.verdict && make("span", { class: `verdict ${bad ? "bad" : "good"}` }, view.verdict),
        view.property && make("code", { class: "property" }, view.property),
        causeButton(this, number),
        make("small", { class: "facts" }, this.facts(number)),
      );
    });
    byId("head", HTMLElement).replaceChildren(...lines);
  }

  /** The text of a trace's header. @type {(number: number) => string} */
  facts(number) {
    const data = this.traces[number];
    const { kind, model, variant } = this.views[number];
    const parts = [counted(data.length, "step")];
    if (data.loop !== null) parts.push(`loop ${data.loop + 1}–${data.length}`);
    if (data.timed && data.length) parts.push(data.duration(data.times[data.length - 1]));
    let apart = "";
    if (number === 0 && this.divergence) apart = `; first divergence at step ${this.divergence.a + 1}`;
    else if (number === 0 && this.views.length > 1) apart = "; no divergence";
    return `${kind} of ${model || "a net"}${variant ? ` (${variant})` : ""}: ${parts.join(", ")}${apart}`;
  }

  layout() {
    this.tools.update();
    this.view.layout();
  }

  /** @param {ThemeName} name */
  setTheme(name) {
    this.themeName = name;
    const { dataset, style } = document.documentElement;
    dataset.theme = name;
    for (const [key, value] of Object.entries(this.theme))
      if (typeof value === "string") style.setProperty(`--${key}`, value);
    this.net?.setTheme(name);
    this.layout();
    this.tell();
  }

  /** Dark, or light again; the next page will be so as well. */
  toggleTheme() {
    this.setTheme(this.themeName === "dark" ? "light" : "dark");
    remember("theme", this.themeName);
  }

  /** @param {boolean} on */
  setFold(on) {
    if (this.time) return; // folding is by number
    this.fold = on;
    this.layout();
    this.view.reveal(this.cursor);
  }

  /** @param {boolean} on */
  setOnlyCauses(on) {
    if (!this.traces.some((data) => data.cause)) return;
    if (on) this.time = false;
    this.onlyCauses = on;
    this.layout();
    this.view.reveal(this.cursor);
  }

  /** @param {boolean} on */
  setTime(on) {
    if (!this.traces[0].timed) return;
    if (on) this.onlyCauses = false;
    this.time = on;
    this.layout();
    this.view.reveal(this.cursor);
  }

  /** Moves the cursor: lanes, detail and net follow. @type {(step: number, reveal?: boolean) => void} */
  select(step, reveal = true) {
    this.cursor = step;
    if (reveal) {
      this.following = false;
      this.onfollow();
      this.view.reveal(step);
      if (location.protocol !== "about:" && !this.live) history.replaceState(null, "", `#${step + 1}`);
    }
    this.view.draw();
    this.tell();
  }

  /** Says what happens at the cursor. */
  tell() {
    const panels = this.traces.map((_, number) => detailOf(this, number, this.cursor));
    byId("detail", HTMLElement).replaceChildren(...panels);
    this.net?.show(this.traces[0], this.cursor);
    this.tools.tell();
  }

  /** @param {string | null} key */
  choose(key) {
    this.lane = key;
    this.layout();
  }

  /** Chooses the lane below or above. @type {(direction: 1 | -1) => void} */
  chooseNext(direction) {
    const lanes = this.view.rows.filter(isLane);
    if (!lanes.length) return;
    const keys = [...new Set(lanes.map((row) => row.key))];
    const last = keys.length - 1;
    const at = this.lane === null ? -1 : keys.indexOf(this.lane);
    const next = at < 0 ? (direction > 0 ? 0 : last) : Math.max(0, Math.min(at + direction, last));
    this.lane = keys[next];
    const row = lanes.filter((one) => one.key === this.lane)[0];
    const { scroller } = this.view;
    const bottom = row.y + row.height;
    if (row.y < scroller.scrollTop) scroller.scrollTop = row.y - 24;
    else if (bottom > scroller.scrollTop + scroller.clientHeight)
      scroller.scrollTop = bottom - scroller.clientHeight + 8;
    this.layout();
  }

  /** Goes to the next mark of the chosen lane, or to the one before. @type {(direction: 1 | -1) => void} */
  toMark(direction) {
    const { at = [] } = this.traces[0].lanes.find((one) => laneKey(one) === this.lane) ?? {};
    const step = at[direction > 0 ? lastAtMost(at, this.cursor) + 1 : lastAtMost(at, this.cursor - 1)];
    if (step !== undefined) this.select(step);
  }

  hideChosen() {
    if (!this.lane) return;
    this.options.hidden.add(this.lane);
    this.choose(null);
  }

  /** What is shown as one picture. @type {(theme?: ThemeName) => string} */
  figure(theme = this.themeName) {
    const { time, fold, onlyCauses, options, divergence } = this;
    const views = this.traces.map((data) => data.snapshot());
    return figure(views, { theme, time, fold, causes: onlyCauses, filter: options.filter, divergence });
  }

  printed() {
    const picture = new DOMParser().parseFromString(this.figure("light"), "image/svg+xml").documentElement;
    picture.removeAttribute("height");
    picture.setAttribute("width", "100%");
    return picture;
  }
}

/** What is in the page for it. @type {() => Content} */
export const readContent = () => JSON.parse(byId("content", HTMLScriptElement).text);

/** Makes a page known to the console and to tests. @type {(app: App) => App} */
export function known(app) {
  Object.assign(globalThis, { dinerosTrace: app });
  return app;
}
