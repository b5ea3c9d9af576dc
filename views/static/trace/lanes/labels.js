// What stands before the lanes: headings that fold, names that are clicked to choose a lane.

import { make } from "../../elements.js";
import { nodeColour } from "./shapes.js";

/** @import { App } from "../page.js" */
/** @import { Group, LaneRow, Row } from "../types.js" */

/** @type {(set: Set<Group>, value: Group) => void} */
function toggle(set, value) {
  if (!set.delete(value)) set.add(value);
}

/** @type {(app: App, rows: Row[], column: HTMLElement) => void} */
export function drawLabels(app, rows, column) {
  const bottom = rows.length ? rows[rows.length - 1].y + 40 : 0;
  const below = make("div", { style: `position:absolute;top:${bottom}px;height:1px;width:1px` });
  column.replaceChildren(...rows.map((row) => label(app, row)), below);
  column.scrollTop = app.view.scroller.scrollTop;
}

/** @type {(app: App, row: Row) => HTMLElement} */
function label(app, row) {
  const style = `top:${row.y}px;height:${row.height}px`;
  /** @type {(set: Set<Group>) => () => void} */
  const toggling = (set) => () => {
    toggle(set, row.group);
    app.layout();
  };
  if (row.type === "heading") {
    const expanded = { "aria-expanded": String(!row.closed), onclick: toggling(app.options.closed) };
    const count = make("small", {}, ` ${row.count}`);
    const text = `${row.closed ? "▸" : "▾"} ${row.label}`;
    return make("button", { class: "heading", style, "data-group": row.group, ...expanded }, text, count);
  }
  if (row.type === "silent") {
    const expanded = { "aria-expanded": String(row.open), onclick: toggling(app.options.open) };
    const word = row.group === "transitions" ? "silent" : "idle";
    const text = `${row.open ? "▾" : "▸"} ${row.count} ${word}`;
    return make("button", { class: "silent", style, "data-group": row.group, ...expanded }, text);
  }
  if (row.type === "name") return make("div", { class: "name", style, title: row.label }, row.label);
  return laneLabel(app, row, style);
}

/** @type {(app: App, row: LaneRow, style: string) => HTMLElement} */
function laneLabel(app, { key, lane, trace }, style) {
  const note = lane.capacity ? `${lane.note} ≤ ${lane.capacity}` : lane.note;
  const chosen = app.lane === key;
  /** @type {(event: MouseEvent) => void} */
  const hide = (event) => {
    event.stopPropagation();
    app.options.hidden.add(key);
    app.layout();
  };
  return make(
    "div",
    {
      class: `lane${chosen ? " chosen" : ""}${lane.absent ? " absent" : ""}`,
      style,
      "data-kind": lane.kind,
      "data-id": lane.id,
      title: [lane.label, note, lane.node].filter(Boolean).join(" · "),
      onclick: () => app.choose(chosen ? null : key),
    },
    make("i", { class: "chip", style: `background:${nodeColour(app.theme, app.traces[0], lane.node)}` }),
    app.traces.length > 1 && make("b", { class: "side" }, "AB"[trace]),
    make("span", { class: "what" }, make("span", {}, lane.label), note !== "" && make("small", {}, note)),
    make("button", { class: "hide", title: "hide this lane", onclick: hide }, "×"),
  );
}
