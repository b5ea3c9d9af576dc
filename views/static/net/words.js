// Descriptions of elements of nets.

import { counted } from "../counting.js";

/** @import { Change, Edge, EdgeKind, Item, NodeKind, BoxKind } from "./types.js" */

/** @type {Record<NodeKind | BoxKind | EdgeKind, string>} */
export const WORDS = {
  place: "place",
  transition: "transition",
  "place-reference": "reference to a place",
  "transition-reference": "reference to a transition",
  topic: "topic",
  service: "service",
  normal: "arc",
  read: "read arc",
  inhibitor: "inhibitor arc",
  reference: "reference",
  publish: "publishes",
  subscribe: "receives",
  request: "request",
  response: "response",
  call: "calls the server",
  return: "server's answer",
  node: "ROS node",
  page: "page",
  timer: "timer callback",
  subscriber: "subscriber callback",
  server: "server callback",
  group: "group",
};

/** @type {Record<Change, string>} */
export const SIGNS = { added: "+", removed: "−", changed: "≠" };

/** The name of an element. @type {(item: Item | Edge) => string} */
export const heading = (item) =>
  ("title" in item && item.title) || ("label" in item && item.label) || item.id;

/**
 * What is known of an element, each with its heading.
 *
 * @type {(item: Item | Edge, labels: Map<string, string>) => [name: string, text: string][]}
 */
export function facts(item, labels) {
  /** @type {[string, string][]} */
  const found = [["Id", item.id]];
  if ("title" in item && item.summary) found.push(["Holds", item.summary]);
  if ("source" in item) {
    found.push(["From", labels.get(item.source) ?? ""], ["To", labels.get(item.target) ?? ""]);
    if (item.weight !== undefined) found.push(["Weight", String(item.weight)]);
    if (item.label) found.push(["Label", item.label]);
  } else if (item.tokens !== undefined) found.push(["Tokens", String(item.tokens)]);
  if ("title" in item)
    for (const signal of item.signals ?? [])
      found.push([`Signal ${signal.label}`, `starts ${signal.value ?? Boolean(signal.initial)}`]);
  found.push(...Object.entries(item.detail ?? {}));
  if (item.change) found.push(["Change", [item.change, ...(item.notes ?? [])].join("; ")]);
  return found;
}

/** What a screen reader says of a node or a box in addition to its texts. @type {(item: Item) => Record<string, string>} */
export const spoken = (item) => ({
  "aria-roledescription": WORDS[item.kind],
  "aria-description": [item.tokens ? counted(item.tokens, "token") : "", item.change ?? ""]
    .filter(Boolean)
    .join(", "),
});
