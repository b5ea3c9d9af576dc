// A trace in memory: its steps, what happened on each lane, and the marking after any step.

/** @import { Call, FilledLane, Growth, Lane, Literal, Mark, Step, View } from "./types.js" */
/** @typedef {Map<number, number>} Marking  tokens by number of the place */

/** States of managed nodes, as marks number them. */
/** What a signal is at a level of its lane. @type {(lane: { values?: string[] }, level: number) => boolean | string} */
export const settingOf = (lane, level) => (lane.values ? lane.values[level] : Boolean(level));

export const STATES = ["unconfigured", "inactive", "active", "finalized"];

const EVERY = 256; // steps between two kept markings

/**
 * Index of the last element <= value in a sorted array, or -1.
 *
 * @type {(sorted: ArrayLike<number>, value: number) => number}
 */
export function lastAtMost(sorted, value) {
  let low = 0;
  let high = sorted.length;
  while (low < high) {
    const middle = (low + high) >> 1;
    if (sorted[middle] <= value) low = middle + 1;
    else high = middle;
  }
  return low - 1;
}

/** Windows are drawn up to this multiple of the last time, so that the steps stay apart. */
const FURTHEST = 1.5;

export class Data {
  /** @type {Step[]} */
  steps = [];
  /** Seconds from the first step, or from the start of a schedule; never falling. @type {number[]} */
  times = [];
  /** @type {number | null} */
  start = null;
  /** Whether it is a schedule: its steps have windows, and its times count from the start. */
  scheduled = false;
  /** The last of the latest times of a schedule. */
  latest = 0;
  /** @type {FilledLane[]} */
  lanes = [];
  /** Numbers of transitions that fire. @type {Set<number | undefined>} */
  fired = new Set();
  /** Steps with a lost message or an error. @type {number[]} */
  alarms = [];

  /** @param {View} view */
  constructor(view) {
    this.view = view;
    this.nodes = view.nodes;
    this.places = view.places;
    this.transitions = view.transitions;
    this.texts = view.texts;
    this.loop = view.loop;
    this.cause = view.cause;
    this.causal = new Set(view.cause?.steps);
    this.own = new Set(view.modelPlaces);
    /** @type {Marking} */
    this.last = new Map(view.initial);
    this.kept = [new Map(this.last)];
    for (const lane of view.lanes) this.addLane(lane);
    for (const step of view.steps) this.addStep(step);
  }

  get length() {
    return this.steps.length;
  }

  get timed() {
    return this.start !== null;
  }

  /**
   * A duration in words. Schedules of plain nets have the unit of the net, whatever that is.
   *
   * @type {(value: number, whole?: number) => string}
   */
  duration(value, whole = value) {
    return this.scheduled && !this.nodes.length ? `${+value.toFixed(9)}` : seconds(value, whole);
  }

  /** What the times are. */
  get axisOfTime() {
    return this.scheduled ? "time of the schedule" : "wall-clock time";
  }

  /** The last time at which a step of a schedule happens, or can happen if there is a latest one. */
  get horizon() {
    const last = this.length ? this.times[this.length - 1] : 0;
    return Math.max(last, Math.min(this.latest, last * FURTHEST));
  }

  /** @param {Lane} lane */
  addLane(lane) {
    this.lanes.push({ ...lane, index: this.lanes.length, at: [], marks: [], calls: [], levels: [] });
  }

  /** @param {Step} step */
  addStep(step) {
    const index = this.steps.length;
    this.steps.push(step);
    const before = index ? this.times[index - 1] : 0;
    if (step.d?.window) {
      this.scheduled = true;
      this.latest = Math.max(this.latest, step.d.window[1] ?? 0);
    }
    if (step.w !== undefined) {
      this.start ??= step.d?.window ? 0 : step.w;
      this.times.push(Math.max(step.w - this.start, before));
    } else this.times.push(before);
    if (step.e === "fire") this.fired.add(step.t);
    if (step.e === "drop" || step.e === "error") this.alarms.push(index);
    for (const [lane, ...mark] of step.m ?? []) addMark(this.lanes[lane], index, mark);
    this.change(this.last, index);
    if (index % EVERY === EVERY - 1) this.kept.push(new Map(this.last));
  }

  /** @param {Growth} growth */
  append(growth) {
    this.nodes.push(...(growth.nodes ?? []));
    this.places.push(...(growth.places ?? []));
    this.transitions.push(...(growth.transitions ?? []));
    this.texts.push(...(growth.texts ?? []));
    for (const lane of growth.lanes ?? []) this.addLane(lane);
    for (const step of growth.steps) this.addStep(step);
  }

  /** The trace as it is now. @type {() => View} */
  snapshot() {
    const { nodes, places, transitions, texts, steps } = this;
    const lanes = this.lanes.map(
      ({ index: _, at: _at, marks: _marks, calls: _calls, levels: _levels, ...lane }) => lane,
    );
    return { ...this.view, nodes, places, transitions, texts, steps, lanes };
  }

  /**
   * @param {Marking} marking
   * @param {number} index
   */
  change(marking, index) {
    const change = this.steps[index].c ?? [];
    for (let i = 0; i < change.length; i += 2)
      marking.set(change[i], (marking.get(change[i]) ?? 0) + change[i + 1]);
  }

  /** The marking after a step; -1 is before the first. @type {(step: number) => Marking} */
  marking(step) {
    const kept = Math.min(Math.floor((step + 1) / EVERY), this.kept.length - 1);
    const marking = new Map(this.kept[kept]);
    for (let i = kept * EVERY; i <= step; i++) this.change(marking, i);
    return marking;
  }

  /** Value or level of a lane after a step. @type {(lane: FilledLane, step: number) => number} */
  level(lane, step) {
    const found = lastAtMost(lane.at, step);
    return found < 0 ? lane.initial : lane.marks[found][1];
  }

  /**
   * Whether a place is in the model itself; the others the rules made.
   *
   * @type {(place: string) => boolean}
   */
  inModel(place) {
    return !this.own.size || this.own.has(place) || this.own.has(prototypeOf(place));
  }

  /** @param {string} name */
  signal(name) {
    return this.lanes.find((lane) => lane.kind === "signal" && lane.id === name);
  }

  /** @param {number} step */
  text(step) {
    return this.texts[this.steps[step].x];
  }

  /** The node that does a step. @type {(step: number) => string | null} */
  node(step) {
    const { n } = this.steps[step];
    return n === undefined ? null : this.nodes[n];
  }

  /** The transition that a step is about. @type {(step: number) => string | null} */
  transition(step) {
    const { t } = this.steps[step];
    return t === undefined ? null : this.transitions[t];
  }

  /** Transitions of the model that never fire. */
  silent() {
    const fired = new Set([...this.fired].map((index) => index !== undefined && this.transitions[index]));
    return this.view.known.filter((name) => !fired.has(name));
  }

  /**
   * The clause of a step's transition: each literal with its value before the step, and the deciding ones.
   *
   * @param {number} step
   */
  clause(step) {
    const name = this.transition(step);
    if (!name || (this.steps[step].e !== "fire" && this.steps[step].e !== "error")) return null;
    const clause = this.view.clauses[name] ?? this.view.clauses[prototypeOf(name)];
    if (!clause) return null;
    const disjunctions = clause.cnf.map((literals) =>
      literals.map((literal) => this.literal(literal, step - 1)),
    );
    // A disjunction holds since its first literal that still holds; the clause since its last disjunction
    // does.
    /** @type {Literal | null} */
    let latest = null;
    for (const literals of disjunctions) {
      const holding = literals.filter((literal) => literal.holds);
      if (!holding.length) continue;
      const first = holding.reduce((a, b) => (a.since <= b.since ? a : b));
      if (latest === null || first.since > latest.since) latest = first;
    }
    if (latest) latest.deciding = true;
    return { text: clause.text, off: this.view.signalsOff, disjunctions };
  }

  /** @type {(literal: [signal: string, negated: boolean, wanted?: string], step: number) => Literal} */
  literal([signal, negated, wanted], step) {
    const lane = this.signal(signal);
    const said = { signal, negated, wanted, deciding: false };
    if (!lane) return { ...said, value: null, holds: null, since: -1 };
    const value = settingOf(lane, this.level(lane, step));
    const since = lane.at[lastAtMost(lane.at, step)] ?? -1;
    return { ...said, value, holds: (value === (wanted ?? true)) !== negated, since };
  }
}

/** @type {(lane: FilledLane, index: number, mark: Mark) => void} */
function addMark(lane, index, mark) {
  lane.at.push(index);
  lane.marks.push(mark);
  if (lane.kind !== "client") return;
  const [letter, number, more] = mark;
  lane.calls[number - 1] ??= newCall(lane, number, index);
  const call = lane.calls[number - 1];
  if (letter === "q") call.request = index;
  else if (letter === "s") {
    call.serve = index;
    call.instance = more;
  } else if (letter === "r") call.reply = index;
  else if (letter === "a") {
    call.response = index;
    call.end = more;
  } else if (letter === "c") call.cancels.push(index);
  else if (letter === "x") call.canceling = index;
  else if (letter === "b") call.feedback.push(index);
  else if (letter === "g") call.givenUp = index;
  else if (letter === "o") call.timeouts.push(index);
}

/** A call that begins: on the first level where none is under way. @type {(lane: FilledLane, number: number, first: number) => Call} */
function newCall(lane, number, first) {
  const free = lane.levels.findIndex((call) => call.response !== undefined || call.givenUp !== undefined);
  const level = free < 0 ? lane.levels.length : free;
  /** @type {Call} */
  const call = { number, first, timeouts: [], cancels: [], feedback: [], level };
  lane.levels[level] = call;
  return call;
}

/** Id in the system model of an element of a server instance. @type {(name: string) => string} */
export function prototypeOf(name) {
  const match = /^.+?\[\d+\]\.(.+)$/.exec(name);
  return match ? prototypeOf(match[1]) : name;
}

/** Identity of a lane over two traces. @type {(lane: Lane) => string} */
export const laneKey = (lane) => [lane.kind, lane.id, lane.channel, lane.queue].join("|");

/**
 * A duration in words; of a ruler, in the unit of its whole length.
 *
 * @type {(value: number, whole?: number) => string}
 */
export function seconds(value, whole = value) {
  const size = Math.abs(whole);
  /** @type {(part: number) => string} */
  const two = (part) => String(Math.floor(part)).padStart(2, "0");
  if (size >= 3600) return `${Math.floor(value / 3600)}:${two((value / 60) % 60)}:${two(value % 60)} h`;
  if (size >= 60) return `${Math.floor(value / 60)}:${two(value % 60)} min`;
  if (size >= 1 || size === 0) return `${+value.toFixed(3)} s`;
  return size >= 0.001 ? `${+(value * 1e3).toFixed(2)} ms` : `${+(value * 1e6).toFixed(0)} µs`;
}
