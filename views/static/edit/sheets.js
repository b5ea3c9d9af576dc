// What a sheet shows: shapes of what stands on it, and lines for what leads from one of them to another.

import { inShort } from "./drawing.js";

/** @import { Model } from "./model.js" */
/** @import { Drawn, Line, Point, Port } from "./types.js" */

/** @type {Record<string, { width: number, height: number }>} */
const SIZES = {
  place: { width: 28, height: 28 },
  "place-reference": { width: 28, height: 28 },
  transition: { width: 12, height: 36 },
  "transition-reference": { width: 12, height: 36 },
};

/**
 * The shapes and lines of a sheet.
 *
 * @param {Model} model
 * @param {string} sheet handle of a page, or of the model
 * @param {Map<string, Point>} computed where to put what no editor has put anywhere
 * @returns {{ shapes: Drawn[], lines: Drawn[] }}
 */
export function contentOf(model, sheet, computed) {
  const shapes = standingOn(model, sheet).map((element) => shape(model, element, computed));
  const here = new Set(shapes.map((each) => each.element));
  /** @type {Map<string, string | null>} */
  const known = new Map();
  /** What of this sheet an element is, or is in. @type {(element: string | null) => string | null} */
  const standIn = (element) => {
    if (element === null || here.has(element)) return element;
    const before = known.get(element);
    if (before !== undefined) return before;
    const found = standIn(model.get(element).in ?? null);
    known.set(element, found);
    return found;
  };
  /** @type {Map<string, Drawn>} */
  const lines = new Map();
  for (const { element, line, source, target } of linesOf(model)) {
    const [from, to] = [standIn(source), standIn(target)];
    if (from === null || to === null || from === to) continue;
    const isOwn = from === source && to === target;
    const kind = line.kind === "arc" ? String(model.value(element, "kind")) : line.kind;
    // Lines into closed pages stand for all that go the same way.
    const id = isOwn ? `${element}-${line.from}-${line.to}` : `${from}>${to}>${kind}`;
    const known = lines.get(id);
    const port = portOf(model, element);
    if (known === undefined) {
      const ports = port === null ? [] : [port];
      lines.set(id, lineOf(model, { id, element, kind, from, to, isOwn, ports }));
    } else if (port !== null) known.ports.push(port);
  }
  return { shapes, lines: [...lines.values()] };
}

/** What leads from one object to another. @typedef {{ element: string, line: Line, source: string | null, target: string | null }} Leading */

/** Of every model, for the revision that was drawn last. @type {WeakMap<Model, { of: string, lines: Leading[], ports: Map<string, string[]> }>} */
const drawnLast = new WeakMap();

/** @type {(model: Model) => { of: string, lines: Leading[], ports: Map<string, string[]> }} */
function known(model) {
  const of = `${model.epoch} ${model.revision}`;
  const before = drawnLast.get(model);
  if (before?.of === of) return before;
  /** @type {Leading[]} */
  const lines = [];
  for (const [element, object] of model.objects) {
    for (const line of model.classOf(object.type).lines ?? []) {
      const [source, target] = [line.from, line.to].map((end) =>
        end === "self" ? element : end === "in" ? (object.in ?? null) : model.link(element, end),
      );
      lines.push({ element, line, source, target });
    }
  }
  const now = { of, lines, ports: portsOf(model, lines) };
  drawnLast.set(model, now);
  return now;
}

/** @type {(model: Model) => Leading[]} */
const linesOf = (model) => known(model).lines;

/** @type {(model: Model, sheet: string) => string[]} */
function standingOn(model, sheet) {
  const parts = model
    .kind(sheet)
    .features.filter((feature) => feature.kind === "part")
    .flatMap((feature) => model.links(sheet, feature.name))
    .filter(
      (part) => model.kind(part).shape !== undefined && (model.link(part, "canvas") ?? sheet) === sheet,
    );
  const drawnHere = model
    .links(model.root, "channels")
    .filter((each) => model.link(each, "canvas") === sheet);
  return [...parts, ...drawnHere.filter((each) => !parts.includes(each))];
}

/** Points of an element's graphics. @type {(model: Model, element: string) => Point[]} */
export function pointsOf(model, element) {
  const graphics = model.link(element, "graphics");
  if (graphics === null) return [];
  return model
    .links(graphics, "positions")
    .map((point) => ({ x: Number(model.value(point, "x")), y: Number(model.value(point, "y")) }));
}

/** @type {(model: Model, element: string, computed: Map<string, Point>) => Drawn} */
function shape(model, element, computed) {
  const kind = model.kind(element).shape ?? "page";
  const title = model.label(element);
  const lines = notes(model, element, kind);
  const widest = Math.max(7.5 * title.length, ...lines.map((text) => 5.2 * text.length));
  const size = SIZES[kind] ?? {
    width: Math.round(Math.min(260, Math.max(80, widest + 28))),
    height: 14 + 12 * (1 + lines.length),
  };
  return {
    ...EMPTY,
    id: element,
    element,
    kind,
    title,
    lines,
    tokens: kind === "place" ? model.tokens(element) : 0,
    at: pointsOf(model, element)[0] ?? computed.get(element) ?? null,
    size,
  };
}

/** What stands below a name. @type {(model: Model, element: string, kind: string) => string[]} */
function notes(model, element, kind) {
  if (kind === "transition") {
    const clause = model.links(element, "clause")[0];
    return clause === undefined ? [] : [String(model.value(clause, "text") ?? "")];
  }
  if (kind === "place") return portsAt(model, element);
  const words = model.kind(element).words;
  if (kind === "topic" || kind === "service" || kind === "action") {
    const name = model.value(element, kind);
    return [name === model.label(element) ? kind : `${kind} ${name}`, ...waiting(model, element)];
  }
  if (kind.endsWith("-reference")) return [];
  const count = model.links(element, "objects").length;
  return [words, `${count} inside`];
}

/** What is in a channel in the game that is played. @type {(model: Model, channel: string) => string[]} */
function waiting({ played }, channel) {
  const queues = (played?.queues[channel] ?? []).filter(({ load }) => load > 0);
  const others = (played?.under[channel] ?? []).reduce((sum, { tokens }) => sum + tokens, 0);
  return [
    ...queues.map(({ text, load, room }) => `${text}: ${load} of ${load + room}`),
    ...(others > 0 ? [`${others} under way`] : []),
  ];
}

/** Which channels a place gives to or takes from, that are not on its sheet. @type {(model: Model, place: string) => string[]} */
const portsAt = (model, place) => known(model).ports.get(place) ?? [];

/** What ports say at the places that are on other sheets than their channels. @type {(model: Model, lines: Leading[]) => Map<string, string[]>} */
function portsOf(model, lines) {
  /** @type {Map<string, string[]>} */
  const found = new Map();
  for (const { element, line, source, target } of lines) {
    const channel = model.get(element).in;
    if ((line.from !== "in" && line.to !== "in") || channel === undefined) continue;
    const place = line.to === "in" ? source : target;
    if (place === null || model.sheetOf(channel) === model.get(place).in) continue;
    const port = portOf(model, element);
    const said = `${line.to === "in" ? "→" : "←"} ${model.label(channel)}${port === null ? "" : ` ${inShort(port)}`}`;
    found.set(place, [...(found.get(place) ?? []), said]);
  }
  return found;
}

/** The limit of a port and what is promised of its messages; null for what has neither. @type {(model: Model, element: string) => Port | null} */
function portOf(model, element) {
  if (model.feature(element, "limit") === undefined) return null;
  const channel = model.get(element).in;
  const own = model.links(element, "qos")[0];
  const common = channel === undefined ? undefined : model.links(channel, "qos")[0];
  const quality = own ?? common;
  const is = (/** @type {string} */ name, /** @type {string} */ value) =>
    quality !== undefined && model.value(quality, name) === value;
  const times = ["deadline", "lifespan"].filter(
    (name) => quality !== undefined && model.value(quality, name) !== null,
  );
  return {
    limit: Number(model.value(element, "limit")),
    isBestEffort: is("reliability", "bestEffort"),
    isKept: is("durability", "transientLocal"),
    times: times.map((name) => `${name} ${model.value(/** @type {string} */ (quality), name)} s`),
  };
}

/** @type {(model: Model, line: Pick<Drawn, "id" | "element" | "kind" | "from" | "to" | "isOwn" | "ports">) => Drawn} */
function lineOf(model, line) {
  const isArc = model.isA(model.get(line.element).type, "pn.Arc");
  return {
    ...EMPTY,
    ...line,
    title: model.label(line.element),
    weight: isArc ? Number(model.value(line.element, "weight")) : 1,
    bends: isArc && line.isOwn ? pointsOf(model, line.element) : [],
  };
}

/** @type {Drawn} */
const EMPTY = {
  id: "",
  element: "",
  kind: "",
  title: "",
  lines: [],
  tokens: 0,
  weight: 1,
  at: null,
  size: { width: 0, height: 0 },
  from: "",
  to: "",
  bends: [],
  isOwn: true,
  ports: [],
};
