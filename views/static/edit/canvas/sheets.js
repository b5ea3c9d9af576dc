// What a sheet shows: shapes of what is on it, and lines for what leads from one of them to another.

import { timesOf } from "../times.js";
import { inShort } from "./drawing.js";
import { extentOf, frameOf, middleOf, openingOf, Plane } from "./opening.js";

/** @import { Model } from "../model.js" */
/** @import { Opened } from "./opening.js" */
/** @import { Drawn, Extent, Line, Opening, Point, Port } from "../types.js" */

/** @type {Record<string, { width: number, height: number }>} */
const SIZES = {
  place: { width: 28, height: 28 },
  "place-reference": { width: 28, height: 28 },
  transition: { width: 12, height: 36 },
  "transition-reference": { width: 12, height: 36 },
};

/**
 * The shapes and lines of a sheet, those of the pages that are open on it included.
 *
 * @param {Model} model
 * @param {string} sheet handle of a page, or of the model
 * @param {Opened} opened
 * @param {Map<string, Map<string, Point>>} computed where to put what no editor has put anywhere, by page
 * @returns {{ shapes: Drawn[], lines: Drawn[], planes: Map<string, Plane> }}
 */
export function contentOf(model, sheet, opened, computed) {
  const pages = openOn(model, sheet, opened);
  /** @type {Map<string, Plane>} */
  const planes = new Map();
  const shapes = placed(arranged({ model, pages, opened, computed }, sheet), { x: 0, y: 0 }, 0, planes);
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
      lines.set(id, lineOf(model, { id, element, kind, from, to, isOwn, ports }, planes));
    } else if (port !== null) known.ports.push(port);
  }
  return { shapes, lines: [...lines.values()], planes };
}

/** The sheet, and the pages that are open on it. @type {(model: Model, sheet: string, opened: Opened) => Set<string>} */
function openOn(model, sheet, opened) {
  const found = new Set([sheet]);
  for (const page of found) {
    for (const each of standingOn(model, page)) if (opened.has(each)) found.add(each);
  }
  return found;
}

/** What is on a page, where its own plane has it, and the same of pages that are open there. @typedef {{ page: string, items: Drawn[], openings: Opening[], inner: Map<string, Arranged & { middle: Point, extent: Extent }> }} Arranged */

/** @type {(of: { model: Model, pages: Set<string>, opened: Opened, computed: Map<string, Map<string, Point>> }, page: string) => Arranged} */
function arranged(of, page) {
  const { model, pages, opened, computed } = of;
  const items = standingOn(model, page).map((element) => shape(model, element, page, pages));
  let spare = 0;
  for (const item of items) {
    const stored = pointsOf(model, item.element)[0] ?? computed.get(page)?.get(item.element);
    item.stored = stored ?? { x: 60 + 90 * (spare % 8), y: 40 + 80 * Math.floor(spare++ / 8) };
  }
  /** @type {Arranged["inner"]} */
  const inner = new Map();
  const openings = items
    .filter(({ isOpen }) => isOpen)
    .map((item) => {
      const contents = arranged(of, item.element);
      const frame = frameOf(model, item.element, contents.items);
      const kept = opened.pages.get(item.element) ?? frame?.centre ?? middleOf(contents.items);
      opened.pages.set(item.element, kept);
      const middle = new Plane(contents.openings, { x: 0, y: 0 }).to(kept);
      const extent = extentOf(item, roomsOf(contents), middle, frame?.size ?? null);
      inner.set(item.element, { ...contents, middle, extent });
      return openingOf(item.element, item.stored, item.size, extent);
    });
  const plane = new Plane(openings, { x: 0, y: 0 });
  for (const item of items) item.at = plane.to(item.stored);
  return { page, items, openings, inner };
}

/** What takes room on a page: open pages as wide as their frames. @type {(of: Arranged) => Drawn[]} */
const roomsOf = ({ items, inner }) => items.map((item) => framed(item, inner.get(item.element)?.extent));

/** @type {(item: Drawn, extent: Extent | undefined) => Drawn} */
const framed = (item, extent) =>
  extent === undefined
    ? item
    : {
        ...item,
        at: {
          x: item.at.x + (extent.right - extent.left) / 2,
          y: item.at.y + (extent.down - extent.up) / 2,
        },
        size: { width: extent.left + extent.right, height: extent.up + extent.down },
      };

/** Everything as it is seen on the sheet, with the plane of each page. @type {(of: Arranged, shift: Point, depth: number, planes: Map<string, Plane>) => Drawn[]} */
function placed({ page, items, openings, inner }, shift, depth, planes) {
  planes.set(page, new Plane(openings, shift));
  return items.flatMap((item) => {
    const at = { x: item.at.x + shift.x, y: item.at.y + shift.y };
    const seen = { ...item, at, anchor: at, depth };
    const contents = inner.get(item.element);
    if (contents === undefined) return [seen];
    const { middle, extent } = contents;
    const begin = { x: at.x - middle.x, y: at.y - middle.y };
    return [framed(seen, extent), ...placed(contents, begin, depth + 1, planes)];
  });
}

/** What leads from one object to another. @typedef {{ element: string, line: Line, source: string | null, target: string | null }} Leading */

/** @typedef {Map<string, { text: string, sheet: string }[]>} Ports */

/** Of every model, for the revision that was drawn last. @type {WeakMap<Model, { of: string, lines: Leading[], ports: Ports }>} */
const drawnLast = new WeakMap();

/** @type {(model: Model) => { of: string, lines: Leading[], ports: Ports }} */
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

/** @type {(model: Model, element: string, page: string, pages: Set<string>) => Drawn} */
function shape(model, element, page, pages) {
  const kind = model.kind(element).shape ?? "page";
  const title = model.label(element);
  const lines = notes(model, element, kind, pages);
  const isPage = model.isSheet(element);
  const widest = Math.max(7.5 * title.length + (isPage ? 26 : 0), ...lines.map((text) => 5.2 * text.length));
  const size = SIZES[kind] ?? {
    width: Math.round(Math.min(260, Math.max(80, widest + 28))),
    height: 14 + 12 * (1 + lines.length),
  };
  const tokens = kind === "place" ? model.tokens(element) : 0;
  const isOpen = pages.has(element);
  return { ...EMPTY, id: element, element, kind, title, lines, tokens, size, page, isPage, isOpen };
}

/** What stands below a name. @type {(model: Model, element: string, kind: string, pages: Set<string>) => string[]} */
function notes(model, element, kind, pages) {
  if (kind === "transition") {
    const clause = model.links(element, "clause")[0];
    return [
      ...(clause === undefined ? [] : [String(model.value(clause, "text") ?? "")]),
      ...(model.value(element, "guard") ? [`[${model.value(element, "guard")}]`] : []),
      ...(model.value(element, "assigns") ? [String(model.value(element, "assigns"))] : []),
      ...timesOf(model, element),
    ];
  }
  if (kind === "place") return portsAt(model, element, pages);
  const words = model.kind(element).words;
  if (kind === "topic" || kind === "service" || kind === "action") {
    const name = model.value(element, kind);
    const shown = name === model.label(element) ? kind : `${kind} ${name}`;
    return [shown, ...timesOf(model, element), ...waiting(model, element)];
  }
  if (kind.endsWith("-reference")) return [];
  const count = model.links(element, "objects").length;
  return [words, ...timesOf(model, element), `${count} inside`];
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

/** Which channels a place gives to or takes from, that are not seen with it. @type {(model: Model, place: string, pages: Set<string>) => string[]} */
const portsAt = (model, place, pages) =>
  (known(model).ports.get(place) ?? []).filter(({ sheet }) => !pages.has(sheet)).map(({ text }) => text);

/** What ports say at their places, and on which sheet their channels are. @type {(model: Model, lines: Leading[]) => Ports} */
function portsOf(model, lines) {
  /** @type {Ports} */
  const found = new Map();
  for (const { element, line, source, target } of lines) {
    const channel = model.get(element).in;
    if ((line.from !== "in" && line.to !== "in") || channel === undefined) continue;
    const place = line.to === "in" ? source : target;
    if (place === null) continue;
    const port = portOf(model, element);
    const text = `${line.to === "in" ? "→" : "←"} ${model.label(channel)}${port === null ? "" : ` ${inShort(port)}`}`;
    found.set(place, [...(found.get(place) ?? []), { text, sheet: model.sheetOf(channel) }]);
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

/** @type {(model: Model, line: Pick<Drawn, "id" | "element" | "kind" | "from" | "to" | "isOwn" | "ports">, planes: Map<string, Plane>) => Drawn} */
function lineOf(model, line, planes) {
  const isArc = model.isA(model.get(line.element).type, "pn.Arc");
  const page = model.get(line.element).in ?? "";
  return {
    ...EMPTY,
    ...line,
    title: model.label(line.element),
    weight: isArc ? Number(model.value(line.element, "weight")) : 1,
    bends:
      isArc && line.isOwn
        ? pointsOf(model, line.element).map((point) => planes.get(page)?.to(point) ?? point)
        : [],
    page,
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
  page: "",
  isPage: false,
  isOpen: false,
  depth: 0,
  stored: { x: 0, y: 0 },
  at: { x: 0, y: 0 },
  anchor: { x: 0, y: 0 },
  size: { width: 0, height: 0 },
  from: "",
  to: "",
  bends: [],
  isOwn: true,
  ports: [],
};
