// What the editor's pages get from Python (views/editing), and what they use of diagram-js.

/** An attribute's value. */
export type Value = string | number | boolean | null;

/** A handle, or an element of another file. */
export type Target = string | { elsewhere: string | null };

export interface ModelObject {
  type: string;
  in?: string;
  as?: string;
  values?: Record<string, string | number | boolean>;
  links?: Record<string, Target | Target[]>;
}

export interface Feature {
  name: string;
  says: string;
  kind: "attribute" | "part" | "reference";
  type: string;
  many?: boolean;
  required?: boolean;
  default?: string | number | boolean;
}

export interface Line {
  from: string;
  to: string;
  kind: string;
}

export interface ModelClass {
  words: string;
  says: string;
  supers: string[];
  made: boolean;
  rules: string[];
  features: Feature[];
  shape?: string;
  lines?: Line[];
  /** A class inside whose objects none is offered. */
  notWithin?: string;
  /** The middleware under which one is offered. */
  under?: string;
}

export interface Metamodel {
  classes: Record<string, ModelClass>;
  enumerations: Record<string, { name: string; says: string }[]>;
  templates: { name: string; says: string }[];
}

export interface Mark {
  element: string | null;
  at: string | null;
  what: string;
  constraint: string;
  severity: "error" | "warning";
  message: string;
  fix: string;
  fixedBy?: { label: string; commands: Command[] };
}

export interface Marks {
  errors: number;
  warnings: number;
  marks: Mark[];
}

export interface FileState {
  file: string;
  disk: "same" | "changed" | "gone" | "new";
  saved: boolean;
  undo: string | null;
  redo: string | null;
}

export interface Snapshot {
  type: "snapshot";
  epoch: string;
  revision: number;
  metamodel: Metamodel;
  model: { root: string; objects: Record<string, ModelObject> };
  marks: Marks;
  state: FileState;
  recovered: number;
  jobs: Job[];
}

export interface Done {
  type: "done";
  number: number;
  made?: Record<string, string>;
  keepsForm?: boolean;
  game?: Game;
}

/** What a check has found, its elements by handle; a witness is played by its number. */
export interface Finding {
  rule: string;
  severity: "error" | "warning" | "note";
  message: string;
  elements: string[];
  witness: number | null;
}

/** What `dineros` answers with --json, of the kinds of work that are done here. */
export interface Result {
  findings?: Finding[];
  proved?: string[];
  unknown?: string[];
  status?: string;
  reason?: string;
  by?: string;
  witness?: number | null;
  changes?: { file: string; what: string; detail: string }[];
  edits?: { file: string; message: string }[];
  notices?: (string | Record<string, string>)[];
  written?: boolean;
  stale?: boolean;
  ending?: string;
  firings?: number;
  drops?: number;
  errors?: number;
  marking?: Record<string, number>;
  traces?: boolean;
}

/** Something that another process does, as views/editing/working/jobs.py has it. */
export interface Job {
  job: number;
  kind: "check" | "find" | "verify" | "generate" | "run";
  words: string;
  line: string;
  epoch: string;
  revision: number;
  state: "running" | "ending" | "done" | "failed" | "cancelled";
  at: string;
  log: string[];
  result: Result;
}

/** A transition of the net that is proved: what it is in words, and the elements of the model it is seen at. */
export interface Firing {
  id: string;
  text: string;
  kind: "fire" | "signal" | "channel" | "loss";
  elements: string[];
  /** Of a change of a signal with values: what the signal becomes. */
  value?: string;
}

/** A token game, as views/editing/playing/showing.py has it. */
export interface Game {
  epoch: string;
  revision: number;
  at: number;
  length: number;
  loop: number | null;
  title: string;
  places: Record<string, number>;
  queues: Record<string, { text: string; load: number; room: number }[]>;
  under: Record<string, { text: string; tokens: number }[]>;
  signals: Record<string, boolean | string>;
  firings: Firing[];
  first: number;
  steps: Firing[];
}

export interface Refused {
  type: "refused";
  number: number | null;
  reason: string;
  hint?: string;
  column?: number;
}

export type Message =
  | Snapshot
  | Done
  | Refused
  | { type: "change"; revision: number; objects: Record<string, ModelObject | null>; state: FileState }
  | { type: "marks"; revision: number; marks: Marks }
  | { type: "state"; state: FileState }
  | ({ type: "job" } & Job);

/** A command, as dineros.metamodel.editing.commands describes it. */
export interface Command {
  kind: string;
  [field: string]: Value | Record<string, Value> | string[] | number[][];
}

export interface Point {
  x: number;
  y: number;
}

/** A shape or a line of the canvas; `business` is what it stands for. */
export interface CanvasElement extends Point {
  id: string;
  width: number;
  height: number;
  waypoints: Point[];
  source: CanvasElement;
  target: CanvasElement;
  parent: CanvasElement | null;
  children: CanvasElement[];
  business: Drawn;
}

/** Descriptions of messages at the end of a topic. */
export interface Port {
  limit: number;
  isBestEffort: boolean;
  isKept: boolean;
  times: string[];
}

/** What a sheet shows. */
export interface Drawn {
  id: string;
  element: string;
  kind: string;
  title: string;
  lines: string[];
  tokens: number;
  weight: number;
  /** The page that it stands on. */
  page: string;
  /** Whether it has a sheet of its own, and whether what is on that is seen in its frame. */
  isPage: boolean;
  isOpen: boolean;
  /** In how many open pages it is. */
  depth: number;
  /** Where its page has it, or would have it. */
  stored: Point;
  /** The middle of it on the sheet. */
  at: Point;
  /** What of the sheet is the point that is stored. */
  anchor: Point;
  size: { width: number; height: number };
  from: string;
  to: string;
  bends: Point[];
  isOwn: boolean;
  ports: Port[];
}

/** How far a frame reaches in each direction. */
export interface Extent {
  left: number;
  right: number;
  up: number;
  down: number;
}

/** The strips of the plane that an open page widens. */
export interface Opening {
  page: string;
  x: { from: number; to: number; rate: number }[];
  y: { from: number; to: number; rate: number }[];
}

export interface Box extends Point {
  width: number;
  height: number;
}

export interface DiagramEvent {
  element: CanvasElement;
  originalEvent: MouseEvent;
  context: { shapes: CanvasElement[] };
  newSelection: CanvasElement[];
}

interface Services {
  canvas: {
    setRootElement(root: CanvasElement): void;
    getRootElement(): CanvasElement;
    addShape(shape: CanvasElement, parent: CanvasElement, index?: number): CanvasElement;
    addConnection(line: CanvasElement, parent: CanvasElement, index?: number): CanvasElement;
    removeShape(shape: CanvasElement): void;
    removeConnection(line: CanvasElement): void;
    viewbox(): Box & { scale: number };
    viewbox(box: Box): void;
    scrollToElement(element: CanvasElement, padding?: number): void;
    getGraphics(element: CanvasElement): SVGGElement;
    getContainer(): HTMLElement;
  };
  elementFactory: {
    createRoot(values: object): CanvasElement;
    createShape(values: object): CanvasElement;
    createConnection(values: object): CanvasElement;
  };
  elementRegistry: {
    get(id: string): CanvasElement | undefined;
    filter(wanted: (element: CanvasElement) => boolean): CanvasElement[];
  };
  eventBus: {
    on(name: string, heard: (event: DiagramEvent) => unknown): void;
    on(name: string, priority: number, heard: (event: DiagramEvent) => unknown): void;
    fire(name: string, event: object): void;
  };
  selection: {
    get(): CanvasElement[];
    select(elements: CanvasElement | CanvasElement[] | null, add?: boolean): void;
  };
  lassoTool: { toggle(): void };
  dragging: { cancel(): void };
}

export interface DiagramInstance {
  get<K extends keyof Services>(name: K): Services[K];
  clear(): void;
}

type Module = object;

declare global {
  const DiagramJS: {
    Diagram: new (options: { canvas: { container: HTMLElement }; modules: Module[] }) => DiagramInstance;
    BaseRenderer: new (eventBus: Services["eventBus"], priority: number) => object;
    BendpointsModule: Module;
    ChangeSupportModule: Module;
    LassoToolModule: Module;
    MoveModule: Module;
    MoveCanvasModule: Module;
    OutlineModule: Module;
    SnappingModule: Module;
    ZoomScrollModule: Module;
  };
}
