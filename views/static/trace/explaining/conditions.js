// What a breakpoint waits for: its text, and the steps of a trace that fulfil it.

import { prototypeOf } from "../data.js";

/** @import { Data } from "../data.js" */
/** @import { Step } from "../types.js" */
/** @typedef {{ kind: "event" | "fired" | "name", name: string, text: string }} Happening */
/** @typedef {{ kind: "signal", name: string, value: boolean, text: string }} Becoming */
/** @typedef {{ kind: "place", name: string, operator: string, number: number, text: string }} Comparison */
/** @typedef {Happening | Becoming | Comparison} Condition */

/** @type {Record<string, (a: number, b: number) => boolean>} */
const COMPARE = {
  ">=": (a, b) => a >= b,
  "<=": (a, b) => a <= b,
  ">": (a, b) => a > b,
  "<": (a, b) => a < b,
  "==": (a, b) => a === b,
  "!=": (a, b) => a !== b,
};
const COMPARISON = /^(.+?)\s*(>=|<=|==|!=|=|>|<)\s*(\d+)$/;
const VALUE = /^(.+?)\s*==?\s*(true|false)$/;
const CALL = /^(!?)\s*(fired|signal)\s*\(\s*(.+?)\s*\)$/;

/** @type {(name: string) => string} */
const bare = (name) => name.trim().replace(/^"(.*)"$/, "$1");

/**
 * A condition from its text: `Place >= 3`, `fired(T)`, `signal(S)`, `!signal(S)`, a kind of record such as
 * `drop`, or the name of a transition (it fires) or a signal (it changes). Null where the text is none.
 *
 * @type {(text: string, events: string[]) => Condition | null}
 */
export function parseCondition(text, events) {
  const said = text.trim();
  const call = CALL.exec(said);
  if (call) {
    const name = bare(call[3]);
    if (call[2] === "signal")
      return { kind: "signal", name, value: !call[1], text: `${call[1]}signal(${name})` };
    return call[1] ? null : { kind: "fired", name, text: `fired(${name})` };
  }
  const becomes = VALUE.exec(said);
  if (becomes) {
    const value = becomes[2] === "true";
    const name = bare(becomes[1]);
    return { kind: "signal", name, value, text: `${value ? "" : "!"}signal(${name})` };
  }
  const compares = COMPARISON.exec(said);
  if (compares) {
    const operator = compares[2] === "=" ? "==" : compares[2];
    const name = bare(compares[1]);
    const text = `${name} ${operator} ${compares[3]}`;
    return { kind: "place", name, operator, number: Number(compares[3]), text };
  }
  if (!said || /[()<>=!]/.test(said)) return null;
  const event = events.find((one) => one.toLowerCase() === said.toLowerCase());
  if (event) return { kind: "event", name: event, text: event };
  return { kind: "name", name: bare(said), text: bare(said) };
}

/**
 * What conditions call a signal, or, if it has values, each of them: `Mode.idle`.
 *
 * @type {(lane: { id: string, values?: string[] }) => string[]}
 */
const settingsOf = ({ id, values }) => values?.map((value) => `${id}.${value}`) ?? [id];

/**
 * Names that a trace knows, by kind; those of server instances also by the name in the model.
 *
 * @type {(data: Data) => Record<"transitions" | "places" | "signals", string[]>}
 */
export function namesOf(data) {
  /** @type {(names: string[]) => string[]} */
  const both = (names) => [...new Set(names.flatMap((name) => [name, prototypeOf(name)]))];
  return {
    transitions: both([...data.view.known, ...data.transitions]),
    places: both([...data.view.modelPlaces, ...data.places]),
    signals: data.lanes.filter((lane) => lane.kind === "signal").flatMap(settingsOf),
  };
}

/**
 * Why a condition can never be fulfilled as far as a trace is known; null where it can.
 *
 * @type {(data: Data, condition: Condition) => string | null}
 */
export function unknownIn(data, { kind, name }) {
  const { transitions, places, signals } = namesOf(data);
  if (kind === "event") return null;
  if (kind === "place") return places.includes(name) ? null : `no place is named ${name}`;
  if (kind === "signal") return signals.includes(name) ? null : `no signal is named ${name}`;
  if (kind === "fired") return transitions.includes(name) ? null : `no transition is named ${name}`;
  if (transitions.includes(name) || signals.includes(name) || data.signal(name)) return null;
  return places.includes(name)
    ? `${name} is a place: say how many tokens, such as ${name} >= 1`
    : `no transition, signal or kind of record is named ${name}`;
}

/** Steps that fulfil a condition; it grows with the trace. */
export class Watch {
  /** @type {Data | null} */
  data = null;
  /** @type {number[]} */
  hits = [];
  /** How many steps have been looked at. */
  done = 0;
  /** By number of a place or transition: whether it is meant. @type {boolean[]} */
  mine = [];
  tokens = 0;

  /** @param {Condition} condition */
  constructor(condition) {
    this.condition = condition;
  }

  /**
   * Looks at the steps that are new; all of them where it is another trace than before.
   *
   * @type {(data: Data) => number[]}
   */
  look(data) {
    if (this.data !== data) this.begin(data);
    for (; this.done < data.length; this.done++)
      if (this.fulfilled(data, data.steps[this.done])) this.hits.push(this.done);
    return this.hits;
  }

  /** @param {Data} data */
  begin(data) {
    this.data = data;
    this.hits = [];
    this.done = 0;
    this.mine = [];
    this.tokens = 0;
    if (this.condition.kind !== "place") return;
    for (const [place, tokens] of data.view.initial ?? [])
      if (this.isMine(data.places, place)) this.tokens += tokens;
  }

  /** @type {(names: string[], number: number) => boolean} */
  isMine(names, number) {
    const { name } = this.condition;
    this.mine[number] ??= names[number] === name || prototypeOf(names[number]) === name;
    return this.mine[number];
  }

  /** @type {(data: Data, step: Step) => boolean} */
  fulfilled(data, step) {
    const { condition } = this;
    const { kind, name } = condition;
    if (kind === "event") return step.e === name;
    if (kind === "place") return this.comesTrue(data, step.c ?? [], condition);
    if (
      kind !== "signal" &&
      step.e === "fire" &&
      step.t !== undefined &&
      this.isMine(data.transitions, step.t)
    )
      return true;
    if (kind === "fired") return false;
    return (step.m ?? []).some(([number, letter, value]) => {
      const lane = data.lanes[number];
      if (letter !== "v" || lane.kind !== "signal") return false;
      if (lane.id === name && (condition.kind !== "signal" || !lane.values))
        return condition.kind !== "signal" || Boolean(value) === condition.value;
      if (!lane.values || !settingsOf(lane).includes(name)) return false;
      return (
        (name === `${lane.id}.${lane.values[value]}`) === (condition.kind !== "signal" || condition.value)
      );
    });
  }

  /**
   * A comparison is fulfilled by the step that makes it true.
   *
   * @type {(data: Data, change: number[], comparison: Comparison) => boolean}
   */
  comesTrue(data, change, { operator, number }) {
    const before = COMPARE[operator](this.tokens, number);
    let touched = false;
    for (let i = 0; i < change.length; i += 2) {
      if (!this.isMine(data.places, change[i])) continue;
      this.tokens += change[i + 1];
      touched = true;
    }
    return touched && !before && COMPARE[operator](this.tokens, number);
  }
}
