// Layout where ELK (elkjs) is loaded already: in the worker of a page; in V8, for Python.

import { layout } from "./layout.js";

/** @import { Engine, Picture, View } from "../types.js" */

/** @type {Engine | undefined} */
let engine;

/**
 * @param {View} view
 * @returns {Promise<Picture>}
 */
export const layoutByElk = (view) => layout(view, () => (engine ??= new ELK()));
