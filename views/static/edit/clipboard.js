// Copying, cutting and pasting: Python copies elements by their handles, so that nothing is lost on the way.

/** @import { Editor } from "./page.js" */

const STEP = 40; // how far from the original a copy stands, on the same sheet

export class Clipboard {
  /** Handles of what was copied or cut. @type {string[]} */
  elements = [];
  isCut = false;
  times = 0;
  sheet = "";

  /** @param {Editor} editor */
  constructor(editor) {
    this.editor = editor;
  }

  /** @type {(isCut: boolean) => void} */
  copy(isCut) {
    this.elements = this.editor.canvas.chosenShapes();
    Object.assign(this, { isCut, times: 0, sheet: this.page(this.elements) });
    const count = this.elements.length;
    const what = count === 1 ? this.editor.model.label(this.elements[0]) : `${count} elements`;
    this.editor.say(isCut ? `${what}: Ctrl V on another sheet moves it there` : `${what} copied`);
  }

  /** The page at hand; not one that is copied itself. @type {(elements: string[]) => string} */
  page(elements) {
    const { page, model } = this.editor;
    return elements.includes(page) ? model.sheetOf(page) : page;
  }

  async paste() {
    const page = this.page(this.elements);
    if (this.isCut) {
      const operation = { kind: "into", elements: this.elements, page };
      await this.editor.compose(operation, "move into a page", this.elements);
      this.elements = [];
      return;
    }
    this.times = page === this.sheet ? this.times + 1 : 0;
    await this.put(this.elements, this.times * STEP);
  }

  duplicate() {
    return this.put(this.editor.canvas.chosenShapes(), STEP);
  }

  /** @type {(elements: string[], by: number) => Promise<void>} */
  async put(elements, by) {
    const operation = { kind: "copy", elements, owner: this.page(elements), dx: by, dy: by };
    await this.editor.compose(operation, "copy", null);
  }
}
