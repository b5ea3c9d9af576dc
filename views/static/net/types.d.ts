// Types of nets. `dineros.views.nets.model` explains the fields; it omits empty ones.

export type Point = [x: number, y: number];
/** The position of an element, without its name. */
export interface Spot {
  x: number;
  y: number;
}
export type Size = [width: number, height: number];
export type Area = [left: number, top: number, right: number, bottom: number];
export type Side = "WEST" | "EAST" | "NORTH" | "SOUTH";
export type Change = "added" | "removed" | "changed";

export type NodeKind =
  | "place"
  | "transition"
  | "place-reference"
  | "transition-reference"
  | "topic"
  | "service";
export type BoxKind = "node" | "page" | "timer" | "subscriber" | "server" | "group";
export type EdgeKind =
  | "normal"
  | "read"
  | "inhibitor"
  | "reference"
  | "publish"
  | "subscribe"
  | "request"
  | "response"
  | "call"
  | "return";

/** What nodes, boxes and edges have in common. */
interface Element {
  id: string;
  change?: Change;
  notes?: string[];
  detail?: Record<string, string>;
}

/** What nodes and boxes have in common. */
interface Shape extends Element {
  width: number;
  height: number;
  glyph: string;
  badge?: string;
  position?: Point;
  tokens?: number;
  room?: Size;
  frame?: Size;
}

export interface Node extends Shape {
  kind: NodeKind;
  label: string;
  box?: string | null;
  target?: string;
}

export interface Signal {
  id: string;
  label: string;
  initial?: boolean;
  /** Its value at the start, if it has several. */
  value?: string | null;
}

export interface Box extends Shape {
  kind: BoxKind;
  title: string;
  parent?: string | null;
  collapsed?: boolean;
  signals?: Signal[];
  /** Of a managed ROS node; it begins in the first. */
  states?: string[];
  summary?: string;
  header: Size;
  head: string;
}

export interface Edge extends Element {
  source: string;
  target: string;
  kind: EdgeKind;
  label?: string;
  weight?: number;
  also?: string;
  bends?: Point[];
  room?: Size;
  /** Ids of the edges it stands for, where boxes are collapsed. */
  stands?: string[];
}

export type Item = Node | Box;

export interface View {
  id: string;
  title: string;
  kind: string;
  compared?: boolean;
  /** Width by height that the layout comes near to; else it is one line from left to right. */
  aspect?: number;
  boxes: Box[];
  nodes: Node[];
  edges: Edge[];
}

// A view that has been laid out: boxes by their left upper corner, nodes by their centre.

export type PlacedBox = Box & Spot;
export type PlacedNode = Node & Spot & { /** By how much its caption moves. */ captionAt?: Point };
export type Placed = PlacedBox | PlacedNode;
export type PlacedEdge = Edge & { points: Point[]; labelAt?: Point };

export interface Picture extends View {
  width: number;
  height: number;
  boxes: PlacedBox[];
  nodes: PlacedNode[];
  edges: PlacedEdge[];
}

// What is laid out by ELK, as elkjs has it: https://rtsys.informatik.uni-kiel.de/elklive/json.html

export type Options = Record<string, string>;

export interface GraphLabel {
  id: string;
  text: string;
  width: number;
  height: number;
}

export interface GraphPort {
  id: string;
  width: number;
  height: number;
  x?: number;
  y?: number;
  layoutOptions?: Options;
}

export interface GraphEdge {
  id: string;
  sources: [string];
  targets: [string];
  labels?: GraphLabel[];
  layoutOptions?: Options;
}

export interface Graph {
  id: string;
  width?: number;
  height?: number;
  labels?: GraphLabel[];
  children?: Graph[];
  edges?: GraphEdge[];
  ports?: GraphPort[];
  layoutOptions?: Options;
}

export interface LaidSection {
  startPoint: Spot;
  bendPoints?: Spot[];
  endPoint: Spot;
}

export interface LaidEdge extends GraphEdge {
  labels?: (GraphLabel & Spot)[];
  sections?: LaidSection[];
}

export interface LaidGraph extends Graph, Spot {
  width: number;
  height: number;
  children?: LaidGraph[];
  edges?: LaidEdge[];
  ports?: (GraphPort & Spot)[];
}

export interface Engine {
  layout(graph: Graph): Promise<LaidGraph>;
}

/** Gives the engine when it is needed: it is large. */
export type LoadEngine = () => Engine | Promise<Engine>;

// How a view is cut into sheets: see pieces.js.

export interface Port {
  id: string;
  side: Side;
  /** The item of the sheet that its line goes to. */
  via: string;
}

/** Two items of a sheet that are joined, and the piece or edge that does. */
export type Link = [one: string, other: string, edge: string];

/** A line that is drawn when everything has its place. */
export interface Line {
  id: string;
  edge: Edge;
  /** Whether it is laid out against its direction. */
  back: boolean;
  source: string;
  target: string;
  labelled: boolean;
  sheets: Sheet[];
  /** Whether it keeps the bends of an editor. */
  bent: boolean;
}

/** An open box, or the whole (""). */
export interface Sheet {
  id: string;
  box?: Box;
  /** Ids in the order of the layout. */
  children: string[];
  /** What is on it, in the order of the view. */
  members: Item[];
  arranged: boolean;
  /** Ids of what has no position on an arranged sheet. */
  free: Set<string>;
  ports: Port[];
  /** What ELK lays out. */
  edges: GraphEdge[];
  lines: Line[];
  links: Link[];
}

/** The pieces of an edge in the direction of the layout, and whether that is not the edge's own. */
export interface Chain {
  pieces: { id: string; flip: boolean }[];
  back: boolean;
}

export interface Plan {
  sheets: Map<string, Sheet>;
  items: Map<string, Item>;
  /** By id of edge. */
  chains: Map<string, Chain>;
  /** Ids of sheets, outer ones first. */
  order: string[];
  large: boolean;
  aspect?: number;
}

// Where things continue sheets that were arranged: see stored.js.

/** An item; an open box has the size that it is open with. */
export type Seated = Pick<Shape, "id" | "width" | "height" | "room" | "position" | "frame"> & { open?: Size };
export type Stored = Seated & { position: Point };

/** How far something reaches from its centre. */
export interface Reach {
  side: number;
  up: number;
  down: number;
}

/** Items without a position that stay together; `x` and `y` are of their centres, from the block's corner. */
export interface Block {
  width: number;
  height: number;
  parts: { item: Seated; x: number; y: number }[];
  /** Ids of what it is joined to. */
  near: string[];
  anchor: Point | null;
}

/** A part of a laid-out graph that hangs together. */
export interface Part {
  children: LaidGraph[];
  edges: LaidEdge[];
}

export interface PlacedSheet {
  at: Map<string, Spot>;
  width: number;
  height: number;
  /** Where bend points go. */
  bent: (points: Point[]) => Point[];
}

export interface ArrangedSheet extends PlacedSheet {
  free: LaidGraph | null;
  ports: (Spot & { id: string; side: Side })[];
}

// How lines are drawn: see lines.js.

/** An end in an item, whose line leaves its shape, or of a port. */
export interface End extends Spot {
  item?: Pick<Shape, "width" | "height"> & { kind: NodeKind | BoxKind };
  middle?: Point;
  out?: Point;
  /** The distance by which it is moved so that lines end next to each other. */
  shift?: Point;
}

export interface Path {
  points: Point[];
  label?: Point;
}

/** Everything's place: areas of items, ends and sides of ports, paths of what ELK laid out. */
export interface Places {
  at: Map<string, Spot & { width: number; height: number }>;
  ports: Map<string, Spot>;
  sides: Map<string, Side>;
  paths: Map<string, Path>;
}

/** A line and its ends. */
export interface DrawnLine extends Line {
  key: string;
  sourceEnd: End;
  targetEnd: End;
  bends?: Point[];
}

declare global {
  /** The engine, where elkjs has been loaded. */
  const ELK: new () => Engine;
}
