// The net beside the trace, at the marking of the cursor: what the step changed is pointed out.
(function (T) {
  "use strict";
  const { make } = T;

  T.NetPane = class {
    constructor(app, content) {
      this.app = app;
      this.box = document.getElementById("net");
      this.follow = true;
      this.setContent(content);
    }

    setContent(content) {
      this.content = content;
      const svg = document.createElementNS("http://www.w3.org/2000/svg", "svg");
      this.svg = svg;
      this.picture = NetRenderer.draw(svg, content);
      this.size = [content.width, content.height];
      this.view = { x: 0, y: 0, scale: null };
      const button = (text, title, onclick) => make("button", { title, onclick }, text);
      this.following = button("Follow", "keep the step's elements in sight", () => { this.follow = !this.follow; this.pressed(); this.refresh(); });
      this.box.replaceChildren(svg, make("div", { class: "nettools" }, this.following,
        button("−", "smaller", () => this.zoom(1 / 1.4)), button("+", "larger", () => this.zoom(1.4)), button("Fit", "the whole net", () => { this.setFollow(false); this.fit(); })));
      this.pressed();
      this.bind();
      this.setTheme(this.app.themeName || "light");
      new ResizeObserver(() => { if (this.view.scale === null) { this.fit(); this.refresh(); } this.place(); }).observe(this.box);
    }

    pressed() { this.following.setAttribute("aria-pressed", String(this.follow)); }
    setFollow(on) { this.follow = on; this.pressed(); }

    bind() {
      let from = null;
      this.svg.addEventListener("pointerdown", (event) => { from = [event.clientX, event.clientY]; this.svg.setPointerCapture(event.pointerId); });
      this.svg.addEventListener("pointermove", (event) => {
        if (!from) return;
        this.setFollow(false);
        this.view.x -= (event.clientX - from[0]) / this.view.scale;
        this.view.y -= (event.clientY - from[1]) / this.view.scale;
        from = [event.clientX, event.clientY];
        this.place();
      });
      this.svg.addEventListener("pointerup", () => (from = null));
      this.svg.addEventListener("wheel", (event) => {
        event.preventDefault();
        const box = this.box.getBoundingClientRect();
        this.zoom(Math.exp(-event.deltaY / 400), event.clientX - box.left, event.clientY - box.top);
      }, { passive: false });
    }

    get room() { return [this.box.clientWidth || 300, this.box.clientHeight || 300]; }

    fit() {
      const [width, height] = this.room;
      this.view.scale = Math.min(width / this.size[0], height / this.size[1]) * 0.98;
      this.view.x = (this.size[0] - width / this.view.scale) / 2;
      this.view.y = (this.size[1] - height / this.view.scale) / 2;
      this.place();
    }

    zoom(factor, x = this.room[0] / 2, y = this.room[1] / 2) {
      const scale = Math.max(0.05, Math.min(4, this.view.scale * factor));
      this.view.x += x / this.view.scale - x / scale;
      this.view.y += y / this.view.scale - y / scale;
      this.view.scale = scale;
      this.place();
    }

    place() {
      if (this.view.scale === null) return;
      const [width, height] = this.room;
      this.svg.setAttribute("viewBox", `${this.view.x} ${this.view.y} ${width / this.view.scale} ${height / this.view.scale}`);
    }

    setTheme(name) { if (this.svg) this.svg.dataset.theme = name; }

    show(data, step) {
      this.last = [data, step];
      const marking = {}, initial = new Set();
      for (const name of data.places) initial.add(T.prototypeOf(name));
      for (const name of initial) marking[name] = 0;
      // The picture has each server page once: a place's tokens are those of all instances.
      for (const [place, tokens] of data.marking(Math.min(step, data.length - 1))) marking[T.prototypeOf(data.places[place])] += tokens;
      for (const node of this.content.nodes) if (node.kind === "place" && !(node.id in marking)) marking[node.id] = 0;
      this.picture.setMarking(marking);
      const signals = {};
      for (const lane of data.lanes) if (lane.kind === "signal") signals[lane.id] = Boolean(data.level(lane, step));
      this.picture.setSignals(signals);
      const touched = this.touched(data, step);
      this.picture.highlight(touched);
      this.box.dataset.step = step;
      if (this.follow) this.sight(touched);
    }

    refresh() { if (this.last) this.show(...this.last); }

    /** Ids of what a step is about: the transition or channel, places that changed, the signal. */
    touched(data, step) {
      if (step < 0 || step >= data.length) return [];
      const one = data.steps[step], found = new Set();
      const transition = data.transition(step);
      if (transition && (one.e === "fire" || one.e === "error")) found.add(T.prototypeOf(transition));
      for (let i = 0; i < (one.c || []).length; i += 2) found.add(T.prototypeOf(data.places[one.c[i]]));
      for (const [index] of one.m || []) {
        const lane = data.lanes[index];
        if (lane.channel) found.add(lane.channel);
        else if (lane.kind === "signal") found.add(lane.id);
      }
      return [...found].filter((id) => this.picture.element(id));
    }

    /** Moves the picture so that elements can be seen, at a size that can be read. */
    sight(ids) {
      const [width, height] = this.room;
      if (this.view.scale === null || width < 40 || height < 40) return;
      const spots = this.content.nodes.filter((node) => ids.includes(node.id) || (node.target && ids.includes(node.target) && ids.length < 2));
      if (!spots.length) return;
      const left = Math.min(...spots.map((spot) => spot.x)) - 70, right = Math.max(...spots.map((spot) => spot.x)) + 70;
      const top = Math.min(...spots.map((spot) => spot.y)) - 50, bottom = Math.max(...spots.map((spot) => spot.y)) + 60;
      const scale = Math.min(1.1, width / (right - left), height / (bottom - top));
      const inside = left >= this.view.x && top >= this.view.y && right <= this.view.x + width / this.view.scale && bottom <= this.view.y + height / this.view.scale;
      if (inside && this.view.scale > 0.5) return;
      this.view.scale = Math.max(scale, 0.15);
      this.view.x = (left + right) / 2 - width / this.view.scale / 2;
      this.view.y = (top + bottom) / 2 - height / this.view.scale / 2;
      this.place();
    }
  };
})((globalThis.DinerosTrace ??= {}));
