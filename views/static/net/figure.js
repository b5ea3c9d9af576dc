// A picture of a net as a file of its own. `dineros.views.nets.to_svg` makes the same: a test compares.

import { escaped, netMarkup, number } from "./renderer.js";

/** @import { Picture } from "./types.js" */

const MOST_PIXELS = 80e6;

/**
 * The picture as SVG, with the style of a theme: `dineros.views.nets.drawing.svg.stylesheet`.
 *
 * @type {(picture: Picture, style: string, theme: "light" | "dark") => string}
 */
export function netFigure(picture, style, theme) {
  const [width, height] = [number(picture.width), number(picture.height)];
  return (
    `<svg xmlns="http://www.w3.org/2000/svg" class="net net-${theme}" width="${width}" height="${height}" ` +
    `viewBox="0 0 ${width} ${height}" role="img">` +
    `<title>${escaped(picture.title)}</title><style>${style}</style>` +
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
