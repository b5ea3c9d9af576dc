// The page of the editor: what people do becomes commands, what Python says becomes what they see.

import { counted } from "../counting.js";
import { byId } from "../elements.js";
import { ACTIONS, focusedElement } from "./actions.js";
import { showHint, showMarks, showPath, showState } from "./around.js";
import { Canvas } from "./canvas/canvas.js";
import { Places } from "./canvas/places.js";
import { Clipboard } from "./clipboard.js";
import { Connection } from "./connection.js";
import { askForAction, askForTemplate, search } from "./forms/asking.js";
import { showActions, showForm } from "./forms/form.js";
import { heed } from "./keys.js";
import { Model } from "./model.js";
import { Pen } from "./pen.js";
import { Player, refusedInGame } from "./running/play.js";
import { Worker } from "./running/work.js";

/** @import { Command, Done, Message, Point, Refused } from "./types.js" */

export class Editor {
  model = new Model();
  canvas = new Canvas(byId("canvas", HTMLElement), this.model, {
    act: (commands, label) => this.act(commands, label),
    chosen: (elements) => this.look(elements.length === 1 ? elements[0] : null),
    clicked: (element, at) => this.clicked(element, at),
    opened: (element) => this.open(element),
    toggled: (page) => this.toggle(page),
  });
  /** What the form shows; null: the sheet. @type {string | null} */
  looked = null;
  /** The marks in the form. */
  formMarks = "";
  clipboard = new Clipboard(this);
  places = new Places(this);
  pen = new Pen(this);
  connection = new Connection(
    (message) => this.hear(message),
    (state) => this.connected(state),
  );

  player = new Player(this);
  worker = new Worker(this);

  constructor() {
    byId("undo", HTMLElement).onclick = () => this.turn("undo");
    byId("redo", HTMLElement).onclick = () => this.turn("redo");
    byId("save", HTMLElement).onclick = () => this.save(false);
    byId("fit", HTMLElement).onclick = () => this.canvas.fit();
    byId("arrange", HTMLElement).onclick = () => this.places.arrange();
    byId("search", HTMLElement).onclick = () => search(this);
    byId("actions", HTMLElement).onclick = () => askForAction(this);
    byId("keys", HTMLElement).onclick = () => byId("help", HTMLDialogElement).showModal();
    const theme = byId("theme", HTMLSelectElement);
    const dark = matchMedia("(prefers-color-scheme: dark)");
    const paint = () => {
      const asked = theme.value === "auto" ? (dark.matches ? "dark" : "light") : theme.value;
      document.body.dataset.theme = asked;
    };
    theme.onchange = paint;
    dark.onchange = paint;
    paint();
    document.addEventListener("keydown", (event) => heed(event, this));
    addEventListener("beforeunload", (event) => {
      if (this.connection.waiting.size > 0) event.preventDefault();
    });
  }

  // ---------------------------------------------------------------------------------- what Python says

  /** @type {(message: Message) => void} */
  hear(message) {
    const before = this.canvas.sheet;
    if (message.type === "change" && message.revision !== this.model.revision + 1) {
      this.connection.socket?.close(); // something was missed: it comes back with everything
      return;
    }
    this.model.told(message);
    if (message.type === "snapshot") {
      this.places.forget();
      this.canvas.openPages.recall();
      const count = message.recovered;
      if (count) this.say(`${counted(count, "unsaved change")} restored from the journal`);
    }
    this.worker.hear(message);
    if (message.type === "job") return;
    if (message.type === "state") {
      this.showState();
      return;
    }
    if (message.type === "marks") {
      this.canvas.describe();
      this.showMarks();
      if (this.formMarks !== JSON.stringify(this.model.marksOf(this.looked ?? before))) this.showForm();
      document.body.dataset.revision = String(this.model.revision);
      return;
    }
    const still = before && this.model.objects.has(before) ? before : this.firstSheet();
    if (this.looked !== null && !this.model.objects.has(this.looked)) this.looked = null;
    if (this.pen.source !== null && !this.model.objects.has(this.pen.source)) this.pen.source = null;
    this.show(still);
    document.body.dataset.revision = String(this.model.revision);
  }

  /** The model's own sheet; where that has one page alone, that of the page. */
  firstSheet() {
    const { root } = this.model;
    const pages = this.model.links(root, "pages");
    const isAlone = pages.length === 1 && this.model.links(root, "channels").length === 0;
    return isAlone && this.model.get(pages[0]).type === "pn.Page" ? pages[0] : root;
  }

  /** @type {(state: "live" | "lost" | "refused") => void} */
  connected(state) {
    document.body.dataset.connection = state;
    if (state === "live") this.say("");
    if (state === "lost") this.say("the connection is lost: what you do now is done when it is back", true);
    if (state === "refused") this.say("open the address that was printed, token included", true);
  }

  // ---------------------------------------------------------------------------------- what is seen

  /** @type {(sheet: string) => void} */
  show(sheet) {
    if (sheet !== this.canvas.sheet) this.pen.lay();
    this.canvas.show(sheet);
    showPath(this.model, sheet, (element) => this.go(element));
    this.pen.show();
    this.showState();
    this.showMarks();
    this.showForm();
    showHint(this.model, sheet, this.canvas.shapes().length === 0, () => askForTemplate(this));
    this.player.show();
    this.places.find();
  }

  /** The page at hand: what is made comes there. */
  get page() {
    return this.canvas.pageOf(this.looked ?? this.canvas.chosenShapes()[0] ?? null);
  }

  showMarks() {
    const act = (/** @type {Command[]} */ commands, /** @type {string} */ label) => this.act(commands, label);
    showMarks(this.model, (element) => this.go(element), act);
  }

  showState() {
    const reload = () => this.reload();
    showState(this.model, reload, () => this.save(true));
  }

  showForm() {
    const count = this.canvas.chosenShapes().length;
    if (count > 1) {
      showActions(byId("form", HTMLElement), count, this.actions());
      return;
    }
    this.formMarks = JSON.stringify(this.model.marksOf(this.looked ?? this.canvas.sheet));
    showForm(byId("form", HTMLElement), this.model, this.looked ?? this.canvas.sheet, {
      act: (commands, label) => this.act(commands, label),
      compose: (operation, label) => this.compose(operation, label),
      clause: (element, text) => this.wrongClause(element, text),
      found: (element) => this.worker.foundAt(element),
      go: (element) => this.go(element),
      make: (owner, feature, type, given) => this.pen.make(owner, feature, type, given ?? null),
      opening: (element) =>
        this.canvas.registry.get(element)?.business.isPage
          ? { isOpen: this.canvas.isOpen(element), toggle: () => this.toggle(element) }
          : null,
    });
  }

  /** @type {(text: string, isRefused?: boolean) => void} */
  say(text, isRefused = false) {
    const said = byId("said", HTMLElement);
    said.textContent = text;
    said.classList.toggle("refused", isRefused);
  }

  /** @type {(element: string | null) => void} */
  look(element) {
    this.looked = element;
    this.canvas.held = this.page;
    if (this.page !== this.pen.toolsOf) this.pen.show();
    this.showForm();
  }

  /** Shows an element: its sheet, and its form. @type {(element: string) => void} */
  go(element) {
    if (this.model.isSheet(element)) {
      this.looked = null;
      this.show(element);
      return;
    }
    const isSeen = this.canvas.planes.has(this.model.sheetOf(element));
    this.show(isSeen ? this.canvas.sheet : this.model.sheetOf(element));
    this.canvas.choose(element, true);
    this.look(element);
  }

  /** Opens a page in place, or closes it. @type {(page: string) => void} */
  toggle(page) {
    this.canvas.toggle(page, !byId("form", HTMLElement).contains(document.activeElement));
    this.look(page);
    this.places.find();
  }

  /** @type {(element: string) => void} */
  open(element) {
    if (this.model.isSheet(element)) this.go(element);
    else this.rename(element);
  }

  // ---------------------------------------------------------------------------------- what people do

  /**
   * Does something to the model.
   *
   * @param {Command[]} commands
   * @param {string} label
   * @returns {Promise<string | null>} why not, or null
   */
  async act(commands, label) {
    if (commands.length === 0) return null;
    return this.answered(await this.change("do", { commands, label, epoch: this.model.epoch }));
  }

  /** Asks for a change of the model, which is left as it is while it is played. @type {(ask: "do" | "undo" | "redo" | "reload", more?: object) => Promise<Done | Refused>} */
  async change(ask, more = {}) {
    return this.player.game === null ? this.connection.ask(ask, more) : refusedInGame(0);
  }

  /** @type {(answer: Done | Refused, isEdit?: boolean) => string | null} */
  answered(answer, isEdit = true) {
    if (answer.type === "done") {
      this.say("");
      return null;
    }
    const where = answer.column === undefined ? "" : `column ${answer.column}: `;
    const text = `${where}${answer.reason}${answer.hint ? ` (${answer.hint})` : ""}`;
    this.say(text, true);
    if (isEdit) this.canvas.draw(); // what was dragged goes back
    return text;
  }

  /** @type {(way: "undo" | "redo") => Promise<void>} */
  async turn(way) {
    this.answered(await this.change(way, { epoch: this.model.epoch }));
  }

  /** @type {(over: boolean) => Promise<void>} */
  async save(over) {
    const answer = await this.connection.ask("save", { over });
    if (this.answered(answer) !== null || answer.type !== "done") return;
    this.say(answer.keepsForm ? "saved" : "saved; the file is written in our own form now");
  }

  async reload() {
    this.answered(await this.change("reload"));
  }

  /** Uses a click, or Enter, which is nowhere. @type {(element: string | null, at: Point | null) => boolean} */
  clicked(element, at) {
    return this.player.game === null ? this.pen.clicked(element, at) : this.player.clicked(element);
  }

  /** @type {(element: string) => void} */
  rename(element) {
    this.look(element);
    const name = this.model.get(element).values?.name === undefined ? "id" : "name";
    const field = document.getElementById(`field-${name}`);
    if (field instanceof HTMLInputElement) {
      field.focus();
      field.select();
    }
  }

  // ---------------------------------------------------------------------------------- larger steps

  /**
   * Does something larger, and chooses what comes of it.
   *
   * @param {Command} operation
   * @param {string} label
   * @param {string[] | null} [elements] what is chosen then; null: what was made
   * @returns {Promise<string | null>} why not, or null
   */
  async compose(operation, label, elements) {
    const answer = await this.connection.ask("compose", { operation, label, epoch: this.model.epoch });
    const reason = this.answered(answer);
    if (reason !== null || answer.type !== "done" || elements === undefined) return reason;
    this.canvas.chooseThese(elements ?? Object.values(answer.made ?? {}));
    return null;
  }

  /** What is wrong with a text as the clause of a transition. @type {(element: string, text: string) => Promise<Refused | null>} */
  async wrongClause(element, text) {
    const answer = await this.connection.ask("clause", { element, text, epoch: this.model.epoch });
    return answer.type === "refused" ? answer : null;
  }

  /** @type {(type: string) => Promise<string | null>} */
  group(type) {
    const elements = this.canvas.chosenShapes();
    return this.compose({ kind: "group", elements, type }, "group into a page", null);
  }

  split() {
    const [page] = this.canvas.chosenShapes();
    const contents = this.model.links(page, "objects");
    return this.compose({ kind: "split", page }, `split ${this.model.label(page)}`, contents);
  }

  /** Whether a shape stands for a page. @type {(shape: { business: { element: string } }) => boolean} */
  isPage({ business }) {
    return this.model.isA(this.model.get(business.element).type, "pn.Page");
  }

  /** What can be done now. */
  actions() {
    return ACTIONS.filter((action) => action.applies(this)).map(({ words, key, act }) => ({
      words,
      key,
      act: () => act(this),
    }));
  }

  // ---------------------------------------------------------------------------------- keys

  up() {
    const above = this.model.get(this.canvas.sheet).in;
    if (above !== undefined) this.go(above);
  }

  putDown() {
    this.canvas.diagram.get("dragging").cancel();
    this.pen.lay();
    this.pen.show();
    this.canvas.choose(null);
    this.look(null);
    this.say("");
  }

  remove() {
    const elements = [...new Set(this.canvas.chosen())];
    if (elements.length === 0) return;
    const label = elements.length === 1 ? this.model.label(elements[0]) : `${elements.length} elements`;
    this.act([{ kind: "delete", elements }], `delete ${label}`);
  }

  /** @type {(key: string, isFine: boolean) => void} */
  push(key, isFine) {
    const step = isFine ? 1 : 10;
    const x = key === "ArrowLeft" ? -step : key === "ArrowRight" ? step : 0;
    const y = key === "ArrowUp" ? -step : key === "ArrowDown" ? step : 0;
    const shapes = this.canvas.selection.get().filter((each) => each.waypoints === undefined);
    this.act(this.canvas.moves(shapes, { x, y }), "move");
  }

  /** @type {(event: KeyboardEvent) => void} */
  enter(event) {
    const focused = focusedElement();
    if (focused === undefined) return;
    event.preventDefault();
    if (this.clicked(focused, null)) return;
    if (this.looked === focused && this.model.isSheet(focused)) this.open(focused);
    else this.canvas.choose(focused, true);
  }

  /** @type {(event: KeyboardEvent) => void} */
  enterToo(event) {
    const focused = focusedElement();
    if (focused === undefined) return;
    event.preventDefault();
    this.canvas.chooseToo(focused);
  }
}

Object.assign(globalThis, { dinerosEditor: new Editor() });
