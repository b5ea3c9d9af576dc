// What a breakpoint waits for: its text, and the steps of a trace that fulfil it.
(function (T) {
  "use strict";

  T.EVENTS = ["drop", "error", "timeout", "publish", "take", "request", "serve", "reply", "response", "aside", "release", "transfer", "start", "checkpoint", "stop"];

  const COMPARE = {
    ">=": (a, b) => a >= b, "<=": (a, b) => a <= b, ">": (a, b) => a > b, "<": (a, b) => a < b, "==": (a, b) => a === b, "!=": (a, b) => a !== b,
  };
  const COMPARISON = /^(.+?)\s*(>=|<=|==|!=|=|>|<)\s*(\d+)$/;
  const VALUE = /^(.+?)\s*==?\s*(true|false)$/;
  const CALL = /^(!?)\s*(fired|signal)\s*\(\s*(.+?)\s*\)$/;
  const bare = (name) => name.trim().replace(/^"(.*)"$/, "$1");

  /**
   * A condition from its text: `Place >= 3`, `fired(T)`, `signal(S)`, `!signal(S)`, a kind of record such as `drop`, or the name
   * of a transition (it fires) or a signal (it changes). Null where the text is none.
   */
  T.parseCondition = function (text) {
    const said = text.trim();
    let found;
    if ((found = CALL.exec(said))) {
      if (found[2] === "signal") return { kind: "signal", name: bare(found[3]), value: !found[1], text: `${found[1]}signal(${bare(found[3])})` };
      return found[1] ? null : { kind: "fired", name: bare(found[3]), text: `fired(${bare(found[3])})` };
    }
    if ((found = VALUE.exec(said))) {
      const value = found[2] === "true", name = bare(found[1]);
      return { kind: "signal", name, value, text: `${value ? "" : "!"}signal(${name})` };
    }
    if ((found = COMPARISON.exec(said))) {
      const operator = found[2] === "=" ? "==" : found[2], name = bare(found[1]);
      return { kind: "place", name, operator, number: Number(found[3]), text: `${name} ${operator} ${found[3]}` };
    }
    if (!said || /[()<>=!]/.test(said)) return null;
    if (T.EVENTS.includes(said.toLowerCase())) return { kind: "event", name: said.toLowerCase(), text: said.toLowerCase() };
    return { kind: "name", name: bare(said), text: bare(said) };
  };

  const named = (id, name) => id === name || T.prototypeOf(id) === name;

  /** Names that a trace knows, by kind; those of server instances also by the name in the model. */
  T.namesOf = function (data) {
    const both = (names) => [...new Set(names.flatMap((name) => [name, T.prototypeOf(name)]))];
    return {
      transitions: both([...data.view.known, ...data.transitions]),
      places: both([...(data.view.modelPlaces || []), ...data.places]),
      signals: data.lanes.filter((lane) => lane.kind === "signal").map((lane) => lane.id),
    };
  };

  /** Why a condition can never be fulfilled as far as a trace is known; null where it can. */
  T.unknownIn = function (data, condition) {
    const { transitions, places, signals } = T.namesOf(data);
    const { kind, name } = condition;
    if (kind === "event") return null;
    if (kind === "place") return places.includes(name) ? null : `no place is named ${name}`;
    if (kind === "signal") return signals.includes(name) ? null : `no signal is named ${name}`;
    if (kind === "fired") return transitions.includes(name) ? null : `no transition is named ${name}`;
    if (transitions.includes(name) || signals.includes(name)) return null;
    return places.includes(name) ? `${name} is a place: say how many tokens, such as ${name} >= 1` : `no transition, signal or kind of record is named ${name}`;
  };

  /** Steps that fulfil a condition; it grows with the trace. */
  T.Watch = class {
    constructor(condition) { this.condition = condition; }

    /** Looks at the steps that are new; all of them where it is another trace than before. */
    look(data) {
      if (this.data !== data) { this.data = data; this.hits = []; this.done = 0; this.begin(data); }
      for (; this.done < data.length; this.done++) if (this.fulfilled(data, this.done)) this.hits.push(this.done);
      return this.hits;
    }

    begin(data) {
      this.mine = []; // by number of a place or transition: whether it is meant
      this.tokens = 0;
      if (this.condition.kind === "place") for (const [place, tokens] of data.view.initial || []) if (this.isMine(data.places, place)) this.tokens += tokens;
    }

    isMine(table, number) { return (this.mine[number] ??= named(table[number], this.condition.name)); }

    fulfilled(data, index) {
      const step = data.steps[index], { kind, name } = this.condition;
      if (kind === "event") return step.e === name;
      if (kind === "place") return this.comesTrue(data, step.c || []);
      if (kind !== "signal" && step.e === "fire" && this.isMine(data.transitions, step.t)) return true;
      if (kind === "fired") return false;
      return (step.m || []).some(([lane, letter, value]) => letter === "v" && data.lanes[lane].kind === "signal" && data.lanes[lane].id === name &&
        (kind === "name" || Boolean(value) === this.condition.value));
    }

    /** A comparison is fulfilled by the step that makes it true. */
    comesTrue(data, change) {
      const { operator, number } = this.condition, before = COMPARE[operator](this.tokens, number);
      let touched = false;
      for (let i = 0; i < change.length; i += 2) if (this.isMine(data.places, change[i])) { this.tokens += change[i + 1]; touched = true; }
      return touched && !before && COMPARE[operator](this.tokens, number);
    }
  };
})((globalThis.DinerosTrace ??= {}));
