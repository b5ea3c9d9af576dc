// The tool bar: filter, nodes, axis, folding, zoom, search, colours, saving.
(function (T) {
  "use strict";
  const { make } = T;

  T.Tools = class {
    constructor(app) {
      this.app = app;
      this.matches = [];
      const button = (id, text, title, onclick) => make("button", { id, title, onclick }, text);
      this.filter = make("input", { id: "filter", type: "search", placeholder: "filter lanes  /", "aria-label": "filter lanes", title: "words that lanes must have; a|b is either; -word is without",
        oninput: () => { app.options.filter = this.filter.value; app.layout(); } });
      this.search = make("input", { id: "search", type: "search", placeholder: "search steps  s", "aria-label": "search steps",
        oninput: () => this.find(), onkeydown: (event) => event.key === "Enter" && this.jump(event.shiftKey ? -1 : 1) });
      this.found = make("span", { id: "found", "aria-live": "polite" });
      this.nodes = make("span", { id: "nodes", role: "group", "aria-label": "node nets" });
      this.fold = button("fold", "Fold", "fold runs of steps without a mark on the lanes shown (f)", () => app.setFold(!app.fold));
      this.causes = button("causes", "Causes", "show only the steps that brought the outcome about (C)", () => app.setOnlyCauses(!app.onlyCauses));
      this.time = button("time", "Time", "by wall-clock time, or by number of firings (t)", () => app.setTime(!app.time));
      document.getElementById("tools").append(
        this.filter, this.nodes, this.fold, this.causes, this.time,
        button("out", "−", "smaller (-)", () => app.view.zoomBy(1 / 1.5)), button("in", "+", "larger (+)", () => app.view.zoomBy(1.5)), button("fit", "Fit", "all in the window (0)", () => app.view.fit()),
        make("span", { class: "finder" }, this.search, button("before", "‹", "match before", () => this.jump(-1)), button("after", "›", "next match", () => this.jump(1)), this.found),
        app.breakpoints.button,
        button("dark", "◐", "dark or light (d)", () => app.setTheme(app.themeName === "dark" ? "light" : "dark")),
        button("save", "SVG", "save as a picture", () => this.save()),
        button("help", "?", "keys (?)", () => document.getElementById("keys").showModal()));
    }

    update() {
      const app = this.app, data = app.traces[0];
      this.fold.setAttribute("aria-pressed", String(app.fold));
      this.fold.disabled = app.time || app.onlyCauses;
      this.causes.hidden = !app.traces.some((one) => one.cause);
      this.causes.setAttribute("aria-pressed", String(app.onlyCauses));
      this.time.setAttribute("aria-pressed", String(app.time));
      this.time.hidden = !data.timed;
      const said = JSON.stringify([data.nodes, [...app.options.nodes], app.options.hidden.size, app.themeName]);
      if (said === this.said) return;
      this.said = said;
      this.nodes.replaceChildren(...data.nodes.map((node, index) => make("button", {
        class: "node", "data-node": node, "aria-pressed": String(!app.options.nodes.has(node)), title: `show or hide the lanes of ${node}`,
        onclick: () => { const left = app.options.nodes; if (left.has(node)) left.delete(node); else left.add(node); app.layout(); },
      }, make("i", { style: `background:${T.nodeColour(app.theme, data, index)}` }, T.nodeLetter(data, index)), node)),
      ...(app.options.hidden.size ? [make("button", { id: "unhide", onclick: () => { app.options.hidden.clear(); app.layout(); } }, `${app.options.hidden.size} hidden`)] : []));
    }

    find() {
      const data = this.app.traces[0], asked = this.search.value.trim().toLowerCase();
      this.matches = [];
      if (asked) {
        const said = (table) => new Set(table.flatMap((name, i) => (name.toLowerCase().includes(asked) ? [i] : [])));
        const texts = said(data.texts), names = said(data.transitions), places = said(data.places);
        data.steps.forEach((step, i) => {
          const change = step.c || [], details = step.d;
          let hit = texts.has(step.x) || names.has(step.t);
          for (let j = 0; j < change.length && !hit; j += 2) hit = places.has(change[j]);
          if (!hit && details) hit = JSON.stringify(details).toLowerCase().includes(asked);
          if (hit) this.matches.push(i);
        });
      }
      this.tell();
    }

    tell() {
      if (!this.search.value.trim()) { this.found.textContent = ""; return; }
      const at = this.matches.indexOf(this.app.cursor);
      this.found.textContent = `${at >= 0 ? `${at + 1} of ` : ""}${this.matches.length}`;
    }

    jump(direction) {
      if (!this.matches.length) return;
      const at = T.lastAtMost(this.matches, this.app.cursor);
      const on = at >= 0 && this.matches[at] === this.app.cursor;
      const next = direction > 0 ? at + 1 : on ? at - 1 : at;
      this.app.select(this.matches[(next + this.matches.length) % this.matches.length]);
      this.tell();
    }

    save() {
      const picture = this.app.figure();
      const link = make("a", { href: URL.createObjectURL(new Blob([picture], { type: "image/svg+xml" })), download: "trace.svg" });
      link.click();
      setTimeout(() => URL.revokeObjectURL(link.href), 1000);
    }
  };
})((globalThis.DinerosTrace ??= {}));
