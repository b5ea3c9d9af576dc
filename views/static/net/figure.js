// A picture of a net as a file of its own. `dineros.views.nets.to_svg` makes the same: a test compares.

import { escaped, netMarkup, number } from "./renderer.js";

/** @import { Picture } from "./types.js" */

const STILL = ".net .fold{display:none}.net .collapsed .fold{display:inline}"; // nothing collapses on a click here
const MOST_PIXELS = 80e6;

/**
 * The style of a theme, without variables: not every program that shows SVG knows them.
 *
 * @type {(style: string, theme: "light" | "dark") => string}
 */
function resolved(style, theme) {
  let text = style.replace(/\/\*.*?\*\//gs, "");
  const themes = text.match(/[^{}]*\{\s*--net-[^}]*\}/g) ?? []; // light, then what differs in dark
  /** @type {Map<string, string>} */
  const values = new Map();
  for (const block of themes.slice(0, theme === "dark" ? 2 : 1))
    for (const [, name, value] of block.matchAll(/(--net-[\w-]+):\s*([^;]+);/g)) values.set(name, value);
  for (const block of themes) text = text.replace(block, "");
  return (text + STILL)
    .replace(/var\((--net-[\w-]+)\)/g, (_, name) => values.get(name) ?? "")
    .replaceAll(".net ", `.net-${theme} `)
    .replace(/\s*\n\s*/g, "");
}

/** @type {(picture: Picture, style: string, theme: "light" | "dark") => string} */
export function netFigure(picture, style, theme) {
  const [width, height] = [number(picture.width), number(picture.height)];
  return (
    `<svg xmlns="http://www.w3.org/2000/svg" class="net net-${theme}" width="${width}" height="${height}" ` +
    `viewBox="0 0 ${width} ${height}" role="img">` +
    `<title>${escaped(picture.title)}</title><style>${resolved(style, theme)}</style>` +
    `${netMarkup(picture)}</svg>\n`
  );
}

/** Draws a picture as PNG, with two pixels per unit; a huge one gets fewer. @type {(svg: string, picture: Picture) => Promise<Blob>} */
export async function asPng(svg, { width, height }) {
  const scale = Math.min(2, Math.sqrt(MOST_PIXELS / (width * height)));
  const image = new Image();
  const href = URL.createObjectURL(new Blob([svg], { type: "image/svg+xml" }));
  try {
    image.src = href;
    await image.decode();
    const canvas = document.createElement("canvas");
    canvas.width = Math.round(width * scale);
    canvas.height = Math.round(height * scale);
    canvas.getContext("2d")?.drawImage(image, 0, 0, canvas.width, canvas.height);
    return await new Promise((done, fail) =>
      canvas.toBlob((blob) => (blob ? done(blob) : fail(new Error("the picture is too large")))),
    );
  } finally {
    URL.revokeObjectURL(href);
  }
}
