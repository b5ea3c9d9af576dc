// Breakpoints: set by the user, kept by the browser for each model, shown as a list and as stop signs on the ruler.
(function (T) {
  "use strict";
  const { make } = T;

  T.Breakpoints = class {
    constructor(app) {
      this.app = app;
      this.watches = [];
      this.shown = false;
      this.stored = true;
      this.button = make("button", { id: "breaks-button", "aria-controls": "breaks", "aria-expanded": "false", title: "breakpoints (b)", onclick: () => (this.watches.length ? this.field.focus() : this.toggle()) });
      this.field = make("input", { id: "break", type: "text", list: "break-names", autocomplete: "off", spellcheck: "false", placeholder: "Place >= 3, T, !signal(S), drop", "aria-label": "new breakpoint",
        title: "Place >= 3; a transition; a signal, signal(S) or !signal(S); a kind of record: drop, error, timeout …" });
      this.names = make("datalist", { id: "break-names" });
      this.list = make("ul", { "aria-label": "breakpoints set" });
      this.message = make("span", { id: "break-message", role: "status" });
      const step = (text, title, direction) => make("button", { type: "button", title, "aria-label": title, onclick: () => this.jump(direction) }, text);
      this.form = make("form", { onsubmit: (event) => { event.preventDefault(); this.submit(); } }, this.field, this.names, make("button", {}, "Add"));
      this.box = make("section", { id: "breaks", "aria-label": "breakpoints" }, this.form,
        make("span", { class: "finder" }, step("‹", "to the previous breakpoint (,)", -1), step("›", "to the next breakpoint (.)", 1)), this.list, this.message);
      document.getElementById("tools").after(this.box);
      addEventListener("storage", (event) => event.key === this.key && this.load());
      this.load();
    }

    get data() { return this.app.traces[0]; }
    get key() { return `dineros.breakpoints.${this.app.views[0].model || ""}`; }

    /** Reads what the browser has kept for this model; what a page set before it knew its model is kept as well. */
    load() {
      const unnamed = "dineros.breakpoints.", named = this.key !== unnamed;
      const before = this.loadedFrom === unnamed ? this.watches.map((watch) => watch.condition.text) : [];
      let texts = [];
      try {
        const kept = JSON.parse(localStorage.getItem(this.key) || "[]");
        if (named && this.loadedFrom === unnamed) localStorage.removeItem(unnamed);
        if (Array.isArray(kept)) texts = kept.filter((text) => typeof text === "string");
      } catch (error) {
        if (!(error instanceof SyntaxError)) this.stored = false; // a page from a file may have no storage
      }
      this.loadedFrom = this.key;
      const conditions = new Map([...texts, ...before].map((text) => T.parseCondition(text)).filter(Boolean).map((condition) => [condition.text, condition]));
      this.watches = [...conditions.values()].map((condition) => new T.Watch(condition));
      if (before.length) this.save();
      this.update();
    }

    save() {
      try { localStorage.setItem(this.key, JSON.stringify(this.watches.map((watch) => watch.condition.text))); } catch { this.stored = false; }
    }

    /** Looks at the steps that have come; another model has other breakpoints. */
    look() {
      if (this.loadedFrom !== this.key) this.load(); else this.update();
    }

    /** All steps at which a breakpoint is hit, ascending. */
    steps() { return this.all || []; }

    /** The first hit at a step or after it: the step, and the texts of the breakpoints; or null. */
    hitFrom(index) {
      const step = this.steps()[T.lastAtMost(this.steps(), index - 1) + 1];
      return step === undefined ? null : { step, texts: this.textsAt(step) };
    }

    textsAt(step) { return this.watches.filter((watch) => watch.hits[T.lastAtMost(watch.hits, step)] === step).map((watch) => watch.condition.text); }

    submit() {
      const text = this.field.value, condition = T.parseCondition(text);
      if (!condition) return this.refuse(text.trim() ? `${text.trim()} is no breakpoint: say Place >= 3, a transition, a signal, or a kind of record` : "say what to stop at");
      const unknown = this.app.views[0].model ? T.unknownIn(this.data, condition) : null; // before a run has begun, nothing is known
      if (unknown) return this.refuse(unknown);
      this.field.value = "";
      this.add(condition);
      return undefined;
    }

    refuse(text) {
      this.field.setAttribute("aria-invalid", "true");
      this.say(text, "wrong");
    }

    add(condition) {
      if (!this.watches.some((watch) => watch.condition.text === condition.text)) this.watches.push(new T.Watch(condition));
      this.save();
      this.update();
      const hits = this.watches.find((watch) => watch.condition.text === condition.text).hits.length;
      this.say(`${condition.text}: ${hits ? `hit ${hits} ${hits === 1 ? "time" : "times"} so far` : "not hit so far"}`);
      this.field.focus();
    }

    remove(text) {
      this.watches = this.watches.filter((watch) => watch.condition.text !== text);
      this.save();
      this.update();
      this.say(`${text} removed`);
      (this.list.querySelector("button") || this.field).focus();
    }

    say(text, kind = "") {
      if (kind !== "wrong") this.field.removeAttribute("aria-invalid");
      this.message.textContent = text;
      this.message.dataset.kind = kind;
    }

    toggle(on = !this.shown) {
      this.shown = on;
      this.update();
      if (on) this.field.focus();
    }

    /** Opens the list, with what is chosen in the field. */
    open() {
      this.toggle(true);
      const lane = this.data.lanes.find((one) => T.laneKey(one) === this.app.lane);
      if (lane && lane.kind === "transition") this.field.value = `fired(${lane.id})`;
      else if (lane && lane.kind === "signal") this.field.value = `signal(${lane.id})`;
      else if (lane && lane.kind === "place") this.field.value = `${lane.id} >= ${this.data.level(lane, this.app.cursor) + 1}`;
      this.field.select();
    }

    jump(direction, hits = this.steps()) {
      if (!hits.length) return this.say(this.watches.length ? "no breakpoint is hit so far" : "no breakpoint is set: press b");
      const at = direction > 0 ? T.lastAtMost(hits, this.app.cursor) + 1 : T.lastAtMost(hits, this.app.cursor - 1);
      if (hits[at] === undefined) return this.say(direction > 0 ? "no breakpoint is hit after this step" : "no breakpoint is hit before this step");
      this.app.select(hits[at]);
      return this.say(`step ${hits[at] + 1}: ${this.textsAt(hits[at]).join(", ")}`, "hit");
    }

    update() {
      const hits = new Set();
      for (const watch of this.watches) for (const step of watch.look(this.data)) hits.add(step);
      if (this.watches.length === 1) this.all = this.watches[0].hits.slice();
      else this.all = [...hits].sort((a, b) => a - b);
      const count = this.watches.length, open = this.shown || count > 0;
      this.button.textContent = count ? `Breakpoints ${count}` : "Breakpoints";
      this.button.setAttribute("aria-expanded", String(open));
      this.box.hidden = !open;
      const said = JSON.stringify([this.stored, this.watches.map((watch) => [watch.condition.text, watch.hits.length, this.unknown(watch)])]);
      if (said !== this.said) { this.said = said; this.drawList(); }
      if (this.shown && !this.names.childElementCount) this.suggest();
      if (this.app.view && this.app.view.rows) this.app.view.draw();
    }

    unknown(watch) { return this.data.length && this.app.views[0].model ? T.unknownIn(this.data, watch.condition) : null; }

    drawList() {
      const focused = document.activeElement && document.activeElement.closest && document.activeElement.closest("#breaks li");
      const which = focused && [focused.dataset.text, document.activeElement.className];
      this.list.replaceChildren(...this.watches.map((watch) => {
        const { text } = watch.condition, unknown = this.unknown(watch), hits = watch.hits.length;
        return make("li", { "data-text": text, class: unknown ? "unknown" : "" },
          make("button", { class: "goto", title: unknown || `to the next step where ${text}`, onclick: () => this.jump(1, watch.hits) }, make("i", { "aria-hidden": "true" }), make("code", {}, text),
            make("small", {}, unknown ? " not in this trace" : ` ${hits} ${hits === 1 ? "hit" : "hits"}`)),
          make("button", { class: "remove", title: `remove ${text}`, "aria-label": `remove breakpoint ${text}`, onclick: () => this.remove(text) }, "×"));
      }), ...(this.stored || !this.watches.length ? [] : [make("li", { class: "unstored" }, "kept until this page is closed: the browser stores nothing for it")]));
      if (which) for (const item of this.list.children) if (item.dataset.text === which[0]) item.querySelector(`.${which[1]}`).focus(); // the list was drawn anew under the keyboard
    }

    suggest() {
      const { transitions, places, signals } = T.namesOf(this.data);
      const option = (value, label) => make("option", { value, label });
      this.names.replaceChildren(...T.EVENTS.slice(0, 3).map((name) => option(name, "kind of record")), ...transitions.map((name) => option(`fired(${name})`, "transition")),
        ...signals.flatMap((name) => [option(`signal(${name})`, "becomes true"), option(`!signal(${name})`, "becomes false")]),
        ...places.filter((name) => this.data.inModel(name)).map((name) => option(`${name} >= 1`, "place")));
    }
  };
})((globalThis.DinerosTrace ??= {}));
