// What stands before the lanes: headings that fold, names that are clicked to choose a lane.
(function (T) {
  "use strict";

  /** Makes an element. */
  T.make = function (name, attributes = {}, ...children) {
    const element = document.createElement(name);
    for (const [key, value] of Object.entries(attributes)) {
      if (value === undefined || value === null || value === false) continue;
      if (key.startsWith("on")) element.addEventListener(key.slice(2), value);
      else if (key === "class") element.className = value;
      else element.setAttribute(key, value === true ? "" : value);
    }
    element.append(...children.filter((child) => child !== null && child !== undefined && child !== false));
    return element;
  };

  const toggle = (set, value) => (set.has(value) ? set.delete(value) : set.add(value));

  T.drawLabels = function (app, rows, column) {
    const { make } = T;
    const compared = app.traces.length > 1;
    const elements = rows.map((row) => {
      const place = `top:${row.y}px;height:${row.height}px`;
      if (row.type === "heading") {
        return make("button", { class: "heading", style: place, "data-group": row.group, "aria-expanded": String(!row.closed),
          onclick: () => { toggle(app.options.closed, row.group); app.layout(); } },
        `${row.closed ? "▸" : "▾"} ${row.label}`, make("small", {}, ` ${row.count}`));
      }
      if (row.type === "silent") {
        const word = row.group === "transitions" ? "silent" : "idle";
        return make("button", { class: "silent", style: place, "data-group": row.group, "aria-expanded": String(row.open),
          onclick: () => { toggle(app.options.open, row.group); app.layout(); } }, `${row.open ? "▾" : "▸"} ${row.count} ${word}`);
      }
      if (row.type === "name") return make("div", { class: "name", style: place, title: row.label }, row.label);
      const lane = row.lane;
      const note = lane.capacity ? `${lane.note} ≤ ${lane.capacity}` : lane.note;
      const chosen = app.lane === row.key;
      return make("div", { class: `lane${chosen ? " chosen" : ""}${lane.absent ? " absent" : ""}`, style: place, "data-kind": lane.kind, "data-id": lane.id,
        title: [lane.label, note, lane.node].filter(Boolean).join(" · "), onclick: () => app.choose(chosen ? null : row.key) },
      make("i", { class: "chip", style: `background:${T.nodeColour(app.theme, app.traces[0], lane.node ?? -1)}` }),
      compared && make("b", { class: "side" }, "AB"[row.trace]),
      make("span", { class: "what" }, make("span", {}, lane.label), note && make("small", {}, note)),
      make("button", { class: "hide", title: "hide this lane", onclick: (event) => { event.stopPropagation(); app.options.hidden.add(row.key); app.layout(); } }, "×"));
    });
    column.replaceChildren(...elements, make("div", { style: `position:absolute;top:${rows.length ? rows[rows.length - 1].y + 40 : 0}px;height:1px;width:1px` }));
    column.scrollTop = app.view.scroller.scrollTop;
  };
})((globalThis.DinerosTrace ??= {}));
