// Layout beside the page: it goes on answering its reader meanwhile. ELK has been loaded before.

import { layout } from "./layout.js";

/** @import { Engine, View } from "./types.js" */

/** @type {Engine | undefined} */
let engine;

/** @type {(event: MessageEvent<{ number: number, view: View }>) => Promise<void>} */
const answer = async ({ data: { number, view } }) => {
  try {
    postMessage({ number, picture: await layout(view, () => (engine ??= new ELK())) });
  } catch (error) {
    postMessage({ number, problem: error instanceof Error ? error.message : String(error) });
  }
};
addEventListener("message", answer);
