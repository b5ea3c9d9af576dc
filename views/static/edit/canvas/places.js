// Places of elements that have none yet: Python lays pages out, one at a time.

import { moveTo } from "./canvas.js";

/** @import { Editor } from "../page.js" */
/** @import { Command, Point } from "../types.js" */

export class Places {
  /** What has been asked where to put, by page. @type {Map<string, string>} */
  asked = new Map();

  /** @param {Editor} editor */
  constructor(editor) {
    this.editor = editor;
  }

  forget() {
    this.asked.clear();
    this.editor.canvas.computed.clear();
  }

  /** Asks for places of elements that have none, on the sheet and the pages that are open on it. */
  async find() {
    const { canvas } = this.editor;
    const { sheet } = canvas;
    const wanted = [...canvas.planes.keys()].filter((page) => this.isMissing(page));
    if (wanted.length === 0) return;
    for (const page of wanted) {
      const found = await this.positions(page);
      if (found === null) continue;
      canvas.computed.set(page, found);
      canvas.openPages.centre(page);
    }
    if (canvas.sheet !== sheet) return;
    canvas.draw();
    if (wanted.includes(sheet)) canvas.fit();
  }

  /** Whether an element of a page has no place, and none was requested. @type {(page: string) => boolean} */
  isMissing(page) {
    const { canvas } = this.editor;
    const loose = canvas.settled(page).map(({ element }) => String(element));
    const missing = loose.filter((each) => !canvas.computed.get(page)?.has(each));
    const key = missing.join(" ");
    if (missing.length === 0 || this.asked.get(page) === key) return false;
    this.asked.set(page, key);
    return true;
  }

  /** @type {(page: string) => Promise<Map<string, Point> | null>} */
  async positions(page) {
    const query = new URLSearchParams(location.search);
    query.set("sheet", page);
    document.body.dataset.busy = "arranging";
    const answer = await fetch(`/arrange?${query}`);
    /** @type {Record<string, [number, number]> | undefined} */
    const found = answer.ok ? (await answer.json()).positions : undefined;
    delete document.body.dataset.busy;
    if (found === undefined) return null;
    return new Map(Object.entries(found).map(([handle, [x, y]]) => [handle, { x, y }]));
  }

  /** Puts everything on the page at hand where it can be read. */
  async arrange() {
    const { editor } = this;
    const { canvas, model, page } = editor;
    const found = await this.positions(page);
    if (found === null) {
      editor.say("this sheet cannot be laid out", true);
      return;
    }
    /** @type {Command[]} */
    const commands = [...found].map(([element, point]) => moveTo(element, point));
    const bent = canvas.registry.filter(
      ({ business }) => business?.page === page && business.bends.length > 0,
    );
    commands.push(...bent.map(({ business }) => ({ kind: "bend", element: business.element, points: [] })));
    canvas.openPages.centre(page);
    await editor.act(commands, `arrange ${model.label(page)}`);
    if (page === canvas.sheet) canvas.fit();
  }
}
