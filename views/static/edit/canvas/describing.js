// Descriptions of drawn elements: a role and a name for screen readers, and visible marks.

import { counted } from "../../counting.js";
import { inShort } from "./drawing.js";

/** @import { Model } from "../model.js" */
/** @import { CanvasElement } from "../types.js" */

/** What was said of graphics last. @type {WeakMap<SVGGElement, string>} */
const described = new WeakMap();

/**
 * Gives all that is drawn a role, a name, a place in the order of Tab, and its mark.
 *
 * @param {Model} model
 * @param {CanvasElement[]} drawn
 * @param {(element: CanvasElement) => SVGGElement} graphicsOf
 */
export function describe(model, drawn, graphicsOf) {
  const seen = new Set(drawn.map(({ business }) => business.element));
  // What is not seen is marked at the closed page that it is in.
  const seenAt = (/** @type {string} */ element) => model.around(element).find((up) => seen.has(up));
  /** @type {Map<string | undefined, string>} */
  const worst = new Map();
  const marks = model.marks.marks.map(({ at, severity }) => ({ at: at ?? "", severity }));
  const findings = model.findings.filter(({ severity }) => severity !== "note");
  for (const { at, severity } of [
    ...marks,
    ...findings.map(({ elements, severity }) => ({ at: elements[0] ?? "", severity })),
  ]) {
    const up = seenAt(at);
    if (worst.get(up) !== "error") worst.set(up, severity);
  }
  const { enabled, fired } = played(model, seenAt);
  for (const element of drawn) {
    const { business } = element;
    const graphics = graphicsOf(element);
    const mark = worst.get(business.element);
    const ends =
      element.waypoints === undefined
        ? ""
        : ` from ${element.source.business.title} to ${element.target.business.title}`;
    const isEnabled = enabled.has(business.element) && element.waypoints === undefined;
    const count = business.tokens ? `, ${counted(business.tokens, "token")}` : "";
    const { words } = model.kind(business.element);
    // What can be read on a shape is in its name, for those who speak to the page (WCAG 2, 2.5.3).
    const read = /^(place|transition)/.test(business.kind) ? [] : (business.lines ?? []);
    const name = [business.title, ...read, ...(business.ports ?? []).map(inShort)].join(", ");
    const state = `${mark ? `, ${mark}` : ""}${isEnabled ? ", enabled" : ""}`;
    const place = business.depth > 0 ? `, in ${model.label(business.page)}` : "";
    const says = `${words} ${name}${ends}${count}${place}${state}`;
    graphics.classList.toggle("is-enabled", isEnabled);
    graphics.classList.toggle("is-fired", fired.has(business.element) && element.waypoints === undefined);
    graphics.classList.toggle("has-error", mark === "error");
    graphics.classList.toggle("has-warning", mark === "warning");
    const key = `${business.element} ${says} ${business.isOpen}`;
    if (described.get(graphics) === key) continue;
    described.set(graphics, key);
    if (business.isPage) graphics.setAttribute("aria-expanded", String(business.isOpen));
    graphics.setAttribute("role", "button");
    graphics.setAttribute("tabindex", "0");
    graphics.dataset.element = business.element;
    graphics.setAttribute("aria-label", says);
  }
}

/** What can be fired in the game that is played, and what was fired last, where it is seen. @type {(model: Model, seenAt: (element: string) => string | undefined) => { enabled: Set<string | undefined>, fired: Set<string | undefined> }} */
function played(model, seenAt) {
  const game = model.played;
  const last = game?.steps[game.at - 1 - game.first];
  const firings = (game?.firings ?? []).filter(({ kind }) => kind !== "signal");
  return {
    enabled: new Set(firings.flatMap(({ elements }) => elements.map(seenAt))),
    fired: new Set((last?.elements ?? []).map(seenAt)),
  };
}
