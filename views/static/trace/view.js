// The lanes on a canvas: only what the window shows is drawn, whenever something has changed.
(function (T) {
  "use strict";

  const LEAST_CELL = 7, MOST = 12e6; // pixels: of a step at first, and of all steps

  T.LanesView = class {
    constructor(app) {
      this.app = app;
      const find = (name) => document.getElementById(name);
      this.scroller = find("scroller");
      this.spacer = find("spacer");
      this.labels = find("labels");
      this.canvas = find("lanes");
      this.top = find("top");
      this.map = find("minimap");
      this.tip = find("tip");
      this.zoom = null;
      this.frames = 0; // pictures drawn so far; the tests count them
      this.scroller.addEventListener("scroll", () => { this.labels.scrollTop = this.scroller.scrollTop; this.draw(); app.scrolled(); }, { passive: true });
      this.scroller.addEventListener("click", (event) => app.select(this.stepAt(event)));
      this.scroller.addEventListener("mousemove", (event) => this.hover(event));
      this.scroller.addEventListener("mouseleave", () => (this.tip.hidden = true));
      this.scroller.addEventListener("wheel", (event) => {
        if (!event.ctrlKey && !event.metaKey) return;
        event.preventDefault();
        this.zoomBy(Math.exp(-event.deltaY / 300), this.offset(event));
      }, { passive: false });
      this.top.addEventListener("click", (event) => app.select(this.stepAt(event)));
      let dragging = false;
      const jump = (event) => {
        const box = this.map.getBoundingClientRect();
        this.scroller.scrollLeft = ((event.clientX - box.left) / box.width) * this.scale.width - this.width / 2;
      };
      this.map.addEventListener("pointerdown", (event) => { dragging = true; this.map.setPointerCapture(event.pointerId); jump(event); });
      this.map.addEventListener("pointermove", (event) => dragging && jump(event));
      this.map.addEventListener("pointerup", () => (dragging = false));
      new ResizeObserver(() => this.resize()).observe(this.scroller);
    }

    get width() { return this.scroller.clientWidth || 600; }
    get scale() { return this.scales[0]; }

    /** Rows, scales and sizes anew: the trace, the filter, folding or the axis has changed. */
    layout() {
      const app = this.app;
      const kept = this.scales ? { step: this.scale.step(this.scroller.scrollLeft), time: this.scale.time } : null;
      const { rows, height } = T.rowsOf(app.traces, app.options);
      this.rows = rows;
      this.laidOut = (this.laidOut || 0) + 1;
      this.height = height;
      const lanes = rows.filter((row) => row.type === "lane");
      const shown = app.onlyCauses
        ? new Set([...app.traces.flatMap((data) => [...data.causal]), app.cursor])
        : app.fold ? new Set([...app.traces.flatMap((data, i) => [...T.stepsOf(lanes.filter((row) => row.trace === i).map((row) => row.lane))]), app.cursor]) : null;
      const before = this.scales;
      this.scales = app.traces.map((data) => new T.Scale(data, { time: app.time, shown, least: app.onlyCauses ? 1 : undefined }));
      this.total = Math.max(...this.scales.map((scale) => scale.total));
      for (const scale of this.scales) scale.total = this.total; // both traces end at the same place
      if (this.zoom === null || !before || before[0].time !== this.scale.time) this.zoom = this.fitting();
      this.setZoom(this.zoom);
      document.getElementById("axis").textContent = this.scale.time ? "wall-clock time" : "firings";
      this.spacer.style.height = `${height + 8}px`;
      if (kept && kept.time === this.scale.time) this.scroller.scrollLeft = this.scale.left(kept.step);
      // A label that is rebuilt under the mouse would lose the click, so it is not while nothing about it changed.
      const said = JSON.stringify([app.lane, app.themeName, app.traces.length, rows.map((row) => [row.type, row.key, row.label, row.y, row.count, row.closed, row.open, row.trace])]);
      if (said !== this.said) { this.said = said; T.drawLabels(app, rows, this.labels); }
      this.draw();
    }

    fitting() {
      const fit = (this.width - 12) / this.total;
      return this.scale.time ? fit : Math.max(fit > 40 ? 40 : fit, LEAST_CELL);
    }

    setZoom(zoom) {
      const least = Math.min((this.width - 12) / this.total, this.scale.time ? Infinity : LEAST_CELL);
      this.zoom = Math.max(least, Math.min(zoom, this.scale.time ? MOST / this.total : Math.min(60, MOST / this.total)));
      for (const scale of this.scales) scale.zoom = this.zoom;
      this.spacer.style.width = `${Math.ceil(this.scale.width) + 12}px`;
    }

    zoomBy(factor, at = this.width / 2) {
      const place = (this.scroller.scrollLeft + at) / this.zoom;
      this.setZoom(this.zoom * factor);
      this.scroller.scrollLeft = place * this.zoom - at;
      this.draw();
    }

    fit() {
      this.setZoom((this.width - 12) / this.total);
      this.scroller.scrollLeft = 0;
      this.draw();
    }

    resize() { if (this.rows) { this.setZoom(this.zoom); this.draw(); } }

    offset(event) { return event.clientX - this.scroller.getBoundingClientRect().left; }
    stepAt(event) { return this.scale.step(this.scroller.scrollLeft + this.offset(event)); }

    /** Scrolls as little as shows a step with some room around it. */
    reveal(step) {
      const x = this.scale.x(step), left = this.scroller.scrollLeft, room = Math.min(60, this.width / 4);
      if (x < left + room) this.scroller.scrollLeft = x - room * 2;
      else if (x > left + this.width - room) this.scroller.scrollLeft = x - this.width + room * 2;
    }

    draw() {
      if (this.asked) return;
      this.asked = true;
      requestAnimationFrame(() => { this.asked = false; this.paint(); });
    }

    surface(canvas, width, height) {
      const ratio = globalThis.devicePixelRatio || 1;
      if (canvas.width !== Math.round(width * ratio) || canvas.height !== Math.round(height * ratio)) {
        canvas.width = Math.round(width * ratio);
        canvas.height = Math.round(height * ratio);
        canvas.style.width = `${width}px`;
        canvas.style.height = `${height}px`;
      }
      const context = canvas.getContext("2d");
      context.setTransform(ratio, 0, 0, ratio, 0, 0);
      context.clearRect(0, 0, width, height);
      return new T.CanvasSurface(context);
    }

    seen(number, surface) {
      const scale = this.scales[number], data = this.app.traces[number], left = this.scroller.scrollLeft;
      return {
        surface, data, scale, theme: this.app.theme, dx: -left, left: 0, width: this.width,
        from: Math.max(0, scale.step(left) - 1), to: Math.min(data.length - 1, scale.step(left + this.width) + 1),
      };
    }

    paint() {
      const app = this.app, theme = app.theme, width = this.width, height = this.scroller.clientHeight;
      if (!this.rows || !height) return;
      this.frames++;
      const surface = this.surface(this.canvas, width, height);
      const views = app.traces.map((data, number) => this.seen(number, surface));
      T.drawGround(views[0], 0, height);
      T.drawCauseLine(views[0], 0, height);
      const above = this.scroller.scrollTop;
      for (const row of this.rows) {
        const y = row.y - above;
        if (y + row.height < 0 || y > height) continue;
        if (row.type === "heading") surface.rect(0, y + 3, width, row.height - 4, { fill: theme.panel, opacity: 0.8 });
        else if (row.type === "lane" && views[row.trace].data.length) {
          if (row.key === app.lane) surface.rect(0, y, width, row.height, { fill: theme.cursor, opacity: 0.07 });
          surface.clip(0, y, width, row.height);
          T.drawLane(views[row.trace], row.lane, y, row.height);
          surface.unclip();
        }
      }
      this.cursorLine(surface, 0, height);
      this.divergenceLine(surface, height);
      this.paintTop(width);
      this.paintMap();
    }

    cursorLine(surface, y, height) {
      const x = this.scale.x(this.app.cursor) - this.scroller.scrollLeft;
      surface.path([[x, y], [x, y + height]], { stroke: this.app.theme.cursor, width: 1.5 });
    }

    divergenceLine(surface, height) {
      const apart = this.app.divergence;
      if (!apart) return;
      const x = this.scale.left(apart.a) - this.scroller.scrollLeft;
      surface.path([[x, 0], [x, height]], { stroke: this.app.theme.cursor, width: 2, dash: [6, 4] });
      surface.text(x + 4, 12, `first divergence: ${apart.a + 1}`, { fill: this.app.theme.cursor, size: 10.5, bold: true });
    }

    paintTop(width) {
      const traces = this.app.traces.length, height = 35 + 18 * traces;
      const surface = this.surface(this.top, width, height);
      const seen = this.app.traces.map((data, number) => this.seen(number, surface));
      T.drawRuler(seen[0], 0, 34);
      T.drawCauseFlag(seen[0], 0, 34);
      T.drawStops(seen[0], this.app.breakpoints.steps(), 0, 34);
      seen.forEach((one, number) => {
        if (!one.data.length) return;
        T.drawStrip(one, 36 + 18 * number, 13);
        T.drawCauseBars(one, 49.5 + 18 * number);
      });
      const x = this.scale.x(this.app.cursor) - this.scroller.scrollLeft;
      this.cursorLine(surface, 0, height);
      surface.path([[x - 5, 0], [x + 5, 0], [x, 7]], { fill: this.app.theme.cursor, closed: true });
    }

    paintMap() {
      const width = this.map.parentElement.clientWidth, height = 30, theme = this.app.theme;
      const surface = this.surface(this.map, width, height);
      // The trace in it is drawn once for each layout: it is all steps, while the window shows few.
      const said = JSON.stringify([this.laidOut, width, this.app.themeName]);
      if (said !== this.mapped) {
        this.mapped = said;
        this.mapPicture ||= document.createElement("canvas");
        T.drawMinimap({ ...this.seen(0, this.surface(this.mapPicture, width, height)), width, left: 0 }, 0, height);
      }
      surface.context.drawImage(this.mapPicture, 0, 0, width, height);
      const ratio = width / this.scale.width;
      surface.rect(this.scroller.scrollLeft * ratio + 1, 1, Math.min(width, Math.max(4, this.width * ratio)) - 2, height - 2, { stroke: theme.ink, width: 1.5 });
      const x = this.scale.x(this.app.cursor) * ratio;
      surface.path([[x, 0], [x, height]], { stroke: theme.cursor, width: 1.5 });
    }

    hover(event) {
      const step = this.stepAt(event), data = this.app.traces[0];
      const y = event.clientY - this.scroller.getBoundingClientRect().top + this.scroller.scrollTop;
      const row = this.rows.find((one) => one.type === "lane" && y >= one.y && y < one.y + one.height);
      if (step < 0 || !data.length) return;
      T.fillTip(this.tip, this.app, step, row);
      this.tip.hidden = false;
      const box = this.tip.getBoundingClientRect();
      this.tip.style.left = `${Math.min(event.clientX + 14, innerWidth - box.width - 8)}px`;
      this.tip.style.top = `${event.clientY + 18 + box.height > innerHeight ? event.clientY - box.height - 8 : event.clientY + 18}px`;
    }
  };
})((globalThis.DinerosTrace ??= {}));
