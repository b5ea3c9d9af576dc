// A picture of a net as a file of its own: for pages and, in V8, for Python.

import { escaped, netMarkup, number } from "./renderer.js";

/** @import { Picture } from "./types.js" */
/** @import { Overlay } from "./renderer.js" */
/**
 * @typedef {object} Sheet  paper
 * @property {[x: number, y: number, width: number, height: number]} area what it shows of the plane
 * @property {number} width in millimetres
 */

const MOST_PIXELS = 80e6;

/**
 * The picture as SVG, with the style of a theme (`dineros.views.nets.drawing.svg.stylesheet`); in pixels where
 * it is not for paper.
 *
 * @type {(picture: Picture, style: string, theme: "light" | "dark", paper?: Sheet | null, overlay?: Overlay) => string}
 */
export function netFigure(picture, style, theme, paper, overlay) {
  const [x, y, wide, high] = (paper?.area ?? [0, 0, picture.width, picture.height]).map(number);
  const [width, height] = paper ? millimetres(paper) : [wide, high];
  const sheet = paper ? `<rect class="paper" x="${x}" y="${y}" width="${wide}" height="${high}"/>` : "";
  return (
    `<svg xmlns="http://www.w3.org/2000/svg" class="net net-${theme}" width="${width}" height="${height}" ` +
    `viewBox="${x} ${y} ${wide} ${high}" role="img">` +
    `<title>${escaped(picture.title)}</title><style>${style}</style>` +
    `${sheet}${netMarkup(picture, overlay)}</svg>\n`
  );
}

/** Width and height of paper. @type {(paper: Sheet) => string[]} */
const millimetres = ({ area, width }) =>
  [width, (width * area[3]) / area[2]].map((value) => `${Number(value.toPrecision(6))}mm`);

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
