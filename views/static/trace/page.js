// The page: one cursor for lanes, detail and net.
(function (T) {
  "use strict";
  const { make } = T;

  const remember = (name, value) => { try { localStorage.setItem(`dineros.${name}`, value); } catch { /* a page from a file may have no storage */ } };
  const recall = (name) => { try { return localStorage.getItem(`dineros.${name}`); } catch { return null; } };

  T.App = class {
    constructor(content) {
      this.content = content;
      this.views = [content.view, ...(content.other ? [content.other] : [])];
      this.traces = this.views.map((view) => new T.Data(view));
      this.divergence = content.divergence || null;
      this.options = { filter: "", closed: new Set(), open: new Set(), nodes: new Set(), hidden: new Set() };
      this.lane = null;
      this.fold = false;
      this.onlyCauses = false;
      this.time = this.traces[0].timed && content.time !== false;
      this.cursor = this.traces[0].length ? 0 : -1;
      this.following = false;
      const preferred = globalThis.matchMedia && matchMedia("(prefers-color-scheme: dark)").matches ? "dark" : "light";
      this.view = new T.LanesView(this);
      this.breakpoints = new T.Breakpoints(this);
      this.tools = new T.Tools(this);
      this.net = T.NetPane && content.net ? new T.NetPane(this, content.net) : null;
      T.bindKeys(this);
      this.setTheme(recall("theme") || preferred, false);
      const asked = /^#(\d+)$/.exec(location.hash);
      this.select(asked ? Math.min(asked[1] - 1, this.traces[0].length - 1) : this.divergence ? this.divergence.a : this.cursor);
      addEventListener("beforeprint", () => document.getElementById("print").replaceChildren(this.printed()));
      this.head();
      this.bindGrip();
    }

    /** The border between lanes and detail can be moved. */
    bindGrip() {
      const grip = document.getElementById("grip"), main = document.querySelector("main");
      const set = (width) => main.style.setProperty("--side", `${Math.round(Math.max(200, Math.min(width, innerWidth - 300)))}px`);
      grip.addEventListener("pointerdown", (event) => grip.setPointerCapture(event.pointerId));
      grip.addEventListener("pointermove", (event) => grip.hasPointerCapture(event.pointerId) && set(innerWidth - event.clientX - 4));
    }

    get theme() { return T.themes[this.themeName]; }

    head() {
      const view = this.views[0];
      document.title = `${view.title} – trace`;
      const lines = this.views.map((one, number) => {
        const bad = /violated|unreachable|does not/.test(one.verdict || "");
        return make("div", { class: "titles" },
          this.views.length > 1 && make("b", { class: "side" }, "AB"[number]),
          make("h1", {}, one.title),
          one.verdict && make("span", { class: `verdict ${bad ? "bad" : "good"}` }, one.verdict),
          one.property && make("code", { class: "property" }, one.property),
          T.causeButton(this, number),
          make("small", { class: "facts" }, this.facts(number)));
      });
      document.getElementById("head").replaceChildren(...lines);
    }

    facts(number) {
      const data = this.traces[number], view = this.views[number];
      const loop = data.loop === null || data.loop === undefined ? "" : `, loop ${data.loop + 1}–${data.length}`;
      const lasts = data.timed && data.length ? `, ${T.seconds(data.times[data.length - 1])}` : "";
      const apart = number === 0 && this.divergence ? `; first divergence at step ${this.divergence.a + 1}` : number === 0 && this.views.length > 1 ? "; no divergence" : "";
      return `${view.kind} of ${view.model || "a net"}${view.variant ? ` (${view.variant})` : ""}: ${data.length} steps${loop}${lasts}${apart}`;
    }

    layout() { this.tools.update(); this.view.layout(); }

    setTheme(name, keep = true) {
      this.themeName = name === "dark" ? "dark" : "light";
      document.documentElement.dataset.theme = this.themeName;
      for (const [key, value] of Object.entries(this.theme)) if (typeof value === "string") document.documentElement.style.setProperty(`--${key}`, value);
      if (keep) remember("theme", this.themeName);
      if (this.net) this.net.setTheme(this.themeName);
      this.layout();
      this.tell();
    }

    setFold(fold) { if (!this.time) { this.fold = fold; this.layout(); this.view.reveal(this.cursor); } }

    setOnlyCauses(on) {
      if (!this.traces.some((data) => data.cause)) return;
      if (on && this.time) this.time = false; // folding is by number
      this.onlyCauses = on;
      this.layout();
      this.view.reveal(this.cursor);
    }

    setTime(time) {
      if (!this.traces[0].timed) return;
      if (time) this.onlyCauses = false;
      this.time = time;
      this.layout();
      this.view.reveal(this.cursor);
    }

    /** Moves the cursor: lanes, detail and net follow. */
    select(step, reveal = true) {
      this.cursor = step;
      if (reveal) {
        this.following = false;
        if (this.onfollow) this.onfollow();
        this.view.reveal(step);
        if (location.protocol !== "about:" && !this.content.live) history.replaceState(null, "", `#${step + 1}`);
      }
      this.view.draw();
      this.tell();
    }

    tell() {
      const panel = document.getElementById("detail");
      panel.replaceChildren(...this.traces.map((data, number) => T.detailOf(this, number, this.cursor)));
      if (this.net) this.net.show(this.traces[0], this.cursor);
      if (this.tools) this.tools.tell();
    }

    scrolled() { if (this.onscrolled) this.onscrolled(); }

    choose(key) { this.lane = key; this.layout(); }

    chooseNext(direction) {
      const lanes = this.view.rows.filter((row) => row.type === "lane");
      if (!lanes.length) return;
      const keys = [...new Set(lanes.map((row) => row.key))], at = keys.indexOf(this.lane);
      this.lane = keys[at < 0 ? (direction > 0 ? 0 : keys.length - 1) : Math.max(0, Math.min(at + direction, keys.length - 1))];
      const row = lanes.find((one) => one.key === this.lane), scroller = this.view.scroller;
      if (row.y < scroller.scrollTop) scroller.scrollTop = row.y - 24;
      else if (row.y + row.height > scroller.scrollTop + scroller.clientHeight) scroller.scrollTop = row.y + row.height - scroller.clientHeight + 8;
      this.layout();
    }

    toMark(direction) {
      const lane = this.traces[0].lanes.find((one) => T.laneKey(one) === this.lane);
      if (!lane || !lane.at.length) return;
      const found = direction > 0 ? T.lastAtMost(lane.at, this.cursor) + 1 : T.lastAtMost(lane.at, this.cursor - 1);
      if (lane.at[found] !== undefined) this.select(lane.at[found]);
    }

    hideChosen() { if (this.lane) { this.options.hidden.add(this.lane); this.lane = null; this.layout(); } }

    figure(theme = this.themeName) {
      const views = this.traces.map((data, i) => ({ ...this.views[i], ...data, steps: data.steps, lanes: data.lanes.map(({ at, marks, calls, ...lane }) => lane) }));
      return T.figure(views, { theme, time: this.time, fold: this.fold, causes: this.onlyCauses, filter: this.options.filter, divergence: this.divergence });
    }

    printed() {
      const picture = new DOMParser().parseFromString(this.figure("light"), "image/svg+xml").documentElement;
      picture.removeAttribute("height");
      picture.setAttribute("width", "100%");
      return picture;
    }
  };

  T.start = function () {
    const content = JSON.parse(document.getElementById("content").textContent);
    if (content.live) T.startLive(content);
    else globalThis.dinerosTrace = new T.App(content);
  };
})((globalThis.DinerosTrace ??= {}));
