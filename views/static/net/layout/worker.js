// Layout in a worker: the page continues to respond meanwhile. ELK has been loaded before.

import { layoutByElk } from "./elk.js";

/** @import { View } from "../types.js" */

/** @type {(event: MessageEvent<{ number: number, view: View }>) => Promise<void>} */
const answer = async ({ data: { number, view } }) => {
  try {
    postMessage({ number, picture: await layoutByElk(view) });
  } catch (error) {
    postMessage({ number, problem: error instanceof Error ? error.message : String(error) });
  }
};
addEventListener("message", answer);
