// What stands around the canvas: the path to the sheet, the state of the file, the list of problems.

import { counted } from "../counting.js";
import { byId, make } from "../elements.js";

/** @import { Model } from "./model.js" */
/** @import { Command, Mark } from "./types.js" */

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

/** What to do first, where a sheet is empty. @type {(model: Model, sheet: string, isEmpty: boolean, insert: () => void) => void} */
export function showHint(model, sheet, isEmpty, insert) {
  const hint = byId("hint", HTMLElement);
  hint.hidden = !isEmpty;
  if (!isEmpty) return;
  const isRoot = sheet === model.root && model.metamodel.templates.length > 0;
  hint.replaceChildren(
    make("p", {}, isRoot ? "This model is empty." : `The sheet of ${model.label(sheet)} is empty.`),
    make("p", {}, "Choose a tool on the left, then click here."),
    ...(isRoot
      ? [
          make(
            "p",
            {},
            "Or begin with an example: ",
            make("button", { onclick: insert }, "Insert a template"),
          ),
        ]
      : [
          make(
            "p",
            {},
            "An arc joins a place and a transition: choose one of them and press ",
            make("kbd", {}, "a"),
            ".",
          ),
        ]),
  );
}

/** A button that fixes what is wrong, where commands do. @type {(mark: Mark, act: (commands: Command[], label: string) => void) => HTMLElement | null} */
export function fixButton({ fixedBy, message }, act) {
  if (fixedBy === undefined) return null;
  const { label, commands } = fixedBy;
  return make(
    "button",
    {
      class: "fix",
      "aria-label": `Fix: ${label} (${message})`,
      onclick: () => act(commands, `fix: ${label}`),
    },
    `Fix: ${label}`,
  );
}

/** @type {(model: Model, go: (element: string) => void, act: (commands: Command[], label: string) => void) => void} */
export function showMarks(model, go, act) {
  const { errors, warnings, marks } = model.marks;
  byId("count", HTMLElement).textContent =
    errors + warnings === 0 ? "No problems" : `${counted(errors, "error")}, ${counted(warnings, "warning")}`;
  byId("marks", HTMLElement).replaceChildren(
    ...marks.map((mark) => {
      const { element, severity, message, fix } = mark;
      return make(
        "li",
        { class: severity },
        make("button", { onclick: () => element !== null && go(element) }, `${message} (${fix})`),
        fixButton(mark, act),
      );
    }),
  );
}
