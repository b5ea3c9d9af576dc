// A trace in memory: its steps, what happened on each lane, and the marking after any step.
(function (T) {
  "use strict";

  const EVERY = 256; // steps between two kept markings

  /** Index of the last element <= value in a sorted array, or -1. */
  T.lastAtMost = function (sorted, value) {
    let low = 0, high = sorted.length;
    while (low < high) {
      const middle = (low + high) >> 1;
      if (sorted[middle] <= value) low = middle + 1; else high = middle;
    }
    return low - 1;
  };

  T.Data = class {
    constructor(view) {
      this.view = view;
      this.nodes = view.nodes;
      this.places = view.places;
      this.transitions = view.transitions;
      this.texts = view.texts;
      this.steps = [];
      this.times = []; // seconds from the first step, never falling
      this.start = null;
      this.lanes = [];
      this.kept = [new Map(view.initial)];
      this.last = new Map(view.initial);
      this.fired = new Set();
      this.cause = view.cause || null; // {first, steps, decided}: where the outcome may have begun
      this.causal = new Set(this.cause ? this.cause.steps : []);
      this.alarms = []; // steps with a lost message or an error
      view.lanes.forEach((lane) => this.addLane(lane));
      view.steps.forEach((step) => this.addStep(step));
    }

    get length() { return this.steps.length; }
    get timed() { return this.start !== null; }
    get loop() { return this.view.loop; }

    addLane(lane) {
      // `at` and `marks` go side by side: the step of each mark, and the mark without the lane's number.
      this.lanes.push({ ...lane, index: this.lanes.length, at: [], marks: [], calls: [] });
    }

    addStep(step) {
      const index = this.steps.length;
      this.steps.push(step);
      if (step.w !== undefined) {
        if (this.start === null) this.start = step.w;
        this.times.push(Math.max(step.w - this.start, index ? this.times[index - 1] || 0 : 0));
      } else this.times.push(index ? this.times[index - 1] : 0);
      if (step.e === "fire") this.fired.add(step.t);
      if (step.e === "drop" || step.e === "error") this.alarms.push(index);
      for (const [lane, ...mark] of step.m || []) this.addMark(this.lanes[lane], index, mark);
      this.change(this.last, index, 1);
      if (index % EVERY === EVERY - 1) this.kept.push(new Map(this.last));
    }

    addMark(lane, index, mark) {
      lane.at.push(index);
      lane.marks.push(mark);
      if (lane.kind !== "client") return;
      const [letter, number, instance] = mark;
      const call = (lane.calls[number - 1] ||= { number, first: index, timeouts: [] });
      if (letter === "q") call.request = index;
      else if (letter === "s") { call.serve = index; call.instance = instance; }
      else if (letter === "r") call.reply = index;
      else if (letter === "a") call.response = index;
      else call.timeouts.push(index);
    }

    append(change) {
      for (const table of ["nodes", "places", "transitions", "texts"]) this[table].push(...(change[table] || []));
      (change.lanes || []).forEach((lane) => this.addLane(lane));
      change.steps.forEach((step) => this.addStep(step));
    }

    change(marking, index, sign) {
      const change = this.steps[index].c || [];
      for (let i = 0; i < change.length; i += 2) {
        marking.set(change[i], (marking.get(change[i]) || 0) + sign * change[i + 1]);
      }
    }

    /** Tokens by number of the place after a step; -1 is before the first. */
    marking(step) {
      const kept = Math.min(Math.floor((step + 1) / EVERY), this.kept.length - 1);
      const marking = new Map(this.kept[kept]);
      for (let i = kept * EVERY; i <= step; i++) this.change(marking, i, 1);
      return marking;
    }

    /** Value or level of a lane after a step. */
    level(lane, step) {
      const found = T.lastAtMost(lane.at, step);
      return found < 0 ? lane.initial || 0 : lane.marks[found][1];
    }

    /** Whether a place stands in the model itself; the others the rules made. */
    inModel(place) {
      this.own ||= new Set(this.view.modelPlaces || []);
      return !this.own.size || this.own.has(place) || this.own.has(T.prototypeOf(place));
    }

    signal(name) { return this.lanes.find((lane) => lane.kind === "signal" && lane.id === name); }

    text(step) { return this.texts[this.steps[step].x]; }
    node(step) { const node = this.steps[step].n; return node === undefined ? null : this.nodes[node]; }
    transition(step) { const name = this.steps[step].t; return name === undefined ? null : this.transitions[name]; }

    /** Transitions of the model that never fire. */
    silent() {
      const fired = new Set([...this.fired].map((index) => this.transitions[index]));
      return this.view.known.filter((name) => !fired.has(name));
    }

    /** The clause of a step's transition: each literal with its value before the step, and the deciding ones. */
    clause(step) {
      const name = this.transition(step);
      if (!name || (this.steps[step].e !== "fire" && this.steps[step].e !== "error")) return null;
      const clause = this.view.clauses[name] || this.view.clauses[T.prototypeOf(name)];
      if (!clause) return null;
      const disjunctions = clause.cnf.map((literals) => literals.map(([signal, negated]) => {
        const lane = this.signal(signal);
        const value = lane ? Boolean(this.level(lane, step - 1)) : null;
        const found = lane ? T.lastAtMost(lane.at, step - 1) : -1;
        return { signal, negated, value, holds: value === null ? null : value !== negated, since: found < 0 ? -1 : lane.at[found] };
      }));
      // A disjunction holds since its first literal that still holds; the clause since its last disjunction does.
      let latest = null;
      for (const literals of disjunctions) {
        const holding = literals.filter((literal) => literal.holds);
        if (!holding.length) continue;
        const first = holding.reduce((a, b) => (a.since <= b.since ? a : b));
        if (latest === null || first.since > latest.since) latest = first;
      }
      if (latest) latest.deciding = true;
      return { text: clause.text, disjunctions };
    }
  };

  /** Id in the system model of an element of a server instance. */
  T.prototypeOf = function (name) {
    let rest = name, match;
    while ((match = /^.+?\[\d+\]\.(.+)$/.exec(rest))) rest = match[1];
    return rest;
  };

  /** Identity of a lane over two traces. */
  T.laneKey = (lane) => [lane.kind, lane.id, lane.channel, lane.queue].join("|");

  /** A duration in words; of a ruler, in the unit of its whole length. */
  T.seconds = function (value, whole = value) {
    const size = Math.abs(whole);
    if (size >= 3600) return `${Math.floor(value / 3600)}:${String(Math.floor(value / 60) % 60).padStart(2, "0")}:${String(Math.floor(value) % 60).padStart(2, "0")} h`;
    if (size >= 60) return `${Math.floor(value / 60)}:${String(Math.floor(value) % 60).padStart(2, "0")} min`;
    if (size >= 1 || size === 0) return `${+value.toFixed(3)} s`;
    return size >= 0.001 ? `${+(value * 1e3).toFixed(2)} ms` : `${+(value * 1e6).toFixed(0)} µs`;
  };
})((globalThis.DinerosTrace ??= {}));
