// Making elements: which can be made where, and a form for what they cannot be without; all by the metamodel.

import { make } from "../../elements.js";
import { askForm } from "./dialogs.js";

/** @import { Model } from "../model.js" */
/** @import { Command, Feature, Value } from "../types.js" */

/** Whether objects of a class are offered in an element: not where the rules of the model do not use them. @type {(model: Model, type: string, owner: string) => boolean} */
export function isOffered(model, type, owner) {
  const { made, notWithin, under } = model.classOf(type);
  const { middleware } = model;
  if (!made || (under !== undefined && middleware !== null && middleware !== under)) return false;
  return (
    notWithin === undefined || !model.around(owner).some((each) => model.isA(model.get(each).type, notWithin))
  );
}

/**
 * The classes that a part of an element can be of.
 *
 * @type {(model: Model, feature: Feature, owner?: string) => string[]}
 */
export function typesFor(model, feature, owner = model.root) {
  const { classes } = model.metamodel;
  return Object.keys(classes).filter(
    (name) => model.isA(name, feature.type) && isOffered(model, name, owner),
  );
}

/** What a class cannot be without. @type {(model: Model, type: string) => Feature[]} */
const needed = (model, type) =>
  model.classOf(type).features.filter((feature) => feature.required && feature.name !== "id");

/** A field, and what it says once the form is filled in. @typedef {{ row: HTMLElement, read: () => [Feature, Value] }} Field */

/**
 * A form for what objects of a class cannot be without, their mandatory parts included.
 *
 * @param {Model} model
 * @param {string} type
 * @param {string | null} given an element that references are filled in with, where they can lead there
 * @returns {{ rows: HTMLElement[], commands: (owner: string, feature: string, called: string) => Command[] }}
 */
export function formFor(model, type, given) {
  /** @type {Field[]} */
  const fields = [];
  /** @type {{ feature: Feature, type: string, form: ReturnType<typeof formFor> }[]} */
  const parts = [];
  for (const feature of needed(model, type)) {
    if (feature.kind === "part") {
      const [first] = typesFor(model, feature);
      parts.push({ feature, type: first, form: formFor(model, first, given) });
    } else {
      fields.push(fieldFor(model, feature, given));
    }
  }
  const rows = [
    ...fields.map(({ row }) => row),
    ...parts.map(({ feature, form }) =>
      make("fieldset", {}, make("legend", {}, inWords(feature.name)), ...form.rows),
    ),
  ];
  return {
    rows,
    commands(owner, feature, called) {
      const values = Object.fromEntries(
        fields.map(({ read }) => read()).map(([{ name }, value]) => [name, value]),
      );
      return [
        { kind: "create", owner, feature, type, values, called },
        ...parts.flatMap((part) =>
          part.form.commands(called, part.feature.name, `${called}.${part.feature.name}`),
        ),
      ];
    },
  };
}

/** @type {(model: Model, feature: Feature, given: string | null) => Field} */
function fieldFor(model, feature, given) {
  const words = inWords(feature.name);
  if (feature.kind === "reference") {
    const fitting = model.all(feature.type);
    const choice = make(
      "select",
      { name: feature.name, title: feature.says },
      ...fitting.map((each) => optionFor(model, each, each === given)),
    );
    return { row: make("label", {}, words, choice), read: () => [feature, choice.value] };
  }
  const input = make("input", { name: feature.name, title: feature.says, required: true });
  const isNumber = feature.type === "integer" || feature.type === "number";
  return {
    row: make("label", {}, words, input),
    read: () => [feature, isNumber ? Number(input.value) : input.value],
  };
}

/** @type {(model: Model, handle: string, isChosen: boolean) => HTMLOptionElement} */
export function optionFor(model, handle, isChosen) {
  const above = model.get(handle).in;
  const where = above === undefined || above === model.root ? "" : ` (${model.label(above)})`;
  return make("option", { value: handle, selected: isChosen }, `${model.label(handle)}${where}`);
}

/** A feature's name in words. @type {(name: string) => string} */
export const inWords = (name) => name.replace(/(?<!^)(?=[A-Z])/g, " ").toLowerCase();

/** Whether all that an object cannot be without is one reference, and where it leads is given. @type {(model: Model, type: string, given: string | null) => boolean} */
function isGiven(model, type, given) {
  const [only, ...others] = needed(model, type);
  if (given === null || only?.kind !== "reference" || others.length > 0) return false;
  return model.isA(model.get(given).type, only.type);
}

/**
 * Asks for what an object cannot be without, in a dialog; without anything to ask, answers at once.
 *
 * @param {Model} model
 * @param {{ owner: string, feature: string, type: string, given?: string | null }} wanted
 * @returns {Promise<Command[] | null>} the commands, the new object called `$new`; null if it is not wanted
 */
export function askFor(model, { owner, feature, type, given = null }) {
  const form = formFor(model, type, given);
  if (form.rows.length === 0 || isGiven(model, type, given))
    return Promise.resolve(form.commands(owner, feature, "$new"));
  const { words, says } = model.classOf(type);
  return new Promise((settle) => {
    const asked = { title: `New ${words}`, says, rows: form.rows, button: "Make" };
    askForm(
      asked,
      () => settle(form.commands(owner, feature, "$new")),
      () => settle(null),
    );
  });
}
