// Fields for what a balloon token carries, made from its token type.

/** @import { Model } from "../model.js" */
/** @import { Feature } from "../types.js" */

/**
 * A field of a token type, and what a token says of it.
 *
 * @typedef {object} TokenField
 * @property {string} name
 * @property {string} kind
 * @property {Feature} feature what its row is labelled with
 * @property {string} text what the token says, empty for the default
 */

/** The fields of a balloon token; none where its data is not an object. @type {(model: Model, token: string) => TokenField[]} */
export function fieldsOf(model, token) {
  const place = model.get(token).in;
  if (place === undefined) return [];
  const first = model.feature(model.root, "tokenType") ? model.link(model.root, "tokenType") : null;
  const type = model.link(place, "tokenType") ?? first;
  const data = said(String(model.value(token, "data") ?? "{}"));
  if (type === null || data === null) return [];
  return model.links(type, "fields").map((field) => {
    const name = String(model.value(field, "name"));
    const kind = String(model.value(field, "kind"));
    const usual = model.value(field, "default");
    const length = model.value(field, "length");
    const each = `${model.value(field, "elementKind")}s`;
    const shape = kind === "list" ? `list of ${length ?? ""} ${each}`.replace("  ", " ") : kind;
    const says = `${name}: ${kind === "map" ? `map of ${each}` : shape}${usual === null ? "" : `, else ${usual}`}`;
    const given = Object.hasOwn(data, name) ? data[name] : undefined;
    return {
      name,
      kind,
      feature: { name: `data-${name}`, says, kind: "attribute", type: kind },
      text: given === undefined ? "" : typeof given === "string" ? given : JSON.stringify(given),
    };
  });
}

/** @type {(data: string) => Record<string, unknown> | null} */
function said(data) {
  try {
    const found = JSON.parse(data);
    return typeof found === "object" && found !== null && !Array.isArray(found) ? found : null;
  } catch {
    return null;
  }
}
