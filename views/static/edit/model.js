// What the page knows of the model: objects by handle, as Python sends them. Only Python changes them.

import { wordsOf } from "./times.js";

/** @import { Feature, FileState, Finding, Game, Mark, Marks, Message, Metamodel, ModelClass, ModelObject, Snapshot, Target } from "./types.js" */

export class Model {
  /** @type {Map<string, ModelObject>} */
  objects = new Map();
  root = "";
  /** Of which content of the file handles are those. */
  epoch = "";
  revision = -1;
  /** @type {Metamodel} */
  metamodel = { classes: {}, enumerations: {}, templates: [] };
  /** @type {Marks} */
  marks = { errors: 0, warnings: 0, marks: [] };
  /** @type {FileState} */
  state = { file: "", disk: "same", saved: true, undo: null, redo: null };

  /** The token game that is played, whose tokens are shown instead of the first ones. @type {Game | null} */
  played = null;

  /** What the last check found in this state of the model. @type {Finding[]} */
  findings = [];

  /** @type {(snapshot: Snapshot) => void} */
  begin({ metamodel, model, marks, state, revision, epoch }) {
    Object.assign(this, { metamodel, marks, state, revision, epoch, root: model.root });
    this.objects = new Map(Object.entries(model.objects));
  }

  /** Takes a message in. @type {(message: Message) => void} */
  told(message) {
    if (message.type === "snapshot") this.begin(message);
    if (message.type === "change") {
      this.revision = message.revision;
      this.state = message.state;
      for (const [handle, object] of Object.entries(message.objects)) {
        if (object === null) this.objects.delete(handle);
        else this.objects.set(handle, object);
      }
    }
    if (message.type === "marks") this.marks = message.marks;
    if (message.type === "state") this.state = message.state;
  }

  /** @type {(handle: string) => ModelObject} */
  get(handle) {
    const found = this.objects.get(handle);
    if (found === undefined) throw new Error(`no object has the handle ${handle}`);
    return found;
  }

  /** @type {(type: string) => ModelClass} */
  classOf(type) {
    return this.metamodel.classes[type];
  }

  /** @type {(handle: string) => ModelClass} */
  kind(handle) {
    return this.classOf(this.get(handle).type);
  }

  /** Whether a class is another one or extends it. @type {(type: string, other: string) => boolean} */
  isA(type, other) {
    return type === other || (this.classOf(type)?.supers ?? []).includes(other);
  }

  /** The value of an attribute, its default where it has none. @type {(handle: string, name: string) => string | number | boolean | null} */
  value(handle, name) {
    const given = this.get(handle).values?.[name];
    return given ?? this.feature(handle, name)?.default ?? null;
  }

  /** @type {(handle: string, name: string) => Feature | undefined} */
  feature(handle, name) {
    return this.kind(handle).features.find((each) => each.name === name);
  }

  /** Handles that a feature leads to. @type {(handle: string, name: string) => string[]} */
  links(handle, name) {
    /** @type {Target | Target[]} */
    const found = this.get(handle).links?.[name] ?? [];
    return (Array.isArray(found) ? found : [found]).filter((each) => typeof each === "string");
  }

  /** @type {(handle: string, name: string) => string | null} */
  link(handle, name) {
    return this.links(handle, name)[0] ?? null;
  }

  /** What people read: name or id; of times, how long; of other parts that have neither, what they are. @type {(handle: string) => string} */
  label(handle) {
    const object = this.get(handle);
    const said =
      object.values?.name ?? object.values?.id ?? object.values?.client ?? object.values?.messageField;
    if (said !== undefined) return String(said);
    if (this.feature(handle, "earliest") !== undefined) return wordsOf(this, handle);
    const leads = this.kind(handle).features.find((each) => each.kind === "reference" && each.required);
    const target = leads === undefined ? null : this.link(handle, leads.name);
    const words = this.kind(handle).words;
    return target === null ? words : `${words} ${this.label(target)}`;
  }

  /** Marks of an element and its parts. @type {(handle: string) => Mark[]} */
  marksOf(handle) {
    return this.marks.marks.filter(({ element, at }) => element === handle || at === handle);
  }

  /**
   * What clauses of an element can refer to: signals, and comparisons with the values of those that have some.
   *
   * @type {(handle: string) => { name: string, value?: string }[]}
   */
  signalsFor(handle) {
    for (let at = this.get(handle).in; at !== undefined; at = this.get(at).in) {
      if (this.feature(at, "signals")?.kind === "part")
        return this.links(at, "signals").flatMap((signal) => {
          const values = this.links(signal, "values").map((value) => this.label(value));
          const name = this.label(signal);
          return values.length ? values.map((value) => ({ name, value })) : [{ name }];
        });
    }
    return [];
  }

  /** The tokens of a place. @type {(place: string) => number} */
  tokens(place) {
    return this.played?.places[place] ?? Number(this.value(place, "tokens"));
  }

  /** An element and all that it is in. @type {(handle: string) => string[]} */
  around(handle) {
    const found = [];
    for (let at = handle; this.objects.has(at); at = this.get(at).in ?? "") found.push(at);
    return found;
  }

  /** All objects of a class, in the order they were made. @type {(type: string) => string[]} */
  all(type) {
    const found = [...this.objects]
      .filter(([, object]) => this.isA(object.type, type))
      .map(([handle]) => handle);
    return found.sort((one, other) => Number(one.slice(1)) - Number(other.slice(1)));
  }

  /** By whose rules the model is flattened; null: it does not say. @type {string | null} */
  get middleware() {
    const said = this.feature(this.root, "middleware") && this.value(this.root, "middleware");
    return typeof said === "string" ? said : null;
  }

  /** Whether an object has a sheet of its own. @type {(handle: string) => boolean} */
  isSheet(handle) {
    const { type } = this.get(handle);
    return this.isA(type, "pn.Net") || this.isA(type, "pn.Page");
  }

  /** The sheet that an object is on; of parts, that of what they belong to. @type {(handle: string) => string} */
  sheetOf(handle) {
    let at = handle;
    while (this.kind(at).shape === undefined) {
      const above = this.get(at).in;
      if (above === undefined) return at;
      // Parts of a sheet that are not drawn, such as signals, are in the form of the sheet.
      if (this.isSheet(above)) return above;
      at = above;
    }
    return this.link(at, "canvas") ?? this.get(at).in ?? at;
  }
}
