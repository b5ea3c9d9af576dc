// The form of an element: its attributes, references and parts, as the metamodel describes them.

import { make } from "../../elements.js";
import { fixButton } from "../around.js";
import { clauseHelp } from "./clause.js";
import { inWords, isOffered, optionFor, typesFor } from "./making.js";
import { fieldsOf } from "./token_form.js";

/** @import { Model } from "../model.js" */
/** @import { Command, Feature, Refused, Value } from "../types.js" */

/**
 * What the form asks of the page.
 *
 * @typedef {object} Asked
 * @property {(commands: Command[], label: string) => Promise<string | null>} act does something to the model; answers why not, or null
 * @property {(operation: Command, label: string) => Promise<string | null>} compose does something larger; answers why not, or null
 * @property {(element: string, text: string) => Promise<Refused | null>} clause what is wrong with the text of a clause
 * @property {(element: string) => HTMLElement[]} found says what a check has found at an element
 * @property {(element: string) => void} go shows another element
 * @property {(owner: string, feature: string, type: string, given?: string) => void} make makes an element
 * @property {(element: string) => { isOpen: boolean, toggle: () => void } | null} opening whether a page on the sheet is open in place, and what opens or closes it
 */

/** Parts that are drawn or edited elsewhere. */
const ELSEWHERE = new Set(["graphics", "labels", "toolInfos", "arcs"]);

/**
 * Fills in the form of several elements: what can be done with them.
 *
 * @param {HTMLElement} panel
 * @param {number} count
 * @param {{ words: string, key: string, act: () => unknown }[]} actions
 */
export function showActions(panel, count, actions) {
  panel.replaceChildren(
    make("h2", {}, `${count} elements`),
    make(
      "div",
      { class: "actions", role: "group", "aria-label": "Actions" },
      ...actions.map(({ words, key, act }) =>
        make("button", { onclick: () => act() }, words, key && make("kbd", { "aria-hidden": "true" }, key)),
      ),
    ),
  );
}

/**
 * Fills in the form of an element.
 *
 * @param {HTMLElement} panel
 * @param {Model} model
 * @param {string} element
 * @param {Asked} asked
 */
export function showForm(panel, model, element, asked) {
  const focused = panel.contains(document.activeElement) ? document.activeElement?.id : null;
  const kind = model.kind(element);
  const above = model.get(element).in;
  const marks = model.marksOf(element);
  panel.replaceChildren(
    make("h2", {}, model.label(element)),
    make("p", { class: "quiet", title: [kind.says, ...kind.rules].join("\n") }, kind.words),
    ...(above === undefined ? [] : [make("p", {}, "in ", goTo(model, above, asked))]),
    ...opener(element, asked),
    ...marks.map((mark) =>
      make(
        "p",
        { class: `mark ${mark.severity}`, role: "note" },
        mark.message,
        make("small", {}, mark.fix),
        fixButton(mark, asked.act),
      ),
    ),
    ...asked.found(element),
    make(
      "div",
      { class: "fields" },
      ...kind.features.flatMap((feature) => rowsFor(model, element, feature, asked)),
    ),
    ...offers(model, element, asked),
  );
  if (focused) document.getElementById(focused)?.focus({ preventScroll: true });
}

/** Buttons to see what is in a page: in its frame, or on its own sheet. @type {(element: string, asked: Asked) => HTMLElement[]} */
function opener(element, asked) {
  const opening = asked.opening(element);
  if (opening === null) return [];
  const words = opening.isOpen ? "Close" : "Open in place";
  const toggle = make(
    "button",
    { id: "opening", onclick: opening.toggle },
    words,
    make("kbd", { "aria-hidden": "true" }, "Space"),
  );
  return [
    make(
      "p",
      { class: "opening" },
      toggle,
      make("button", { onclick: () => asked.go(element) }, "Go into it"),
    ),
  ];
}

/** @type {(model: Model, element: string, asked: Asked) => HTMLElement} */
const goTo = (model, element, asked) =>
  make(
    "button",
    { class: "link", onclick: () => asked.go(element), title: model.kind(element).words },
    model.label(element),
  );

/** @type {(model: Model, element: string, feature: Feature, asked: Asked) => HTMLElement[]} */
function rowsFor(model, element, feature, asked) {
  if (feature.kind === "attribute") {
    const fields = feature.name === "data" ? fieldsOf(model, element) : [];
    const rows = fields.map((field) => tokenRow(element, field, asked));
    return [...rows, attribute(model, element, feature, asked)];
  }
  if (feature.kind === "reference")
    return feature.many
      ? [several(model, element, feature, asked)]
      : [reference(model, element, feature, asked)];
  if (model.classOf(feature.type)?.features.some(({ name }) => name === "disjunctions"))
    return [clause(model, element, asked)];
  // What is on sheets is made and seen there.
  const isDrawn = typesFor(model, feature).some((type) => model.classOf(type).shape !== undefined);
  const isKnown =
    model.links(element, feature.name).length > 0 || typesFor(model, feature, element).length > 0;
  if (!isKnown) return [];
  return isDrawn || ELSEWHERE.has(feature.name) ? [] : [parts(model, element, feature, asked)];
}

/**
 * A row with a field; a refused value stays in the field, with the error next to it.
 *
 * @param {Feature} feature
 * @param {HTMLInputElement | HTMLSelectElement | HTMLTextAreaElement} field
 * @param {() => Promise<string | null>} change
 * @param {string} [words] what it is called
 */
function row(feature, field, change, words = inWords(feature.name)) {
  const said = make("span", { class: "said", role: "alert" });
  field.id = `field-${feature.name}`;
  field.title = feature.says;
  field.addEventListener("change", async () => {
    const reason = await change();
    said.textContent = reason ?? "";
    field.setAttribute("aria-invalid", String(reason !== null));
  });
  return make(
    "div",
    { class: "row" },
    make("label", { for: field.id, title: feature.says }, words),
    field,
    said,
  );
}

/** @type {(model: Model, element: string, feature: Feature, asked: Asked) => HTMLElement} */
function attribute(model, element, feature, asked) {
  const value = model.value(element, feature.name);
  const set = (/** @type {Value} */ given) =>
    asked.act(
      [{ kind: "set", element, feature: feature.name, value: given }],
      `${inWords(feature.name)} of ${model.label(element)}`,
    );
  const values = feature.name === "start" ? model.links(element, "values") : [];
  if (values.length) {
    const names = values.map((each) => model.label(each));
    const options = names.map((name) => make("option", { value: name, selected: name === value }, name));
    const choice = make("select", {}, make("option", { value: "" }, `(${names[0]})`), ...options);
    return row(feature, choice, () => set(choice.value || null));
  }
  const literals = model.metamodel.enumerations[feature.type];
  if (literals !== undefined) {
    const options = literals.map(({ name, says }) =>
      make("option", { value: name, title: says, selected: name === value }, name),
    );
    const choice = make("select", {}, ...options);
    return row(feature, choice, () => set(choice.value));
  }
  if (feature.type === "boolean") {
    const box = make("input", { type: "checkbox", checked: value === true });
    return row(feature, box, () => set(box.checked));
  }
  const isNumber = feature.type === "integer" || feature.type === "number";
  const input = make("input", {
    type: isNumber ? "number" : "text",
    value: value === null ? "" : String(value),
    step: feature.type === "number" ? "any" : null,
  });
  return row(feature, input, () => {
    if (input.value === "") return set(null);
    return set(isNumber ? Number(input.value) : input.value);
  });
}

/** What a token carries in one field of its type. @type {(token: string, field: import("./token_form.js").TokenField, asked: Asked) => HTMLElement} */
function tokenRow(token, { name, kind, feature, text }, asked) {
  const fill = (/** @type {string} */ given) =>
    asked.compose(
      { kind: "fill", token, field: name, text: given === "" ? null : given },
      `${name} of a token`,
    );
  if (kind === "boolean") {
    const options = ["", "true", "false"].map((value) =>
      make("option", { value, selected: value === text }, value || "by default"),
    );
    const choice = make("select", {}, ...options);
    return row(feature, choice, () => fill(choice.value), name);
  }
  const input = make("input", { type: "text", value: text, spellcheck: "false" });
  return row(feature, input, () => fill(input.value), name);
}

/** @type {(model: Model, element: string, feature: Feature, asked: Asked) => HTMLElement} */
function reference(model, element, feature, asked) {
  const target = model.link(element, feature.name);
  const none = feature.required ? [] : [make("option", { value: "" }, "none")];
  const options = model.all(feature.type).map((each) => optionFor(model, each, each === target));
  const choice = make("select", {}, ...none, ...options);
  const found = row(feature, choice, () =>
    asked.act(
      [{ kind: "set", element, feature: feature.name, value: choice.value || null }],
      inWords(feature.name),
    ),
  );
  if (target !== null)
    found.append(make("button", { class: "link", onclick: () => asked.go(target) }, "show"));
  return found;
}

/** @type {(model: Model, element: string, feature: Feature, asked: Asked) => HTMLElement} */
function several(model, element, feature, asked) {
  const targets = model.links(element, feature.name);
  const change = (/** @type {string} */ kind, /** @type {string} */ target) =>
    asked.act([{ kind, element, feature: feature.name, target }], inWords(feature.name));
  const others = model.all(feature.type).filter((each) => each !== element && !targets.includes(each));
  const choice = make(
    "select",
    {},
    make("option", { value: "" }, "add…"),
    ...others.map((each) => optionFor(model, each, false)),
  );
  const found = row(feature, choice, () => change("add", choice.value));
  for (const target of targets) {
    const name = model.label(target);
    found.append(
      goTo(model, target, asked),
      make("button", { "aria-label": `remove ${name}`, onclick: () => change("remove", target) }, "×"),
    );
  }
  return found;
}

/** @type {(model: Model, element: string, asked: Asked) => HTMLElement} */
function clause(model, element, asked) {
  const [present] = model.links(element, "clause");
  const text = present === undefined ? "" : String(model.value(present, "text") ?? "");
  const says =
    "A boolean expression over the signals of the ROS node, such as: Button & !Danger & Mode = 'idle'";
  const input = make("input", { type: "text", value: text, spellcheck: "false" });
  const feature = { name: "clause", says, kind: /** @type {const} */ ("part"), type: "sym.InputClause" };
  const found = row(feature, input, () =>
    asked.act(
      [{ kind: "clause", element, text: input.value.trim() || null }],
      `clause of ${model.label(element)}`,
    ),
  );
  const help = clauseHelp(input, model.signalsFor(element), (wanted) => asked.clause(element, wanted));
  found.append(...help);
  if (present !== undefined)
    found.append(make("button", { class: "link", onclick: () => asked.go(present) }, "show"));
  return found;
}

/** @type {(model: Model, element: string, feature: Feature, asked: Asked) => HTMLElement} */
function parts(model, element, feature, asked) {
  const present = model.links(element, feature.name);
  const types = feature.many || present.length === 0 ? typesFor(model, feature, element) : [];
  const buttons = types.map((type) =>
    make(
      "button",
      {
        class: "add",
        title: model.classOf(type).says,
        onclick: () => asked.make(element, feature.name, type),
      },
      `+ ${model.classOf(type).words}`,
    ),
  );
  return make(
    "div",
    { class: "row parts", role: "group", "aria-label": inWords(feature.name) },
    make("span", { class: "label", title: feature.says }, inWords(feature.name)),
    make("ul", {}, ...present.map((part) => make("li", {}, goTo(model, part, asked)))),
    ...buttons,
  );
}

/**
 * What can be made elsewhere that leads here, such as the port of a topic for a place.
 *
 * @type {(model: Model, element: string, asked: Asked) => HTMLElement[]}
 */
function offers(model, element, asked) {
  const { type } = model.get(element);
  const { classes } = model.metamodel;
  const leading = Object.keys(classes).filter(
    (name) =>
      classes[name].made &&
      classes[name].shape === undefined &&
      !model.isA(name, "pn.Arc") &&
      classes[name].features.some(
        (each) => each.kind === "reference" && each.required && model.isA(type, each.type),
      ),
  );
  const rows = leading.flatMap((name) => {
    const owners = [...model.objects.keys()].flatMap((owner) =>
      (isOffered(model, name, owner) ? model.kind(owner) : { features: [] }).features
        .filter((each) => each.kind === "part" && each.many && model.isA(name, each.type))
        .map((each) => ({ owner, feature: each.name })),
    );
    return owners.map(({ owner, feature }) =>
      make(
        "button",
        { class: "add", title: classes[name].says, onclick: () => asked.make(owner, feature, name, element) },
        `+ ${classes[name].words} of ${model.label(owner)}`,
      ),
    );
  });
  return rows.length === 0
    ? []
    : [
        make(
          "div",
          { class: "row parts", role: "group", "aria-label": "connect" },
          make("span", { class: "label" }, "connect"),
          ...rows,
        ),
      ];
}
