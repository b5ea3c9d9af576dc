// What a page gives its reader as a file.

import { make } from "./elements.js";

/** @type {(content: Blob, name: string) => void} */
export function saveFile(content, name) {
  const href = URL.createObjectURL(content);
  make("a", { href, download: name }).click();
  setTimeout(() => URL.revokeObjectURL(href), 1000);
}
