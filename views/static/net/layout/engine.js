// Asks for layouts: what lays out is packed in the page, and runs in a worker.

import { byId } from "../../elements.js";

/** @import { Picture, View } from "../types.js" */
/** @typedef {{ done: (picture: Picture) => void, fail: (error: Error) => void }} Asked */
/** @typedef {{ number: number, picture?: Picture, problem?: string }} Answer */

/** Where ELK finds no document, it takes all messages of a worker for its own. */
const BEFORE = "var document = {};";

/** @type {Map<number, Asked>} */
const asked = new Map();
/** @type {Promise<Worker> | undefined} */
let worker;
let count = 0;

/** @type {(problem: string) => void} */
function failAll(problem) {
  for (const { fail } of asked.values()) fail(new Error(problem));
  asked.clear();
}

/** @type {() => Promise<Worker>} */
async function begin() {
  const letters = atob(byId("elk", HTMLScriptElement).text.trim());
  const packed = Uint8Array.from(letters, (letter) => letter.charCodeAt(0));
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("gzip"));
  const elk = await new Response(stream).text();
  const parts = [BEFORE, elk, "\n", byId("layout", HTMLScriptElement).text];
  const made = new Worker(URL.createObjectURL(new Blob(parts, { type: "text/javascript" })));
  /** @type {(event: MessageEvent<Answer>) => void} */
  made.onmessage = ({ data: { number, picture, problem } }) => {
    const { done, fail } = asked.get(number) ?? {};
    asked.delete(number);
    if (picture) done?.(picture);
    else fail?.(new Error(problem));
  };
  made.onerror = ({ message }) => failAll(message || "it could not begin");
  return made;
}

/** Lays out a view. @type {(view: View) => Promise<Picture>} */
export async function laidOut(view) {
  worker ??= begin();
  const to = await worker;
  count += 1;
  const number = count;
  return new Promise((done, fail) => {
    asked.set(number, { done, fail });
    to.postMessage({ number, view });
  });
}
