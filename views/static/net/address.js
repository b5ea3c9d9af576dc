// What is seen of a net, behind the # of the page's address: a link leads to the same.

/**
 * @typedef {object} Place
 * @property {string | null} element what is chosen
 * @property {{ ids: string[], steps: number } | null} part a neighbourhood that is shown alone
 * @property {string[]} open boxes that are open, other than at first
 * @property {string[]} closed boxes that are collapsed, other than at first
 */

/** @type {(place: Place) => string} */
export function written({ element, part, open, closed }) {
  const said = new URLSearchParams();
  if (element !== null) said.set("element", element);
  for (const id of part?.ids ?? []) said.append("around", id);
  if (part) said.set("steps", String(part.steps));
  for (const id of open) said.append("open", id);
  for (const id of closed) said.append("closed", id);
  return said.toString();
}

/** @type {(hash: string) => Place} */
export function read(hash) {
  const said = new URLSearchParams(hash.replace(/^#/, ""));
  const ids = said.getAll("around");
  const steps = Math.max(0, Math.min(99, Math.floor(Number(said.get("steps") ?? 2)) || 0));
  return {
    element: said.get("element"),
    part: ids.length ? { ids, steps } : null,
    open: said.getAll("open"),
    closed: said.getAll("closed"),
  };
}
