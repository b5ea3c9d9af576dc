// What happens in one step: in the panel for the cursor, and in short next to the mouse.

import { counted } from "../../counting.js";
import { make } from "../../elements.js";
import { STATES, seconds } from "../data.js";
import { causeOf } from "./cause_detail.js";

/** @import { Child } from "../../types.js" */
/** @import { Data } from "../data.js" */
/** @import { App } from "../page.js" */
/** @import { LaneRow, Literal } from "../types.js" */
/** @typedef {{ place: string, inner: boolean, tokens: number, before: number, after: number }} Change */

const FIELDS = ["error", "handler", "policy", "attempt", "instance", "message", "source", "reason", "stage"];

/** How a step changes the marking. @type {(data: Data, step: number) => Change[]} */
function changes(data, step) {
  const coded = data.steps[step].c ?? [];
  const marking = data.marking(step);
  /** @type {Change[]} */
  const found = [];
  for (let i = 0; i < coded.length; i += 2) {
    const place = data.places[coded[i]];
    const tokens = coded[i + 1];
    const after = marking.get(coded[i]) ?? 0;
    found.push({ place, inner: !data.inModel(place), tokens, before: after - tokens, after });
  }
  return found.sort((a, b) => Number(a.inner) - Number(b.inner) || a.tokens - b.tokens);
}

/** @type {(value: number) => string} */
const signed = (value) => (value > 0 ? `+${value}` : `−${-value}`);
/** @type {(time: number) => string} */
const clock = (time) =>
  new Date(time * 1000).toLocaleTimeString([], { hour12: false }) + (time % 1).toFixed(3).slice(1);
/** When a step of a schedule can happen. @type {(data: Data, window: [number, number | null]) => string} */
const windowText = (data, [earliest, latest]) => {
  if (latest === earliest) return `at ${data.duration(earliest)} only`;
  return `from ${data.duration(earliest)} to ${latest === null ? "any time later" : data.duration(latest)}`;
};
/** @type {(literal: Literal) => string} */
const named = ({ negated, signal, wanted }) =>
  wanted === undefined ? `${negated ? "¬" : ""}${signal}` : `${signal} ${negated ? "≠" : "="} ${wanted}`;

/** @type {(literal: Literal, off: boolean) => HTMLElement} */
function literalOf(literal, off) {
  if (off) return make("span", { class: "literal" }, named(literal));
  const { value, holds, since, deciding } = literal;
  let state = "value unknown";
  if (value !== null) state = `${literal.signal} is ${value}`;
  if (since >= 0) state += ` since step ${since + 1}`;
  else if (value !== null) state += " from the start";
  const [kind, mark] = holds ? ["holds", "✓"] : holds === false ? ["fails", "✗"] : ["", "?"];
  const attributes = { class: `literal ${kind}${deciding ? " deciding" : ""}`, title: state };
  return make("span", attributes, `${mark}${named(literal)}`);
}

/** @type {(data: Data, step: number) => HTMLElement | null} */
function clauseOf(data, step) {
  const clause = data.clause(step);
  if (!clause) return null;
  /** @type {Child[]} */
  const parts = [];
  clause.disjunctions.forEach((literals, i) => {
    if (i) parts.push(make("span", { class: "and" }, " ∧ "));
    if (literals.length > 1) parts.push("(");
    literals.forEach((literal, j) => {
      if (j) parts.push(" ∨ ");
      parts.push(literalOf(literal, clause.off));
    });
    if (literals.length > 1) parts.push(")");
  });
  const deciding = decidingOf(data, step);
  const since = deciding && (deciding.since >= 0 ? `, since step ${deciding.since + 1}` : ", from the start");
  return make(
    "div",
    { class: "clause" },
    make("h3", {}, "Clause"),
    make("p", { title: clause.text }, ...parts),
    clause.off && make("p", { class: "why" }, "signals are off in this trace: every clause counts as true"),
    deciding && make("p", { class: "why" }, "decided by ", make("b", {}, named(deciding)), since),
  );
}

/** The literal that decides a step's clause. @type {(data: Data, step: number) => Literal | undefined} */
const decidingOf = (data, step) =>
  data
    .clause(step)
    ?.disjunctions.flat()
    .find(({ deciding }) => deciding);

/** What else a step's record says. @type {(data: Data, step: number) => HTMLElement | null} */
function fields(data, step) {
  const details = data.steps[step].d ?? {};
  /** @type {HTMLElement[]} */
  const rows = [];
  /** @type {(name: string, value: Child) => void} */
  const add = (name, value) => {
    rows.push(make("dt", {}, name), make("dd", {}, value));
  };
  /** @type {(name: string, content: unknown) => void} */
  const addToken = (name, content) =>
    add(name, make("code", {}, JSON.stringify(content, null, 1).replace(/\n\s*/g, " ")));
  if (details.handlers) add("handlers", details.handlers.join(", "));
  if (details.duration !== undefined) add("took", seconds(details.duration));
  if (details.window) add("possible", windowText(data, details.window));
  for (const name of FIELDS) if (details[name] !== undefined) add(name, String(details[name]));
  if (details.taken) {
    const taken = Object.entries(details.taken);
    add("taken", taken.map(([place, ids]) => `${place}: ${ids.map((id) => `#${id}`).join(" ")}`).join("; "));
  }
  for (const [place, made] of Object.entries(details.made ?? {}))
    for (const [id, content] of made) addToken(`${place} #${id}`, content);
  if (details.data) addToken(details.token !== undefined ? `token #${details.token}` : "token", details.data);
  return rows.length ? make("dl", {}, ...rows) : null;
}

/** The panel of one trace at a step. @type {(app: App, number: number, step: number) => HTMLElement} */
export function detailOf(app, number, step) {
  const data = app.traces[number];
  const side = app.traces.length > 1 ? `${"AB"[number]}: ` : "";
  if (!data.length) return make("div", {}, make("h2", {}, `${side}no step yet`));
  if (step < 0) return make("div", {}, make("h2", {}, `${side}before the first step`), causeOf(data, step));
  if (step >= data.length)
    return make("div", {}, make("h2", {}, `${side}has ended after ${counted(data.length, "step")}`));
  const { e: event, w: time } = data.steps[step];
  const transition = data.transition(step);
  const where = [event, data.node(step) ?? "inside a channel"];
  if (time !== undefined && data.scheduled) where.push(`at ${data.duration(time)}`);
  else if (time !== undefined) where.push(`${clock(time)} (+${seconds(data.times[step])})`);
  if (data.loop !== null) where.push(step >= data.loop ? "in the loop ↻" : "in the stem");
  const lines = changes(data, step).map((row) =>
    make(
      "tr",
      { class: `${row.tokens < 0 ? "lost" : "gained"}${row.inner ? " inner" : ""}` },
      make("td", {}, signed(row.tokens)),
      make("td", {}, row.place),
      make("td", {}, `${row.before} → ${row.after}`),
    ),
  );
  return make(
    "div",
    { class: event === "drop" || event === "error" ? "alarm" : "" },
    make("h2", {}, `${side}step ${step + 1} of ${data.length}`),
    make("p", { class: "text" }, data.text(step)),
    make("p", { class: "where" }, where.join(" · ")),
    transition && transition !== data.text(step) && make("p", { class: "where" }, `transition ${transition}`),
    clauseOf(data, step),
    causeOf(data, step),
    lines.length > 0 && make("table", {}, make("tbody", {}, ...lines)),
    fields(data, step),
  );
}

/**
 * The text next to the mouse.
 *
 * @type {(tip: HTMLElement, app: App, step: number, row: LaneRow | undefined) => void}
 */
export function fillTip(tip, app, step, row) {
  const data = app.traces[row?.trace ?? 0];
  if (step >= data.length) {
    tip.replaceChildren("this trace has ended");
    return;
  }
  const time = data.timed ? ` · +${data.duration(data.times[step])}` : "";
  const lines = [
    make("b", {}, `${step + 1}  ${data.text(step)}`),
    make("div", {}, `${data.node(step) ?? "inside a channel"}${time}`),
  ];
  const table = changes(data, step);
  const outer = table.filter((one) => !one.inner || table.length < 5);
  if (table.length)
    lines.push(make("div", {}, outer.map((one) => `${signed(one.tokens)} ${one.place}`).join(", ")));
  const deciding = decidingOf(data, step);
  if (deciding) lines.push(make("div", {}, `decided by ${named(deciding)}`));
  if (row && row.lane.kind !== "transition" && row.lane.kind !== "client") {
    const { label, note, capacity } = row.lane;
    const most = capacity ? ` of ${capacity}` : "";
    const level = data.level(row.lane, step);
    const names = row.lane.kind === "state" ? STATES : row.lane.values;
    const said = names ? names[level] : `${level}${most}`;
    lines.push(make("div", { class: "level" }, `${label}${note && ` ${note}`}: ${said}`));
  }
  tip.replaceChildren(...lines);
}
