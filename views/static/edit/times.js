// Times of elements in words, as pictures have them: see views/nets/contents/times.py.

/** @import { Model } from "./model.js" */

/** What a time is called on a card, by the feature that holds it. @type {Record<string, (words: string) => string>} */
const SAID = {
  duration: (words) => `takes ${words}`,
  reaction: (words) => `reacts in ${words}`,
  latency: (words) => `${words} on the way`,
};

/**
 * An interval of seconds in words, in milliseconds if it ends before one second.
 *
 * @type {(earliest: number, latest: number | null, isOpenBelow: boolean, isOpenAbove: boolean) => string}
 */
export function intervalWords(earliest, latest, isOpenBelow, isOpenAbove) {
  const [unit, factor] = (latest ?? earliest) < 1 ? ["ms", 1000] : ["s", 1];
  const scaled = (/** @type {number} */ bound) => Number((bound * factor).toPrecision(12));
  const first = scaled(earliest);
  if (latest === null) {
    if (earliest === 0 && !isOpenBelow) return "any time";
    return `${isOpenBelow ? "more than" : "at least"} ${first} ${unit}`;
  }
  const last = scaled(latest);
  if (earliest === latest) return `${last} ${unit}`;
  if (earliest === 0 && !isOpenBelow) return `${isOpenAbove ? "less than" : "at most"} ${last} ${unit}`;
  return `${isOpenBelow ? "more than " : ""}${first} to ${isOpenAbove ? "less than " : ""}${last} ${unit}`;
}

/** An interval of the model in words. @type {(model: Model, interval: string) => string} */
export function wordsOf(model, interval) {
  const latest = model.value(interval, "latest");
  const is = (/** @type {string} */ name) => model.value(interval, name) === true;
  return intervalWords(
    Number(model.value(interval, "earliest")),
    latest === null ? null : Number(latest),
    is("earliestExcluded"),
    is("latestExcluded"),
  );
}

/** The times that are on the card of an element. @type {(model: Model, element: string) => string[]} */
export function timesOf(model, element) {
  const period = model.feature(element, "timer") === undefined ? null : model.value(element, "timer");
  const found = period === null ? [] : [`every ${period} s`];
  for (const [name, say] of Object.entries(SAID)) {
    const interval = model.feature(element, name) === undefined ? null : model.link(element, name);
    if (interval !== null) found.push(say(wordsOf(model, interval)));
  }
  return found;
}
