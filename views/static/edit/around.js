// What stands around the canvas: the path to the sheet, the state of the file, the list of problems.

import { byId, make } from "../elements.js";

/** @import { Model } from "./model.js" */

/** @type {(model: Model, sheet: string, go: (element: string) => void) => void} */
export function showPath(model, sheet, go) {
  const above = [];
  for (let at = sheet; ; at = model.get(at).in ?? "") {
    above.unshift(at);
    if (at === model.root) break;
  }
  byId("path", HTMLElement).replaceChildren(
    ...above.map((each) =>
      make(
        "button",
        { onclick: () => go(each), "aria-current": each === sheet ? "page" : null },
        model.label(each),
      ),
    ),
  );
}

/** @type {(model: Model, reload: () => void, save: () => void) => void} */
export function showState(model, reload, save) {
  const { saved, undo, redo, disk } = model.state;
  byId("saved", HTMLElement).textContent = saved ? "saved" : "not saved";
  const buttons = [byId("undo", HTMLButtonElement), byId("redo", HTMLButtonElement)];
  for (const [button, label] of /** @type {const} */ ([
    [buttons[0], undo],
    [buttons[1], redo],
  ])) {
    button.disabled = label === null;
    button.title = label ?? "";
  }
  const banner = byId("banner", HTMLElement);
  banner.hidden = disk !== "changed" && disk !== "gone";
  if (banner.hidden) return;
  const compare = `/compare${location.search}`;
  banner.replaceChildren(
    disk === "gone" ? "The file is gone; saving writes it again." : "Somebody else has changed the file.",
    ...(disk === "gone"
      ? []
      : [
          make("a", { href: compare, target: "_blank", rel: "noopener" }, "Compare"),
          make("button", { onclick: () => reload() }, "Take theirs"),
          make("button", { onclick: () => save() }, "Save mine over it"),
        ]),
  );
}

/** @type {(model: Model, go: (element: string) => void) => void} */
export function showMarks(model, go) {
  const { errors, warnings, marks } = model.marks;
  byId("count", HTMLElement).textContent =
    errors + warnings === 0 ? "No problems" : `${errors} errors, ${warnings} warnings`;
  byId("marks", HTMLElement).replaceChildren(
    ...marks.map(({ element, severity, message, fix }) =>
      make(
        "li",
        { class: severity },
        make("button", { onclick: () => element !== null && go(element) }, `${message} (${fix})`),
      ),
    ),
  );
}
