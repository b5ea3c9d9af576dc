// The token game: Python fires the net that is proved; the page shows what that is on the model, and asks for more.

import { byId } from "../../elements.js";
import { askWhich } from "../forms/dialogs.js";
import { showGame } from "./play_panel.js";

/** @import { Editor } from "../page.js" */
/** @import { Done, Firing, Game, Refused } from "../types.js" */

const LARGEST_TRACE = 900_000; // characters: what Python listens to at once is 1 MiB

/** How a game continues by itself. @typedef {"steps" | "random"} Way */

export class Player {
  /** @type {Game | null} */
  game = null;
  /** @type {Way | null} */
  running = null;
  /** Steps a second. */
  speed = 2;
  /** Whether what is fired along known steps is shown wherever it is. */
  isFollowing = true;
  /** When signals may change, as `dineros find --signals` has it. */
  signals = "fully-enabled";

  /** @param {Editor} editor */
  constructor(editor) {
    this.editor = editor;
    byId("play", HTMLElement).onclick = () => this.toggle();
  }

  /** Whether the model is another one than when the game began. */
  get isStale() {
    const { model } = this.editor;
    return this.game !== null && (this.game.epoch !== model.epoch || this.game.revision !== model.revision);
  }

  toggle() {
    if (this.game === null) this.begin();
    else this.end();
  }

  begin() {
    return this.ask({ action: "begin", signals: this.signals });
  }

  async end() {
    this.running = null;
    await this.editor.connection.ask("play", { action: "end" });
    this.take(null);
    byId("play", HTMLElement).focus();
  }

  /** Plays what files say: a witness, or the traces of all nodes of a run. @type {(files: Iterable<File>) => Promise<void>} */
  async open(files) {
    const read = await Promise.all([...files].map(async (file) => [file.name, await file.text()]));
    await this.openTexts(Object.fromEntries(read));
  }

  /** @type {(traces: Record<string, string>) => Promise<void>} */
  async openTexts(traces) {
    const size = Object.values(traces).reduce((sum, text) => sum + text.length, 0);
    if (size > LARGEST_TRACE) {
      this.editor.say(
        "these traces are too long to be played in the editor: use dineros trace to show them",
        true,
      );
      return;
    }
    this.running = null;
    await this.ask({ action: "open", traces });
  }

  /** @type {(transition: string) => Promise<void>} */
  async fire(transition) {
    if (this.game !== null) await this.ask({ action: "fire", transition, at: this.game.at });
  }

  /** @type {(to: number) => Promise<void>} */
  async go(to) {
    if (this.game === null || to < 0 || to > this.game.length) return;
    await this.ask({ action: "go", to });
    this.follow();
  }

  back() {
    this.running = null;
    return this.go((this.game?.at ?? 0) - 1);
  }

  forward() {
    this.running = null;
    return this.go((this.game?.at ?? 0) + 1);
  }

  /** Goes on by itself, or no more. @type {(way: Way) => Promise<void>} */
  async run(way) {
    const isOn = this.running !== way;
    this.running = isOn ? way : null;
    this.show();
    while (this.running === way && this.game !== null && !this.isStale) {
      const before = this.game;
      const count = Math.max(1, Math.round(this.speed / 10));
      if (way === "random") await this.ask({ action: "wander", count, at: before.at });
      else await this.go(this.next(before, count));
      if (this.game?.at === before.at) break; // nothing is enabled, or there are no more steps
      await new Promise((settle) => setTimeout(settle, (1000 * count) / this.speed));
    }
    if (this.running === way) this.running = null;
    this.show();
  }

  /** Which step is next; what repeats forever begins again. @type {(game: Game, count: number) => number} */
  next({ at, length, loop }, count) {
    if (at < length) return Math.min(length, at + count);
    return loop === null ? at : Math.min(length, loop + count);
  }

  /** Asks for something and shows what came of it; what will come is waited for. @type {(what: Record<string, unknown>, willCome?: boolean) => Promise<void>} */
  async ask(what, willCome = false) {
    const answer = await this.editor.connection.ask("play", what);
    if (answer.type === "refused") {
      this.running = null;
      if (willCome) this.editor.say(`${answer.reason} yet`);
      else this.editor.answered(answer);
      this.show();
      return;
    }
    this.editor.say("");
    this.take(answer.game ?? null);
  }

  /** @type {(game: Game | null) => void} */
  take(game) {
    const isOther = (this.game === null) !== (game === null);
    this.game = game;
    this.editor.model.played = game;
    if (isOther) this.editor.show(this.editor.canvas.sheet);
    else this.editor.canvas.draw();
    this.show();
  }

  /** Shows the sheet where the last step was. */
  follow() {
    const { model, canvas } = this.editor;
    const last = this.game?.steps[this.game.at - 1 - this.game.first];
    if (!this.isFollowing || last === undefined) return;
    const known = last.elements.filter((each) => model.objects.has(each));
    if (known.length === 0 || known.some((each) => canvas.planes.has(model.sheetOf(each)))) return;
    this.editor.show(model.sheetOf(known[0]));
  }

  show() {
    const { game, editor } = this;
    const isOn = game !== null;
    document.body.dataset.game = isOn ? (this.isStale ? "stale" : (this.running ?? "on")) : "off";
    byId("play", HTMLElement).setAttribute("aria-pressed", String(isOn));
    byId("game", HTMLElement).hidden = !isOn;
    for (const id of ["form", "tools"]) byId(id, HTMLElement).hidden = isOn;
    if (game !== null) showGame(byId("game", HTMLElement), this, game);
    for (const id of ["arrange", "undo", "redo"]) {
      if (isOn) byId(id, HTMLButtonElement).disabled = true;
    }
    if (!isOn) {
      byId("arrange", HTMLButtonElement).disabled = false;
      editor.showState();
    }
  }

  /** Fires what a click on an element stands for; whether it stands for anything. @type {(element: string | null) => boolean} */
  clicked(element) {
    if (element === null || this.game === null) return false;
    const found = this.game.firings.filter(({ elements }) => elements.includes(element));
    if (found.length === 1) this.fire(found[0].id);
    else if (found.length > 1) this.choose(found);
    return found.length > 0;
  }

  /** Asks which of several firings is meant. @type {(firings: Firing[]) => void} */
  choose(firings) {
    askWhich(
      "Which one?",
      firings.map(({ id, text }) => ({ words: text, act: () => this.fire(id) })),
    );
  }
}

/** What stops a change of the model while it is played. @type {(number: number) => Done | Refused} */
export const refusedInGame = (number) => ({
  type: "refused",
  number,
  reason: "a game is on",
  hint: "end it, by p, to change the model",
});
