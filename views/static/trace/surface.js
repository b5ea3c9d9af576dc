// What pictures are drawn on: a canvas, or SVG. Both know the same few shapes.
(function (T) {
  "use strict";

  T.FONT = "'Liberation Sans', Arial, Helvetica, 'DejaVu Sans', sans-serif";

  // Colours of node nets (after Paul Tol's schemes, told apart with all kinds of colour vision), then of the rest.
  T.themes = {
    light: {
      back: "#ffffff", panel: "#f5f7f9", ink: "#17212b", soft: "#5b6773", line: "#d5dbe1", grid: "#eef1f4",
      topic: "#1f6fb2", topicFill: "#bcd9f0", service: "#1c7c54", serviceFill: "#8fcfb1", signal: "#a86a00", signalFill: "#f6d58d",
      handler: "#7a3fa0", alarm: "#c62828", cursor: "#c2185b", loop: "#f3e9fb", loopInk: "#6a3a96", fold: "#e3e8ed", stem: "#ffffff", cause: "#a04000",
      nodes: ["#4477aa", "#cc6677", "#228833", "#b8860b", "#8855aa", "#2a9db0", "#996633", "#667788"],
    },
    dark: {
      back: "#12181f", panel: "#1a222b", ink: "#e6ebf0", soft: "#9aa7b4", line: "#33404d", grid: "#1c252e",
      topic: "#6db3ef", topicFill: "#234a6b", service: "#5ecb9b", serviceFill: "#1f5a41", signal: "#f0b64a", signalFill: "#5d4413",
      handler: "#c99bea", alarm: "#ff6b6b", cursor: "#ff6fa8", loop: "#2a2140", loopInk: "#c9a6f0", fold: "#26313c", stem: "#12181f", cause: "#ffa05c",
      nodes: ["#7aaadd", "#e58a99", "#57b565", "#d9b040", "#b78ad6", "#5cc5d6", "#c69a66", "#9aabbc"],
    },
  };

  /** Width of a text, near enough for both surfaces. */
  T.textWidth = (text, size) => {
    let width = 0;
    for (const char of String(text)) width += /[iljt.,:;'|!()[\]]/.test(char) ? 0.34 : /[mwMW@%]/.test(char) ? 0.92 : /[A-Z]/.test(char) ? 0.68 : 0.57;
    return width * size;
  };

  T.shorten = (text, size, width) => {
    text = String(text);
    if (T.textWidth(text, size) <= width) return text;
    while (text.length > 1 && T.textWidth(`${text}…`, size) > width) text = text.slice(0, -1);
    return `${text}…`;
  };

  T.CanvasSurface = class {
    constructor(context) { this.context = context; }

    style({ fill, stroke, width = 1, dash, opacity = 1 }) {
      const context = this.context;
      context.globalAlpha = opacity;
      if (fill) context.fillStyle = fill;
      if (stroke) { context.strokeStyle = stroke; context.lineWidth = width; context.setLineDash(dash || []); }
    }

    rect(x, y, width, height, options) {
      this.style(options);
      if (options.fill) this.context.fillRect(x, y, width, height);
      if (options.stroke) this.context.strokeRect(x, y, width, height);
    }

    path(points, options) {
      this.style(options);
      this.context.beginPath();
      points.forEach(([x, y], i) => (i ? this.context.lineTo(x, y) : this.context.moveTo(x, y)));
      if (options.closed) this.context.closePath();
      if (options.fill) this.context.fill();
      if (options.stroke) this.context.stroke();
    }

    text(x, y, text, { fill, size = 11, anchor = "start", bold = false, opacity = 1 }) {
      const context = this.context;
      context.globalAlpha = opacity;
      context.font = `${bold ? "600 " : ""}${size}px ${T.FONT}`;
      context.textAlign = anchor === "middle" ? "center" : anchor;
      context.fillStyle = fill;
      context.fillText(text, x, y);
    }

    clip(x, y, width, height) {
      this.context.save();
      this.context.beginPath();
      this.context.rect(x, y, width, height);
      this.context.clip();
    }

    unclip() { this.context.restore(); }
    begin() {}
    end() {}
  };

  const escape = (text) => String(text).replace(/[&<>"]/g, (char) => ({ "&": "&amp;", "<": "&lt;", ">": "&gt;", '"': "&quot;" })[char]);
  const number = (value) => String(Math.round(value * 100) / 100);

  T.SvgSurface = class {
    constructor() { this.parts = []; this.clips = 0; }

    style({ fill, stroke, width = 1, dash, opacity = 1 }) {
      return `fill="${fill || "none"}"${stroke ? ` stroke="${stroke}" stroke-width="${width}"` : ""}` +
        `${dash ? ` stroke-dasharray="${dash.join(" ")}"` : ""}${opacity < 1 ? ` opacity="${opacity}"` : ""}`;
    }

    rect(x, y, width, height, options) {
      this.parts.push(`<rect x="${number(x)}" y="${number(y)}" width="${number(Math.max(width, 0))}" height="${number(height)}" ${this.style(options)}/>`);
    }

    path(points, options) {
      const line = points.map(([x, y], i) => `${i ? "L" : "M"}${number(x)} ${number(y)}`).join("");
      this.parts.push(`<path d="${line}${options.closed ? "Z" : ""}" ${this.style(options)}/>`);
    }

    text(x, y, text, { fill, size = 11, anchor = "start", bold = false, opacity = 1 }) {
      this.parts.push(`<text x="${number(x)}" y="${number(y)}" font-size="${size}" fill="${fill}"` +
        `${anchor === "start" ? "" : ` text-anchor="${anchor}"`}${bold ? ' font-weight="600"' : ""}${opacity < 1 ? ` opacity="${opacity}"` : ""}>${escape(text)}</text>`);
    }

    clip(x, y, width, height) {
      const id = `clip${this.clips++}`;
      this.parts.push(`<clipPath id="${id}"><rect x="${number(x)}" y="${number(y)}" width="${number(width)}" height="${number(height)}"/></clipPath><g clip-path="url(#${id})">`);
    }

    unclip() { this.parts.push("</g>"); }

    begin(kind, id, title) { this.parts.push(`<g class="${escape(kind)}" data-id="${escape(id)}">${title ? `<title>${escape(title)}</title>` : ""}`); }
    end() { this.parts.push("</g>"); }

    toString(width, height, theme) {
      return `<svg xmlns="http://www.w3.org/2000/svg" width="${number(width)}" height="${number(height)}" viewBox="0 0 ${number(width)} ${number(height)}" font-family="${escape(T.FONT)}">` +
        `<rect width="100%" height="100%" fill="${theme.back}"/>${this.parts.join("")}</svg>\n`;
    }
  };
})((globalThis.DinerosTrace ??= {}));
