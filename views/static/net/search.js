// The search for elements by their names, ids and details.

import { byId, make } from "../elements.js";
import { heading, WORDS } from "./words.js";

/** @import { NetPage } from "./page.js" */
/** @import { Item } from "./types.js" */

const MOST = 30;
const NONE = 4;

/** How well an element fits what is looked for: 0 is best. @type {(item: Item, wanted: string) => number} */
function rank(item, wanted) {
  const texts = [heading(item), item.id, ...Object.values(item.detail ?? {})].map((one) => one.toLowerCase());
  const names = texts.slice(0, 2);
  if (names.includes(wanted)) return 0;
  if (names.some((name) => name.startsWith(wanted))) return 1;
  if (names.some((name) => name.includes(wanted))) return 2;
  return texts.some((text) => text.includes(wanted)) ? 3 : NONE;
}

/**
 * The elements that a text is found in, those first whose names it is.
 *
 * @type {(items: Item[], text: string) => Item[]}
 */
export function matching(items, text) {
  const wanted = text.trim().toLowerCase();
  if (!wanted) return [];
  return items
    .map((item) => ({ item, rank: rank(item, wanted) }))
    .filter((one) => one.rank < NONE)
    .sort((a, b) => a.rank - b.rank)
    .map(({ item }) => item);
}

export class Search {
  /** @type {Item[]} */
  matches = [];
  chosen = 0;

  /** @param {NetPage} page */
  constructor(page) {
    this.page = page;
    this.field = byId("search", HTMLInputElement);
    this.results = byId("search-list", HTMLUListElement);
    this.field.addEventListener("input", () => {
      this.chosen = 0;
      this.list();
    });
    this.field.addEventListener("blur", () => this.open(false));
    this.field.addEventListener("keydown", (event) => this.pressed(event));
  }

  list() {
    const { boxes, nodes } = this.page.everything;
    this.matches = matching([...boxes, ...nodes], this.field.value);
    this.chosen = Math.min(this.chosen, Math.max(this.matches.length - 1, 0));
    this.results.replaceChildren(
      ...this.matches.slice(0, MOST).map((item, index) => {
        /** @type {(event: MouseEvent) => void} */
        const onmousedown = (event) => {
          event.preventDefault();
          this.choose(index);
        };
        return make(
          "li",
          {
            id: `found-${index}`,
            role: "option",
            "aria-selected": String(index === this.chosen),
            onmousedown,
          },
          heading(item),
          make("small", {}, WORDS[item.kind] + (item.id === heading(item) ? "" : ` ${item.id}`)),
        );
      }),
    );
    this.open(this.matches.length > 0);
    if (this.field.value.trim())
      this.page.say(this.matches.length ? `${this.matches.length} found` : "nothing found");
  }

  /** @param {boolean} on */
  open(on) {
    this.results.hidden = !on;
    this.field.setAttribute("aria-expanded", String(on));
    if (on) this.field.setAttribute("aria-activedescendant", `found-${this.chosen}`);
    else this.field.removeAttribute("aria-activedescendant");
    this.results.children[on ? this.chosen : 0]?.scrollIntoView({ block: "nearest" });
  }

  /** @param {number} index */
  choose(index) {
    this.open(false);
    this.page.svg.focus({ preventScroll: true });
    if (this.matches[index]) this.page.find(this.matches[index].id);
  }

  /** @param {KeyboardEvent} event */
  pressed(event) {
    const step = event.key === "ArrowDown" ? 1 : event.key === "ArrowUp" ? -1 : 0;
    if (step) {
      this.chosen = Math.max(0, Math.min(this.matches.length - 1, this.chosen + step));
      this.list();
    } else if (event.key === "Enter") this.choose(this.chosen);
    else if (event.key === "Escape") {
      this.field.value = "";
      this.list();
      this.page.svg.focus();
    } else return;
    event.preventDefault();
    event.stopPropagation();
  }
}
