// What is known of traces here: `dineros.views.traces.coding` writes it. Steps refer to names by number.

import type { Picture } from "../net/types.js";
import type { Data } from "./data.js";
import type { Scale } from "./lanes/scale.js";

export type Point = [x: number, y: number];
export type Group = "property" | "lifecycle" | "signals" | "topics" | "services" | "actions" | "transitions";
export type LaneKind = "state" | "signal" | "queue" | "client" | "transition" | "place";

export interface Lane {
  group: Group;
  kind: LaneKind;
  id: string;
  label: string;
  note: string;
  node?: string;
  channel?: string;
  queue?: string;
  capacity?: number;
  initial: number;
  /** Of a signal with values: their names; its level is the position of one. */
  values?: string[];
}

/** What a step does to a lane; `dineros.views.traces.building` lists the letters. */
export type Mark = [letter: string, value: number, more: number];

/** More about a step, as it stands in its record. */
export interface Details {
  handlers?: string[];
  duration?: number;
  /** In a schedule: the earliest and the latest time at which the step can happen; null: any time later. */
  window?: [earliest: number, latest: number | null];
  taken?: Record<string, number[]>;
  made?: Record<string, [id: number, content: unknown][]>;
  data?: unknown;
  token?: number;
  [name: string]: unknown;
}

export interface Step {
  /** Kind of record. */
  e: string;
  /** Text. */
  x: number;
  /** Node. */
  n?: number;
  /** Transition. */
  t?: number;
  /** Places, each followed by the tokens it gains. */
  c?: number[];
  /** Marks behind the number of their lane. */
  m?: [lane: number, ...mark: Mark][];
  /** Time, in seconds. */
  w?: number;
  d?: Details;
}

/** Where the outcome may have begun, and which conditions were true since when and up to when. */
export interface Cause {
  first: number;
  steps: number[];
  decided: [condition: string, since: number, until: number][];
}

export interface Tables {
  nodes: string[];
  places: string[];
  transitions: string[];
  texts: string[];
}

export interface View extends Tables {
  title: string;
  kind: string;
  model: string;
  property: string | null;
  verdict: string | null;
  variant: string;
  /** Whether signals have no values in it: then all clauses count as true. */
  signalsOff: boolean;
  loop: number | null;
  cause: Cause | null;
  /** Places and their tokens before the first step. */
  initial: [place: number, tokens: number][] | null;
  clauses: Record<string, { text: string; cnf: [signal: string, negated: boolean, wanted?: string][][] }>;
  /** Transitions of the model. */
  known: string[];
  modelPlaces: string[];
  /** Kinds of records that a breakpoint can name. */
  events: string[];
  lanes: Lane[];
  steps: Step[];
}

/** What is new of a trace that grows. */
export interface Growth extends Partial<Tables> {
  lanes?: Lane[];
  steps: Step[];
}

/** Where two traces part. */
export interface Divergence {
  a: number;
  b: number;
}

/** What a page shows. */
export interface Content {
  view: View;
  other?: View;
  divergence?: Divergence | null;
  net?: Picture | null;
  live?: boolean;
}

// In memory.

/** A call of a client, or a goal: the steps in which things happened to it. */
export interface Call {
  number: number;
  first: number;
  timeouts: number[];
  request?: number;
  serve?: number;
  reply?: number;
  response?: number;
  givenUp?: number;
  instance?: number;
  /** Calls that overlap have different levels, from 0. */
  level: number;
  /** When the client asked to cancel the goal, and when the server received the request. */
  cancels: number[];
  canceling?: number;
  /** When the server gave feedback. */
  feedback: number[];
  /** How the goal ended: succeeded, aborted, canceled, rejected. */
  end?: number;
}

/** A lane with what happens on it: the step of each mark, and the mark, go side by side. */
export interface FilledLane extends Lane {
  index: number;
  at: number[];
  marks: Mark[];
  calls: Call[];
  /** Of each level, the last call. */
  levels: Call[];
  /** Only the other trace has it. */
  absent?: boolean;
}

export interface Literal {
  signal: string;
  negated: boolean;
  /** What the signal is compared with, if it has values. */
  wanted?: string;
  value: boolean | string | null;
  holds: boolean | null;
  since: number;
  deciding: boolean;
}

interface Placed {
  y: number;
  height: number;
  group: Group;
}
export interface HeadingRow extends Placed {
  type: "heading";
  label: string;
  count: number;
  closed: boolean;
}
export interface LaneRow extends Placed {
  type: "lane";
  key: string;
  lane: FilledLane;
  trace: number;
}
export interface SilentRow extends Placed {
  type: "silent";
  open: boolean;
  count: number;
}
export interface NameRow extends Placed {
  type: "name";
  label: string;
}
export type Row = HeadingRow | LaneRow | SilentRow | NameRow;

/** Which lanes are shown. */
export interface Choice {
  /** Words that they must have. */
  filter: string;
  /** Headings that are folded. */
  closed: Set<Group>;
  /** Groups whose idle lanes are shown. */
  open: Set<Group>;
  /** Node nets left out. */
  nodes: Set<string>;
  /** Keys of lanes left out. */
  hidden: Set<string>;
}

// Drawing.

export type ThemeName = "light" | "dark";

export interface Theme {
  back: string;
  panel: string;
  ink: string;
  soft: string;
  line: string;
  grid: string;
  topic: string;
  topicFill: string;
  service: string;
  serviceFill: string;
  signal: string;
  signalFill: string;
  handler: string;
  alarm: string;
  cursor: string;
  loop: string;
  loopInk: string;
  fold: string;
  cause: string;
  /** Of node nets. */
  nodes: string[];
}

export interface Stroke {
  fill?: string;
  stroke?: string;
  width?: number;
  dash?: number[];
  opacity?: number;
  closed?: boolean;
}

export interface Lettering {
  fill: string;
  size?: number;
  anchor?: "start" | "middle" | "end";
  bold?: boolean;
  opacity?: number;
}

/** What pictures are drawn on. */
export interface Surface {
  rect(x: number, y: number, width: number, height: number, stroke: Stroke): void;
  path(points: Point[], stroke: Stroke): void;
  text(x: number, y: number, text: string | number, lettering: Lettering): void;
  clip(x: number, y: number, width: number, height: number): void;
  unclip(): void;
  begin(kind: string, id: string, title: string): void;
  end(): void;
}

/** What is seen of a trace: `dx` is where it begins on the surface, `from` to `to` the steps that can be seen. */
export interface Seen {
  surface: Surface;
  data: Data;
  scale: Scale;
  theme: Theme;
  dx: number;
  left: number;
  width: number;
  from: number;
  to: number;
}
