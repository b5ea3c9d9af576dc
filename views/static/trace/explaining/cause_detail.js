// Descriptions of causes: where the outcome of a witness may have begun, and what decides it.

import { make } from "../../elements.js";
import { lastAtMost } from "../data.js";

/** @import { Data } from "../data.js" */
/** @import { App } from "../page.js" */

const HINT = "A hint, found from this trace alone: other runs from there may go another way.";

/**
 * Since when, and up to when, a condition was true, in words.
 *
 * @type {(data: Data, since: number, until: number) => string}
 */
function spanText(data, since, until) {
  if (since === until) return `at step ${since + 1}`;
  const from = since < 0 ? "from the start" : `since step ${since + 1}`;
  return until >= data.length - 1 ? `${from}, to the end` : `${from}, up to step ${until + 1}`;
}

/** The button in the head of a trace. @type {(app: App, number: number) => HTMLElement | null} */
export function causeButton(app, number) {
  const data = app.traces[number];
  if (!data.cause) return null;
  const { first, decided } = data.cause;
  const lines = decided.map(([text, since, until]) => `${text}: ${spanText(data, since, until)}`);
  return make(
    "button",
    { class: "cause", title: [...lines, HINT].join("\n"), onclick: () => app.select(first) },
    `first cause? ${first < 0 ? "from the start" : `step ${first + 1}`} `,
    make("kbd", {}, "c"),
  );
}

/** What the detail of a step says of causes. @type {(data: Data, step: number) => HTMLElement | null} */
export function causeOf(data, step) {
  if (!data.cause) return null;
  const { first, decided } = data.cause;
  const last = step === data.length - 1;
  const shown = step === first || last ? decided : decided.filter(([, since]) => since === step);
  const items = shown.map(([text, since, until]) =>
    make("li", {}, make("code", {}, text), ` ${spanText(data, since, until)}`),
  );
  let title = null;
  if (step === first) title = "First cause?";
  else if (last) title = "What decides the outcome";
  else if (shown.length) title = "Decides the outcome";
  let past = null;
  if (data.causal.has(step)) past = "one of the steps that brought the outcome about";
  else if (step >= 0) past = "not needed for the outcome";
  return make(
    "div",
    { class: "causes" },
    title && make("h3", {}, title),
    items.length > 0 && make("ul", {}, ...items),
    past && make("p", { class: "where" }, past),
    step === first && make("p", { class: "where" }, HINT),
  );
}

/**
 * The next step in a direction that is in the causal past, for moving while only these are shown.
 *
 * @type {(data: Data, step: number, direction: number) => number}
 */
export function nextCause(data, step, direction) {
  const steps = data.cause?.steps ?? [];
  const at = direction < 0 ? lastAtMost(steps, step - 1) : lastAtMost(steps, step) + 1;
  return steps[at] ?? step;
}
