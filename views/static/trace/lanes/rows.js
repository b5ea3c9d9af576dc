// Which lanes are shown, in which order and where; shared by the page and by figures.

import { lookUpOrAdd } from "../../maps.js";
import { laneKey } from "../data.js";
import { HEIGHTS } from "./lanes.js";

/** @import { Data } from "../data.js" */
/** @import { Choice, FilledLane, Group, Lane, Row } from "../types.js" */
/** @typedef {Row extends infer R ? R extends Row ? Omit<R, "y" | "height"> : never : never} Unplaced */

/** @type {[Group, string][]} */
const GROUPS = [
  ["property", "Property"],
  ["lifecycle", "Managed nodes"],
  ["signals", "Signals"],
  ["topics", "Topics"],
  ["services", "Services"],
  ["actions", "Actions"],
  ["transitions", "Transitions"],
];

/** Whether nothing ever happens on a lane. @type {(lane: FilledLane) => boolean} */
const idle = (lane) => !lane.at.length && lane.kind !== "place" && lane.kind !== "state";

/**
 * A filter: words that must all occur; `a|b` is one or the other; `-word` must not.
 *
 * @type {(text: string) => (lane: Pick<Lane, "id" | "label"> & Partial<Lane>, heading: string) => boolean}
 */
function filterOf(text) {
  const words = text.trim().toLowerCase().split(/\s+/).filter(Boolean);
  return ({ id, label, note = "", node = "", channel = "" }, heading) => {
    const said = `${id} ${label} ${note} ${node} ${channel} ${heading}`.toLowerCase();
    return words.every((word) =>
      word.startsWith("-") && word.length > 1
        ? !said.includes(word.slice(1))
        : word.split("|").some((part) => part && said.includes(part)),
    );
  };
}

/**
 * The lanes of each group by their keys, by trace; the first trace says which group.
 *
 * @type {(traces: Data[]) => Map<Group, Map<string, (FilledLane | undefined)[]>>}
 */
function grouped(traces) {
  /** @type {Map<Group, Map<string, (FilledLane | undefined)[]>>} */
  const groups = new Map();
  /** @type {Map<string, Group>} */
  const groupOf = new Map();
  traces.forEach((data, number) => {
    for (const lane of data.lanes) {
      const key = laneKey(lane);
      const group = lookUpOrAdd(groupOf, key, () => lane.group);
      const lanes = lookUpOrAdd(groups, group, () => new Map());
      lookUpOrAdd(lanes, key, () => traces.map(() => undefined))[number] = lane;
    }
  });
  return groups;
}

/** @type {(lanes: (FilledLane | undefined)[]) => FilledLane} */
const first = (lanes) => lanes.flatMap((lane) => lane ?? [])[0];

/**
 * Rows from top to bottom, of one trace, or of two to compare.
 *
 * @type {(traces: Data[], choice?: Partial<Choice>) => { rows: Row[], height: number }}
 */
export function rowsOf(traces, choice = {}) {
  const matches = filterOf(choice.filter ?? "");
  /** @type {Row[]} */
  const rows = [];
  let y = 0;
  /** @type {(row: Unplaced, height: number) => void} */
  const push = (row, height) => {
    rows.push({ ...row, y, height });
    y += height;
  };
  const groups = grouped(traces);
  for (const [group, heading] of GROUPS) {
    const entries = [...(groups.get(group) ?? [])]
      .map(([key, lanes]) => ({ key, lanes, idle: lanes.every((lane) => !lane || idle(lane)) }))
      .filter(({ key, lanes }) => {
        const lane = first(lanes);
        return matches(lane, heading) && !choice.hidden?.has(key) && !choice.nodes?.has(lane.node ?? "");
      });
    if (group === "transitions") {
      const order = new Map(traces[0].nodes.map((node, index) => [node, index]));
      /** @type {(entry: { lanes: (FilledLane | undefined)[] }) => number} */
      const rank = ({ lanes }) => order.get(first(lanes).node ?? "") ?? Infinity;
      entries.sort((a, b) => rank(a) - rank(b) || 0);
    }
    const silent =
      group === "transitions"
        ? traces[0].silent().filter((name) => matches({ id: name, label: name }, heading))
        : [];
    if (!entries.length && !silent.length) continue;
    const closed = Boolean(choice.closed?.has(group));
    const open = Boolean(choice.open?.has(group));
    const quiet = entries.filter((entry) => entry.idle).length + silent.length;
    const count = entries.filter((entry) => !entry.idle).length;
    push({ type: "heading", group, label: heading, count, closed }, HEIGHTS.heading);
    if (closed) continue;
    for (const { key, lanes } of entries.filter((entry) => open || !entry.idle)) {
      lanes.forEach((own, trace) => {
        const lane = own ?? {
          ...first(lanes),
          at: [],
          marks: [],
          calls: [],
          levels: [],
          initial: 0,
          absent: true,
        };
        push({ type: "lane", group, key, lane, trace }, HEIGHTS[lane.kind]);
      });
    }
    if (quiet) push({ type: "silent", group, open, count: quiet }, HEIGHTS.transition);
    if (open) for (const name of silent) push({ type: "name", group, label: name }, HEIGHTS.transition);
  }
  return { rows, height: y };
}
