// The tool bar: filter, nodes, axis, folding, zoom, search, colours, saving.

import { byId, make } from "../elements.js";
import { saveFile } from "../saving.js";
import { lastAtMost } from "./data.js";
import { nodeColour, nodeLetter } from "./lanes/shapes.js";

/** @import { App } from "./page.js" */
/** @import { Step } from "./types.js" */

/** @type {(id: string, text: string, title: string, onclick: () => void) => HTMLButtonElement} */
const button = (id, text, title, onclick) => make("button", { id, title, onclick }, text);

export class Tools {
  /** Steps in which what is searched for occurs. @type {number[]} */
  matches = [];
  /** What the buttons of nodes say. */
  said = "";
  found = make("span", { id: "found", "aria-live": "polite" });
  nodes = make("span", { id: "nodes", role: "group", "aria-label": "node nets" });

  /** @param {App} app */
  constructor(app) {
    this.app = app;
    this.filter = make("input", {
      id: "filter",
      type: "search",
      placeholder: "filter lanes  /",
      "aria-label": "filter lanes",
      title: "words that lanes must have; a|b is either; -word is without",
      oninput: () => {
        app.options.filter = this.filter.value;
        app.layout();
      },
    });
    this.search = make("input", {
      id: "search",
      type: "search",
      placeholder: "search steps  s",
      "aria-label": "search steps",
      oninput: () => this.find(),
      onkeydown: (event) => event.key === "Enter" && this.jump(event.shiftKey ? -1 : 1),
    });
    this.fold = button("fold", "Fold", "fold runs of steps without a mark on the lanes shown (f)", () =>
      app.setFold(!app.fold),
    );
    this.causes = button("causes", "Causes", "show only the steps that brought the outcome about (C)", () =>
      app.setOnlyCauses(!app.onlyCauses),
    );
    this.time = button("time", "Time", "by wall-clock time, or by number of firings (t)", () =>
      app.setTime(!app.time),
    );
    const before = button("before", "‹", "match before", () => this.jump(-1));
    const after = button("after", "›", "next match", () => this.jump(1));
    byId("tools", HTMLElement).append(
      this.filter,
      this.nodes,
      this.fold,
      this.causes,
      this.time,
      button("out", "−", "smaller (-)", () => app.view.zoomBy(1 / 1.5)),
      button("in", "+", "larger (+)", () => app.view.zoomBy(1.5)),
      button("fit", "Fit", "all in the window (0)", () => app.view.fit()),
      make("span", { class: "finder" }, this.search, before, after, this.found),
      app.breakpoints.button,
      button("dark", "◐", "dark or light (d)", () => app.toggleTheme()),
      button("save", "SVG", "save as a picture", () => this.save()),
      button("help", "?", "keys (?)", () => byId("keys", HTMLDialogElement).showModal()),
    );
  }

  update() {
    const { app } = this;
    const { nodes } = app.traces[0];
    this.fold.setAttribute("aria-pressed", String(app.fold));
    this.fold.disabled = app.time || app.onlyCauses;
    this.causes.hidden = !app.traces.some((one) => one.cause);
    this.causes.setAttribute("aria-pressed", String(app.onlyCauses));
    this.time.setAttribute("aria-pressed", String(app.time));
    this.time.hidden = !app.traces[0].timed;
    const { hidden } = app.options;
    const said = JSON.stringify([nodes, [...app.options.nodes], hidden.size, app.themeName]);
    if (said === this.said) return;
    this.said = said;
    this.nodes.replaceChildren(...nodes.map((node, index) => this.nodeButton(node, index)));
    if (!hidden.size) return;
    const unhide = () => {
      hidden.clear();
      app.layout();
    };
    this.nodes.append(make("button", { id: "unhide", onclick: unhide }, `${hidden.size} hidden`));
  }

  /** @type {(node: string, index: number) => HTMLElement} */
  nodeButton(node, index) {
    const { app } = this;
    const left = app.options.nodes;
    const onclick = () => {
      if (!left.delete(node)) left.add(node);
      app.layout();
    };
    return make(
      "button",
      {
        class: "node",
        "data-node": node,
        "aria-pressed": String(!left.has(node)),
        title: `show or hide the lanes of ${node}`,
        onclick,
      },
      make(
        "i",
        { style: `background:${nodeColour(app.theme, app.traces[0], index)}` },
        nodeLetter(app.traces[0], index),
      ),
      node,
    );
  }

  find() {
    const data = this.app.traces[0];
    const asked = this.search.value.trim().toLowerCase();
    /** @type {(text: string) => boolean} */
    const has = (text) => text.toLowerCase().includes(asked);
    /** The numbers of names that it occurs in. @type {(names: string[]) => Set<number | undefined>} */
    const among = (names) => new Set(names.flatMap((name, i) => (has(name) ? [i] : [])));
    const texts = among(data.texts);
    const transitions = among(data.transitions);
    const places = among(data.places);
    /** @type {(step: Step) => boolean} */
    const fits = ({ x, t, c = [], d }) =>
      texts.has(x) ||
      transitions.has(t) ||
      c.some((place, i) => i % 2 === 0 && places.has(place)) ||
      (d !== undefined && has(JSON.stringify(d)));
    this.matches = asked ? data.steps.flatMap((step, i) => (fits(step) ? [i] : [])) : [];
    this.tell();
  }

  tell() {
    const at = this.matches.indexOf(this.app.cursor);
    const which = at >= 0 ? `${at + 1} of ` : "";
    this.found.textContent = this.search.value.trim() ? `${which}${this.matches.length}` : "";
  }

  /** @param {1 | -1} direction */
  jump(direction) {
    const { length } = this.matches;
    if (!length) return;
    const at = lastAtMost(this.matches, this.app.cursor);
    const on = at >= 0 && this.matches[at] === this.app.cursor;
    const next = direction > 0 ? at + 1 : on ? at - 1 : at;
    this.app.select(this.matches[(next + length) % length]);
    this.tell();
  }

  save() {
    saveFile(new Blob([this.app.figure()], { type: "image/svg+xml" }), "trace.svg");
  }
}
