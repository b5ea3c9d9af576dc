// What other processes do for this page: checks, questions, generating, running; asked for here, shown as they go.

import { byId, make } from "../../elements.js";
import { completing } from "../forms/complete.js";
import { askForm } from "../forms/dialogs.js";
import { showFinding, showJob } from "./work_panel.js";

/** @import { Editor } from "../page.js" */
/** @import { Job, Message } from "../types.js" */

const WATCH = 1000; // milliseconds between two looks at a run, at least; more where a look takes its time
const LONGEST_WATCH = 5000;
const IDLE = 2000; // milliseconds without a change after which the model is checked, where that is wanted

/** The questions, and the fields of `views/editing/working/orders.py` that they are asked by. */
const QUESTIONS = {
  marking: { kind: "find", words: "find a marking", example: "Noted >= 2" },
  enabled: { kind: "find", words: "find a way to fire", example: "TShow" },
  ltl: { kind: "verify", words: "verify LTL", example: "G F fired(TShow)" },
  ctl: { kind: "verify", words: "verify CTL", example: "AG EF (Noted >= 2)" },
};
const ATOMS = ["enabled()", "fired()", "signal()", "deadlock"];
const SIGNALS = ["input-enabled", "fully-enabled", "io-enabled", "none"];

export class Worker {
  /** @type {Map<number, Job>} */
  jobs = new Map();
  /** @type {ReturnType<typeof setTimeout> | undefined} */
  timer;
  /** The run that is shown on the canvas while it continues. @type {number | null} */
  watched = null;

  /** @param {Editor} editor */
  constructor(editor) {
    this.editor = editor;
    this.question = make("input", { id: "question", "aria-label": "Question", size: 34 });
    this.which = make(
      "select",
      { "aria-label": "Kind of question" },
      ...Object.entries(QUESTIONS).map(([name, { words }]) => make("option", { value: name }, words)),
    );
    this.signals = make(
      "select",
      { "aria-label": "Signals", title: "When signals may change" },
      ...SIGNALS.map((name) => make("option", { value: name }, `signals ${name}`)),
    );
    this.seconds = make("input", {
      type: "number",
      min: 1,
      max: 86400,
      value: 60,
      "aria-label": "Seconds at most",
    });
    this.idle = make("input", { type: "checkbox" });
    this.build();
  }

  build() {
    const check = make(
      "button",
      { id: "check", title: "Check everything (c)", onclick: () => this.check() },
      "Check",
    );
    this.idle.onchange = () => this.wait();
    const ask = make("button", {}, "Ask");
    const form = make(
      "form",
      { role: "search", "aria-label": "Questions" },
      this.which,
      make("span", { class: "completing" }, this.question, this.completion()),
      this.signals,
      ask,
    );
    form.onsubmit = (event) => {
      event.preventDefault();
      this.ask();
    };
    const suggest = () => {
      this.question.placeholder = QUESTIONS[this.chosen()].example;
    };
    this.which.onchange = suggest;
    suggest();
    byId("orders", HTMLElement).replaceChildren(
      check,
      make("label", {}, this.idle, " whenever I pause"),
      form,
      make("label", {}, "within ", this.seconds, " s"),
      make("button", { onclick: () => this.askGenerate() }, "Generate…"),
      make("button", { onclick: () => this.askRun() }, "Run…"),
    );
  }

  /** @returns {keyof typeof QUESTIONS} */
  chosen() {
    return /** @type {keyof typeof QUESTIONS} */ (this.which.value);
  }

  /** Names that formulas know. @returns {string[]} */
  names() {
    const { model } = this.editor;
    const types = ["pn.Place", "pn.Transition", "sym.InputSignal"];
    const known = types.filter((type) => model.classOf(type) !== undefined);
    const ids = known.flatMap((type) => model.all(type)).map((each) => String(model.value(each, "id")));
    return [...new Set(ids), ...ATOMS];
  }

  /** The list of names that fit what is typed in the question. */
  completion() {
    return completing(this.question, {
      id: "question-names",
      label: "Names",
      word: /[A-Za-z_][\w.[\]-]*$/,
      fitting: (typed) => {
        const word = typed.toLowerCase();
        const holds = this.names().filter((name) => name.toLowerCase().includes(word));
        const begins = holds.filter((name) => name.toLowerCase().startsWith(word));
        const found = [...begins, ...holds.filter((name) => !begins.includes(name))];
        return found.length === 1 && found[0].toLowerCase() === word ? [] : found;
      },
      first: -1,
    });
  }

  // ---------------------------------------------------------------------------------- what Python says

  /** @type {(message: Message) => void} */
  hear(message) {
    if (message.type === "snapshot") this.jobs = new Map(message.jobs.map((job) => [job.job, job]));
    if (message.type === "job") {
      const known = this.jobs.get(message.job);
      this.jobs.set(message.job, message);
      const isGoing = ["running", "ending"].includes(message.state);
      const isOver = known !== undefined && ["running", "ending"].includes(known.state) && !isGoing;
      if (isOver) this.editor.say(`${message.words}: ${message.state}`, message.state === "failed");
    }
    if (message.type === "change") this.wait();
    this.show();
  }

  /** What the last check found at an element, in this state of the model. @type {(element: string) => HTMLElement[]} */
  foundAt(element) {
    const last = this.lastCheck();
    if (last === undefined) return [];
    const found = this.editor.model.findings.filter(({ elements }) => elements.includes(element));
    return found.map((each) => showFinding(this, last, each));
  }

  /** The last check that was answered. */
  lastCheck() {
    const all = [...this.jobs.values()].sort((one, other) => other.job - one.job);
    return all.find(({ kind, state }) => kind === "check" && state === "done");
  }

  /** Whether what a job says is of an earlier state of the model. @type {(job: Job) => boolean} */
  isStale({ epoch, revision }) {
    return epoch !== this.editor.model.epoch || revision !== this.editor.model.revision;
  }

  show() {
    const { model, canvas } = this.editor;
    const all = [...this.jobs.values()].sort((one, other) => other.job - one.job);
    const last = this.lastCheck();
    const findings = last === undefined || this.isStale(last) ? [] : (last.result.findings ?? []);
    if (findings.length + model.findings.length > 0) {
      model.findings = findings;
      if (canvas.sheet) canvas.describe();
      const form = byId("form", HTMLElement);
      if (canvas.sheet && !form.contains(document.activeElement)) this.editor.showForm();
    }
    const running = all.filter(({ state }) => state === "running");
    byId("working", HTMLElement).textContent =
      running.length > 0
        ? running.map(({ words, at }) => `${words}${at ? `: ${at}` : "…"}`).join("; ")
        : "Check, ask, generate, run";
    document.body.dataset.working = String(running.length);
    this.showJobs(all);
  }

  /** Draws the list again; what was open stays open, and what had the focus keeps it. @type {(all: Job[]) => void} */
  showJobs(all) {
    const list = byId("jobs", HTMLElement);
    const open = new Set(
      [...list.querySelectorAll("details.log[open]")].map((each) => each.closest("li[id]")?.id),
    );
    const focused = document.activeElement;
    const [inside, name] = [focused?.closest("#jobs > li")?.id, nameOf(focused)];
    list.replaceChildren(...all.map((job) => showJob(this, job, open.has(`job-${job.job}`))));
    if (inside === undefined) return;
    const again = [...(document.getElementById(inside)?.querySelectorAll("button, a, summary") ?? [])];
    const same = again.find((each) => nameOf(each) === name);
    if (same instanceof HTMLElement) same.focus();
  }

  // ---------------------------------------------------------------------------------- what people do

  /** Has something done. @type {(order: Record<string, unknown>) => Promise<void>} */
  async start(order) {
    byId("work", HTMLDetailsElement).open = true;
    this.editor.answered(await this.editor.connection.ask("work", { action: "start", order }), false);
  }

  /** @type {(job: number) => Promise<void>} */
  async cancel(job) {
    this.editor.answered(await this.editor.connection.ask("work", { action: "cancel", job }), false);
  }

  focus() {
    byId("work", HTMLDetailsElement).open = true;
    this.question.focus();
  }

  check() {
    return this.start({ kind: "check", timeout: Number(this.seconds.value) });
  }

  /** Checks when nothing has changed for a while, where that is wanted. */
  wait() {
    clearTimeout(this.timer);
    if (!this.idle.checked) return;
    this.timer = setTimeout(() => {
      if (this.editor.model.marks.errors === 0) this.check();
    }, IDLE);
  }

  async ask() {
    const which = this.chosen();
    const order = { kind: QUESTIONS[which].kind, [which]: this.question.value };
    await this.start({ ...order, signals: this.signals.value, timeout: Number(this.seconds.value) });
  }

  /** Plays what a job has left: of a finding, or all of a run. @type {(job: number, witness: number | null) => Promise<void>} */
  async play(job, witness) {
    await this.editor.player.ask({ action: "open", job, witness });
  }

  /** Shows a run on the canvas while it continues, or no more. @type {(job: number) => Promise<void>} */
  async watch(job) {
    this.watched = this.watched === job ? null : job;
    this.show();
    const { player } = this.editor;
    while (this.watched === job && this.jobs.get(job)?.state === "running") {
      const begun = performance.now();
      await player.ask({ action: "open", job }, player.game === null); // it may have done nothing yet
      if (player.game !== null) await player.ask({ action: "go", to: player.game.length });
      const took = performance.now() - begun;
      await new Promise((settle) => setTimeout(settle, Math.min(Math.max(WATCH, 4 * took), LONGEST_WATCH)));
    }
    if (this.watched === job) this.watched = null;
    this.show();
  }

  /** Saves what is not saved: what is generated and run is the file. */
  async saved() {
    if (!this.editor.model.state.saved) await this.editor.save(false);
    return this.editor.model.state.saved;
  }

  askGenerate() {
    const workspace = make("input", { value: "workspace", required: true, name: "workspace" });
    this.form(
      "Generate a workspace",
      "A ROS 2 workspace in a folder next to the model. What would change is shown first.",
      [make("label", {}, "folder", workspace)],
      "Show",
      () => ({ kind: "generate", workspace: workspace.value }),
    );
  }

  askRun() {
    const how = make(
      "select",
      { name: "how" },
      make("option", { value: "simulate" }, "simulated: in simulated time"),
      make("option", { value: "local" }, "local: in one process"),
      make("option", { value: "ros" }, "ROS 2: a process for each node"),
      make("option", { value: "workspace" }, "ROS 2: a generated workspace"),
    );
    const workspace = make("input", { value: "workspace", name: "workspace" });
    const until = make("input", { id: "until", name: "until", placeholder: "Noted >= 3" });
    const timeout = make("input", { type: "number", min: 1, max: 86400, value: 60, name: "timeout" });
    const speed = make("input", {
      type: "number",
      min: 0.1,
      step: "any",
      placeholder: "as fast as can be",
      name: "speed",
    });
    const suit = () => {
      speed.disabled = how.value !== "simulate";
      workspace.disabled = how.value !== "workspace";
    };
    how.onchange = suit;
    suit();
    this.form(
      "Run the application",
      "With the handlers next to the model, or those in the workspace. The run is recorded, and can be played afterwards.",
      [
        make("label", {}, "how", how),
        make("label", {}, "until", until),
        make("label", {}, "at most, in s", timeout),
        make("label", {}, "simulated speed", speed),
        make("label", {}, "workspace", workspace),
      ],
      "Run",
      () => ({
        kind: "run",
        how: how.value === "workspace" ? "ros" : how.value,
        until: until.value,
        timeout: Number(timeout.value),
        ...(workspace.disabled ? {} : { workspace: workspace.value }),
        ...(speed.value && !speed.disabled ? { speed: Number(speed.value) } : {}),
      }),
    );
  }

  /** @type {(title: string, says: string, rows: HTMLElement[], button: string, read: () => Record<string, unknown>) => void} */
  form(title, says, rows, button, read) {
    askForm({ title, says, rows, button }, async () => {
      const order = read();
      if (await this.saved()) await this.start(order);
    });
  }
}

/** @type {(element: Element | null) => string} */
const nameOf = (element) => element?.getAttribute("aria-label") ?? element?.textContent ?? "";
