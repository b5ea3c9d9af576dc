// The tool in hand: what a click or Enter makes with it, and where.

import { byId } from "../elements.js";
import { moveTo } from "./canvas/canvas.js";
import { middle } from "./canvas/geometry.js";
import { askFor } from "./forms/making.js";
import { ARC, CHOOSE, showTools, toolsFor } from "./tools.js";

/** @import { Editor } from "./page.js" */
/** @import { Command, Point } from "./types.js" */
/** @import { Tool } from "./tools.js" */

export class Pen {
  /** The tool that is used. */
  tool = CHOOSE;
  /** Where an arc begins. @type {string | null} */
  source = null;
  /** Of which page the tools are that are shown. */
  toolsOf = "";

  /** @param {Editor} editor */
  constructor(editor) {
    this.editor = editor;
  }

  /** Shows the tools of the page at hand. */
  show() {
    const { model, page } = this.editor;
    this.toolsOf = page;
    const tools = toolsFor(model, page);
    showTools(byId("tools", HTMLElement), tools, this.tool, (tool, byKey) => this.take(tool, byKey));
    byId("canvas", HTMLElement).classList.toggle("making", this.tool !== CHOOSE);
  }

  /** Another sheet is shown, or nothing more is to be made. */
  lay() {
    this.tool = CHOOSE;
    this.source = null;
  }

  /** @type {(tool: Tool, byKey: boolean) => void} */
  take(tool, byKey) {
    this.tool = tool.name;
    this.source = null;
    this.show();
    if (tool.name === ARC) this.editor.say("click where the arc begins");
    else if (tool.name === CHOOSE) this.editor.say("");
    else if (byKey) this.putInMiddle(tool, this.editor.page);
    else this.editor.say(`click where the ${tool.words} goes`);
  }

  /**
   * Uses a click, or Enter, which is nowhere.
   *
   * @type {(element: string | null, at: Point | null) => boolean}
   */
  clicked(element, at) {
    if (this.tool === CHOOSE) return false;
    if (this.tool !== ARC) return this.clickedFor(element, at);
    if (element === null) return false;
    if (this.source === null) {
      this.source = element;
      this.editor.say(`from ${this.editor.model.label(element)}: click where the arc ends`);
    } else {
      this.arc(this.source, element);
    }
    return true;
  }

  /** Makes what the tool makes, on the sheet or in an open page. @type {(element: string | null, at: Point | null) => boolean} */
  clickedFor(element, at) {
    const { model, canvas } = this.editor;
    const page = element ?? canvas.sheet;
    if (!canvas.planes.has(page)) return false;
    const tool = toolsFor(model, page).find(({ name }) => name === this.tool);
    if (tool === undefined) {
      const where = `${model.kind(page).words} ${model.label(page)}`;
      this.editor.say(`${where}: nothing of that kind stands here`, true);
    } else if (at === null) {
      this.putInMiddle(tool, page);
    } else {
      this.put(tool, at, page);
    }
    return true;
  }

  /** @type {(source: string, target: string) => Promise<void>} */
  async arc(source, target) {
    this.source = null;
    const { model, canvas } = this.editor;
    const label = `arc from ${model.label(source)} to ${model.label(target)}`;
    const [owner, other] = [source, target].map((each) => model.sheetOf(each));
    const tool = toolsFor(model, owner).find(({ name }) => name === ARC);
    if (owner === other && tool !== undefined) {
      const { feature, type } = tool;
      await this.editor.act([{ kind: "create", owner, feature, type, values: { source, target } }], label);
      return;
    }
    // Beside the end that is not a place, where a reference may come to stand.
    const transition = model.kind(source).shape?.startsWith("place") ? target : source;
    const page = model.sheetOf(transition);
    const [shape, plane] = [canvas.registry.get(transition), canvas.planes.get(page)];
    if (shape === undefined || plane === undefined) return;
    const { x, y } = moveTo("", plane.from(canvas.free(middle(shape), page)));
    await this.editor.compose({ kind: "join", source, target, x, y }, label);
  }

  /** @type {(tool: Tool, page: string) => Promise<void>} */
  putInMiddle(tool, page) {
    return this.put(tool, this.editor.canvas.free(this.editor.canvas.centre(page), page), page);
  }

  /** Makes what a tool makes, at a point of the sheet. @type {(tool: Tool, at: Point, page: string) => Promise<void>} */
  async put({ feature, type, words }, at, page) {
    const commands = await askFor(this.editor.model, { owner: page, feature, type });
    this.tool = CHOOSE;
    this.show();
    const plane = this.editor.canvas.planes.get(page);
    if (commands === null || plane === undefined) return;
    const others = this.editor.canvas.settled(page);
    await this.made([...others, ...commands, moveTo("$new", plane.from(at))], `new ${words}`);
  }

  /** @type {(owner: string, feature: string, type: string, given: string | null) => Promise<void>} */
  async make(owner, feature, type, given) {
    const commands = await askFor(this.editor.model, { owner, feature, type, given });
    if (commands !== null) await this.made(commands, `new ${this.editor.model.classOf(type).words}`);
  }

  /** Does what makes an element, and shows that. @type {(commands: Command[], label: string) => Promise<void>} */
  async made(commands, label) {
    const { editor } = this;
    const answer = await editor.change("do", { commands, label, epoch: editor.model.epoch });
    const handle = answer.type === "done" ? answer.made?.$new : undefined;
    if (editor.answered(answer) !== null || handle === undefined || !editor.model.objects.has(handle)) return;
    if (editor.model.kind(handle).shape !== undefined) editor.canvas.choose(handle, true);
    editor.look(handle);
  }

  /** Begins an arc, at what is chosen. */
  beginArc() {
    const tool = toolsFor(this.editor.model, this.editor.page).find(({ name }) => name === ARC);
    const [source] = this.editor.canvas.chosen();
    if (tool === undefined) return;
    this.take(tool, false);
    if (source !== undefined) this.clicked(source, null);
  }
}
