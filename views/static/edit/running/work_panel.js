// How a job is shown: what it is, how far, what came of it, and what can be done with that.

import { counted } from "../../counting.js";
import { make } from "../../elements.js";

/** @import { Finding, Job } from "../types.js" */
/** @import { Worker } from "./work.js" */

const MOST_FILES = 200; // of a comparison
const PAGE = /http:\/\/(127\.0\.0\.1|localhost):\d+\/\?token=[\w-]+/;

const STATES = { running: "…", ending: "ending…", done: "", failed: "failed", cancelled: "cancelled" };

/** @type {(worker: Worker, job: Job, isOpen: boolean) => HTMLElement} */
export function showJob(worker, job, isOpen) {
  const isStale = worker.isStale(job);
  return make(
    "li",
    { id: `job-${job.job}`, class: `job ${job.state}${isStale ? " old" : ""}`, "data-state": job.state },
    make(
      "div",
      { class: "head" },
      make("b", { title: job.line }, job.words),
      make("span", {}, STATES[job.state], job.state === "running" ? ` ${job.at}` : ""),
      isStale && make("em", { class: "quiet" }, "of an earlier state of the model"),
      job.state === "running" &&
        make(
          "button",
          { onclick: () => worker.cancel(job.job), "aria-label": `Cancel ${job.words}` },
          "Cancel",
        ),
      ...live(worker, job),
    ),
    ...outcome(worker, job, isStale),
    job.log.length > 0 &&
      make(
        "details",
        { class: "log", open: isOpen || job.state === "failed" },
        make("summary", {}, "Log"),
        make("pre", {}, [`$ ${job.line}`, ...job.log].join("\n")),
      ),
  );
}

/** What can be seen of a run while it continues: here, and on a page of its own. @type {(worker: Worker, job: Job) => HTMLElement[]} */
function live(worker, { job, state, log }) {
  const found = state === "running" ? log.map((line) => PAGE.exec(line)?.[0]).find(Boolean) : undefined;
  if (found === undefined) return [];
  const isOn = worker.watched === job;
  return [
    make(
      "button",
      { "aria-pressed": String(isOn), "aria-label": "Watch the run here", onclick: () => worker.watch(job) },
      "Watch",
    ),
    make("a", { href: found, target: "_blank", rel: "noopener" }, "follow and steer it"),
  ];
}

/** @type {(worker: Worker, job: Job, isStale: boolean) => HTMLElement[]} */
function outcome(worker, job, isStale) {
  const { result, kind } = job;
  if (Object.keys(result).length === 0) return [];
  if (kind === "check") return checked(worker, job, isStale);
  if (kind === "generate") return compared(worker, job, isStale);
  if (kind === "run") return ran(worker, job, isStale);
  const reason = result.reason ? `: ${result.reason}` : "";
  const said = make(
    "p",
    { class: result.status },
    `${result.status}${reason}${result.by ? ` (${result.by})` : ""}`,
  );
  if (result.witness) said.append(" ", player(worker, job, isStale, result.witness, "how"));
  return [said];
}

/** @type {(worker: Worker, job: Job, isStale: boolean, witness: number | null, words: string) => HTMLElement} */
const player = (worker, job, isStale, witness, words) =>
  make(
    "button",
    {
      disabled: isStale,
      "aria-label": `Play ${words}`,
      onclick: () => worker.play(job.job, witness),
    },
    "Play",
  );

/** @type {(worker: Worker, job: Job, isStale: boolean) => HTMLElement[]} */
function checked(worker, job, isStale) {
  const { findings = [], proved = [], unknown = [] } = job.result;
  const items = [
    ...findings.map((each) => found(worker, job, isStale, each)),
    ...unknown.map((each) => make("li", { class: "unknown" }, `unknown: ${each}`)),
  ];
  if (items.length === 0) items.push(make("li", {}, "nothing found"));
  return [
    make("ul", { class: "findings" }, ...items),
    make(
      "details",
      {},
      make("summary", {}, `${proved.length} proved`),
      make("ul", {}, ...proved.map((each) => make("li", {}, each))),
    ),
  ];
}

/** @type {(worker: Worker, job: Job, isStale: boolean, finding: Finding) => HTMLElement} */
function found(worker, job, isStale, { severity, message, elements, witness, rule }) {
  const { editor } = worker;
  const at = elements.find((each) => editor.model.objects.has(each));
  return make(
    "li",
    { class: severity === "note" ? "remark" : severity },
    make("span", { title: rule }, `${severity}: ${message} `),
    at !== undefined &&
      make(
        "button",
        { onclick: () => editor.go(at), "aria-label": `Show ${editor.model.label(at)}` },
        "Show",
      ),
    witness !== null && player(worker, job, isStale, witness, message),
  );
}

/** A finding in the form of an element. @type {(worker: Worker, job: Job, finding: Finding) => HTMLElement} */
export const showFinding = (worker, job, { severity, message, witness }) =>
  make(
    "p",
    { class: `mark ${severity === "note" ? "remark" : severity}`, role: "note" },
    `check: ${message} `,
    witness !== null && player(worker, job, worker.isStale(job), witness, message),
  );

/** @type {(worker: Worker, job: Job, isStale: boolean) => HTMLElement[]} */
function compared(worker, job, isStale) {
  const { changes = [], edits = [], notices = [], written, stale } = job.result;
  const workspace = job.words.replace(/^.* /, "");
  const write = () => worker.start({ kind: "generate", workspace, write: true });
  const said = written
    ? `${counted(changes.length, "file")} written`
    : stale
      ? `${counted(changes.length, "file")} would change`
      : "nothing would change";
  return [
    make(
      "p",
      {},
      `${said} `,
      !written && stale && make("button", { disabled: isStale, onclick: write }, "Write them"),
    ),
    make(
      "details",
      { open: !written && changes.length < 20 },
      make("summary", {}, "Files"),
      make(
        "ul",
        { class: "files" },
        ...edits.map(({ file, message }) => make("li", { class: "error" }, `${file}: ${message}`)),
        ...changes
          .slice(0, MOST_FILES)
          .map(({ file, what, detail }) => make("li", {}, `${what}: ${file}${detail ? `: ${detail}` : ""}`)),
        ...notices.map((each) =>
          make("li", { class: "quiet" }, typeof each === "string" ? each : Object.values(each).join(": ")),
        ),
      ),
    ),
  ];
}

/** @type {(worker: Worker, job: Job, isStale: boolean) => HTMLElement[]} */
function ran(worker, job, isStale) {
  const { ending, firings = 0, drops = 0, errors = 0, marking = {}, traces } = job.result;
  const tokens = Object.entries(marking).map(([place, count]) => `${place} ${count}`);
  return [
    make(
      "p",
      {},
      `${ending}: ${counted(firings, "firing")}, ${counted(drops, "drop")}, ${counted(errors, "error")}; marked: ${tokens.join(", ") || "nothing"} `,
      traces && player(worker, job, isStale, null, "the run"),
    ),
  ];
}
