// The keyboard.

import { byId, isInField, make } from "../elements.js";
import { lastAtMost } from "./data.js";
import { nextCause } from "./explaining/cause_detail.js";

/** @import { App } from "./page.js" */

const KEYS = [
  ["← →", "one step; with Shift ten"],
  ["Home End", "first, last step"],
  ["↑ ↓", "choose a lane"],
  ["[ ]", "mark before, next mark on the chosen lane"],
  ["n N", "next, previous loss or error"],
  ["c", "first cause?"],
  ["C", "show only what brought the outcome about"],
  ["b", "set a breakpoint"],
  [". ,", "run to the next, previous breakpoint"],
  ["h", "hide the chosen lane"],
  ["+ − 0", "zoom; all in the window"],
  ["f", "fold what does not matter"],
  ["t", "firings or wall-clock time"],
  ["/", "filter lanes"],
  ["s", "search steps"],
  ["d", "dark or light"],
  ["v", "first divergence of two traces"],
  ["Esc", "leave a field"],
];

/** @param {App} app */
export function bindKeys(app) {
  const last = () => Math.max(...app.traces.map((data) => data.length)) - 1;
  /** @type {(to: number) => void} */
  const move = (to) => app.select(Math.max(-1, Math.min(to, last())));
  /** @type {(direction: 1 | -1) => void} */
  const alarm = (direction) => {
    const { alarms } = app.traces[0];
    const at = direction > 0 ? lastAtMost(alarms, app.cursor) + 1 : lastAtMost(alarms, app.cursor - 1);
    if (alarms[at] !== undefined) move(alarms[at]);
  };
  /** @type {(direction: 1 | -1, event: KeyboardEvent) => void} */
  const walk = (direction, event) => {
    if (app.onlyCauses && app.traces[0].cause) move(nextCause(app.traces[0], app.cursor, direction));
    else move(app.cursor + direction * (event.shiftKey ? 10 : 1));
  };
  const help = byId("keys", HTMLDialogElement);
  /** @type {Record<string, (event: KeyboardEvent) => unknown>} */
  const actions = {
    ArrowLeft: (event) => walk(-1, event),
    ArrowRight: (event) => walk(1, event),
    Home: () => move(0),
    End: () => move(last()),
    ArrowUp: () => app.chooseNext(-1),
    ArrowDown: () => app.chooseNext(1),
    "[": () => app.toMark(-1),
    "]": () => app.toMark(1),
    n: () => alarm(1),
    N: () => alarm(-1),
    c: () => app.traces[0].cause && move(app.traces[0].cause.first),
    C: () => app.setOnlyCauses(!app.onlyCauses),
    b: () => app.breakpoints.open(),
    ".": () => app.breakpoints.jump(1),
    ",": () => app.breakpoints.jump(-1),
    h: () => app.hideChosen(),
    "+": () => app.view.zoomBy(1.5),
    "=": () => app.view.zoomBy(1.5),
    "-": () => app.view.zoomBy(1 / 1.5),
    0: () => app.view.fit(),
    f: () => app.setFold(!app.fold),
    t: () => app.setTime(!app.time),
    d: () => app.toggleTheme(),
    "/": () => app.tools.filter.focus(),
    s: () => app.tools.search.focus(),
    v: () => app.divergence && move(app.divergence.a),
    "?": () => help.showModal(),
  };
  document.addEventListener("keydown", (event) => {
    if (event.key === "Escape") {
      if (document.activeElement instanceof HTMLElement) document.activeElement.blur();
      return;
    }
    if (event.ctrlKey || event.metaKey || event.altKey || isInField(event)) return;
    const action = actions[event.key];
    if (!action) return;
    event.preventDefault();
    action(event);
  });
  const list = byId("keylist", HTMLDListElement);
  for (const [key, what] of KEYS) list.append(make("dt", {}, key), make("dd", {}, what));
}
