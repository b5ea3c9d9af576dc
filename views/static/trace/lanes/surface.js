// What pictures are drawn on: a canvas, or SVG. Both know the same few shapes.

/** @import { Point, Stroke, Surface, Theme } from "../types.js" */

const FONT = "'Liberation Sans', Arial, Helvetica, 'DejaVu Sans', sans-serif";

/** Points from their coordinates, x and y in turn. @type {(...coordinates: number[]) => Point[]} */
export function points(...coordinates) {
  /** @type {Point[]} */
  const found = [];
  for (let i = 0; i < coordinates.length; i += 2) found.push([coordinates[i], coordinates[i + 1]]);
  return found;
}

/** Width of a text, near enough for both surfaces. @type {(text: string, size: number) => number} */
export function textWidth(text, size) {
  let width = 0;
  for (const char of text) {
    if (/[iljt.,:;'|!()[\]]/.test(char)) width += 0.34;
    else if (/[mwMW@%]/.test(char)) width += 0.92;
    else width += /[A-Z]/.test(char) ? 0.68 : 0.57;
  }
  return width * size;
}

/**
 * As much of a text as a width has room for.
 *
 * @type {(text: string, size: number, width: number) => string}
 */
export function shorten(text, size, width) {
  if (textWidth(text, size) <= width) return text;
  let left = text;
  while (left.length > 1 && textWidth(`${left}…`, size) > width) left = left.slice(0, -1);
  return `${left}…`;
}

/** @implements {Surface} */
export class CanvasSurface {
  /** @param {CanvasRenderingContext2D} context */
  constructor(context) {
    this.context = context;
  }

  /** @type {(stroke: Stroke) => void} */
  style({ fill, stroke, width = 1, dash, opacity = 1 }) {
    const context = this.context;
    context.globalAlpha = opacity;
    if (fill) context.fillStyle = fill;
    if (!stroke) return;
    context.strokeStyle = stroke;
    context.lineWidth = width;
    context.setLineDash(dash ?? []);
  }

  /** @type {Surface["rect"]} */
  rect(x, y, width, height, stroke) {
    this.style(stroke);
    if (stroke.fill) this.context.fillRect(x, y, width, height);
    if (stroke.stroke) this.context.strokeRect(x, y, width, height);
  }

  /** @type {Surface["path"]} */
  path(course, stroke) {
    const context = this.context;
    this.style(stroke);
    context.beginPath();
    context.moveTo(...course[0]);
    for (const [x, y] of course.slice(1)) context.lineTo(x, y);
    if (stroke.closed) context.closePath();
    if (stroke.fill) context.fill();
    if (stroke.stroke) context.stroke();
  }

  /** @type {Surface["text"]} */
  text(x, y, text, { fill, size = 11, anchor = "start", bold = false, opacity = 1 }) {
    const context = this.context;
    context.globalAlpha = opacity;
    context.font = `${bold ? "600 " : ""}${size}px ${FONT}`;
    context.textAlign = anchor === "middle" ? "center" : anchor;
    context.fillStyle = fill;
    context.fillText(String(text), x, y);
  }

  /** @type {Surface["clip"]} */
  clip(x, y, width, height) {
    this.context.save();
    this.context.beginPath();
    this.context.rect(x, y, width, height);
    this.context.clip();
  }

  unclip() {
    this.context.restore();
  }

  begin() {}
  end() {}
}

/** @type {Record<string, string>} */
const ENTITIES = { "&": "&amp;", "<": "&lt;", ">": "&gt;", '"': "&quot;" };

/** @type {(text: string) => string} */
const escaped = (text) => text.replace(/[&<>"]/g, (found) => ENTITIES[found]);
/** @type {(value: number) => string} */
const number = (value) => String(Math.round(value * 100) / 100);

/** @implements {Surface} */
export class SvgSurface {
  /** @type {string[]} */
  parts = [];

  /** @type {(stroke: Stroke) => string} */
  style({ fill = "none", stroke, width = 1, dash, opacity = 1 }) {
    return (
      `fill="${fill}"${stroke ? ` stroke="${stroke}" stroke-width="${width}"` : ""}` +
      `${dash ? ` stroke-dasharray="${dash.join(" ")}"` : ""}${opacity < 1 ? ` opacity="${opacity}"` : ""}`
    );
  }

  /** @type {Surface["rect"]} */
  rect(x, y, width, height, stroke) {
    const size = `width="${number(Math.max(width, 0))}" height="${number(height)}"`;
    this.parts.push(`<rect x="${number(x)}" y="${number(y)}" ${size} ${this.style(stroke)}/>`);
  }

  /** @type {Surface["path"]} */
  path(course, stroke) {
    const line = course.map(([x, y], i) => `${i ? "L" : "M"}${number(x)} ${number(y)}`).join("");
    this.parts.push(`<path d="${line}${stroke.closed ? "Z" : ""}" ${this.style(stroke)}/>`);
  }

  /** @type {Surface["text"]} */
  text(x, y, text, { fill, size = 11, anchor = "start", bold = false, opacity = 1 }) {
    const placed = anchor === "start" ? "" : ` text-anchor="${anchor}"`;
    const weight = bold ? ' font-weight="600"' : "";
    const pale = opacity < 1 ? ` opacity="${opacity}"` : "";
    this.parts.push(
      `<text x="${number(x)}" y="${number(y)}" font-size="${size}" fill="${fill}"${placed}${weight}${pale}>`,
      `${escaped(String(text))}</text>`,
    );
  }

  /** @type {Surface["clip"]} */
  clip(x, y, width, height) {
    // An inner picture, not a clipPath: ids would be those of other pictures on the same page.
    const [left, top, wide, high] = [x, y, Math.max(width, 0), height].map(number);
    const size = `x="${left}" y="${top}" width="${wide}" height="${high}"`;
    this.parts.push(`<svg ${size} viewBox="${left} ${top} ${wide} ${high}">`);
  }

  unclip() {
    this.parts.push("</svg>");
  }

  /** @type {Surface["begin"]} */
  begin(kind, id, title) {
    const said = title ? `<title>${escaped(title)}</title>` : "";
    this.parts.push(`<g class="${escaped(kind)}" data-id="${escaped(id)}">${said}`);
  }

  end() {
    this.parts.push("</g>");
  }

  /** The whole picture. @type {(width: number, height: number, theme: Theme) => string} */
  picture(width, height, theme) {
    const size = `width="${number(width)}" height="${number(height)}"`;
    const box = `viewBox="0 0 ${number(width)} ${number(height)}"`;
    return (
      `<svg xmlns="http://www.w3.org/2000/svg" ${size} ${box} font-family="${escaped(FONT)}">` +
      `<rect width="100%" height="100%" fill="${theme.back}"/>${this.parts.join("")}</svg>\n`
    );
  }
}
