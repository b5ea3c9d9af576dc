// Draws a positioned net (made by dineros.views.nets.layout, or by NetLayout.layout) into an <svg> element, and
// changes marking, signals and highlights by id without drawing anew. `dineros.views.nets.svg` makes the same markup.
//
// const picture = NetRenderer.draw(svg, positioned, {marking, signals, highlights})
// picture.setMarking({Safe: 1, ...})       tokens by id of place; places that are not named keep theirs
// picture.setSignals({Danger: true, ...})  values by id of signal
// picture.highlight(["TStop", ...])        marks elements by id (nodes, boxes, arcs), unmarks all others
// picture.element(id)                      the <g> of a node, box or edge, or of the collapsed box that hides it
"use strict";

var NetRenderer = (function () {
  const SIGNS = { added: "+", removed: "−", changed: "≠" };
  const DOTS = [
    [],
    [[0, 0]],
    [[-4.5, 0], [4.5, 0]],
    [[0, -4.5], [-4.5, 4], [4.5, 4]],
    [[-4.5, -4.5], [4.5, -4.5], [-4.5, 4.5], [4.5, 4.5]],
  ];
  const ENTITIES = { "&": "&amp;", "<": "&lt;", ">": "&gt;", '"': "&quot;", "'": "&#x27;" };

  const escaped = (text) => String(text).replace(/[&<>"']/g, (found) => ENTITIES[found]);
  const number = (value) => String(Math.floor(value * 10 + 0.5) / 10 + 0);

  function tokens(count) {
    if (count < DOTS.length) return DOTS[count].map(([x, y]) => `<circle cx="${x}" cy="${y}" r="3.2"/>`).join("");
    const text = String(count);
    const size = text.length < 3 ? 12 : text.length < 4 ? 10 : 7;
    return `<text y="${number(size * 0.36)}" style="font-size:${size}px">${text}</text>`;
  }

  const named = (classes, item) => `<g class="${classes}${item.change ? " " + item.change : ""}" data-id="${escaped(item.id)}">`;

  function signs(item, x, y) {
    let drawn = "";
    if (item.change) {
      drawn += `<g class="change ${item.change}" transform="translate(${number(x)},${number(y)})"><circle r="7"/><text y="4">${SIGNS[item.change]}</text></g>`;
      x -= 18;
    }
    if (item.badge) {
      drawn += `<g class="badge" transform="translate(${number(x)},${number(y)})"><circle r="9"/><text y="3.5">${escaped(item.badge)}</text></g>`;
    }
    return drawn;
  }

  function box(item) {
    const { x, y, width, height } = item, right = x + width;
    const rectangle = (name, by) =>
      `<rect class="${name}" x="${number(x - by)}" y="${number(y - by)}" width="${number(width + 2 * by)}" height="${number(height + 2 * by)}" rx="${(item.kind === "node" ? 8 : 4) + by}"/>`;
    const knob =
      `<g class="fold"><rect class="knob" x="${number(right - 18)}" y="${number(y + 6)}" width="12" height="12" rx="2"/>` +
      `<line x1="${number(right - 15)}" y1="${number(y + 12)}" x2="${number(right - 9)}" y2="${number(y + 12)}"/>` +
      (item.collapsed ? `<line x1="${number(right - 12)}" y1="${number(y + 9)}" x2="${number(right - 12)}" y2="${number(y + 15)}"/>` : "") +
      "</g>";
    const text = item.collapsed
      ? `<g transform="translate(${number(x + width / 2)},${number(y + height / 2)})">${item.glyph}</g>`
      : `<g transform="translate(${number(x)},${number(y)})">${item.head}</g>`;
    const classes = `box ${item.kind}${item.collapsed ? " collapsed" : ""}`;
    return named(classes, item) + rectangle("frame", 0) + rectangle("halo", 4) + knob + text + "</g>";
  }

  function node(item, marking) {
    let content = "";
    if (/^place/.test(item.kind)) {
      content = `<g class="tokens">${tokens(tokensOf(item, marking))}</g>`;
    }
    const wide = item.width / 2 + 4, high = item.height / 2 + 4;
    const halo = `<rect class="halo" x="${number(-wide)}" y="${number(-high)}" width="${number(2 * wide)}" height="${number(2 * high)}" rx="6"/>`;
    return `<g transform="translate(${number(item.x)},${number(item.y)})">` + named(item.kind, item) + item.glyph + halo + content + "</g></g>";
  }

  function tokensOf(item, marking) {
    const id = item.target === undefined ? item.id : item.target;
    return marking[id] === undefined ? item.tokens || 0 : marking[id];
  }

  // Arrow head, or the ring of an inhibitor arc, at the end of a line.
  function head(points, shape) {
    const [x, y] = points[points.length - 1], [fromX, fromY] = points[points.length - 2];
    const length = Math.hypot(x - fromX, y - fromY) || 1;
    const dx = (x - fromX) / length, dy = (y - fromY) / length;
    if (shape === "ring") return `<circle class="ring" cx="${number(x - 4 * dx)}" cy="${number(y - 4 * dy)}" r="4"/>`;
    const corner = (side) => `${number(x - 8 * dx - side * dy)},${number(y - 8 * dy + side * dx)}`;
    return `<polygon class="head" points="${number(x)},${number(y)} ${corner(3.4)} ${corner(-3.4)}"/>`;
  }

  function edge(item) {
    const points = item.points;
    if (points.length < 2) return "";
    const line = points.map(([x, y], index) => `${index ? "L" : "M"}${number(x)} ${number(y)}`).join("");
    let drawn = named(`edge ${item.kind}`, item) + `<path d="${line}"/>`;
    if (item.kind !== "reference") drawn += head(points, item.kind === "inhibitor" ? "ring" : "arrow");
    if (item.kind === "read") drawn += head([points[1], points[0]], "arrow");
    if (item.label && item.labelAt) {
      drawn += `<text x="${number(item.labelAt[0])}" y="${number(item.labelAt[1] + 3)}">${escaped(item.label)}</text>`;
    }
    return drawn + "</g>";
  }

  function markup(picture, marking) {
    const allSigns = [
      ...picture.boxes.map((item) => signs(item, item.x + item.width - 30, item.y + 1)),
      ...picture.nodes.map((item) => signs(item, item.x - item.width / 2 - 4, item.y - item.height / 2 - 2)),
      ...picture.edges.filter((item) => item.change && item.points.length > 1).map((item) => signs(item, ...beside(item))),
    ];
    return [
      `<rect class="paper" width="${number(picture.width)}" height="${number(picture.height)}"/>`,
      ...picture.boxes.map(box),
      ...picture.edges.map(edge),
      ...picture.nodes.map((item) => node(item, marking || {})),
      ...allSigns,
    ].join("");
  }

  // Where the sign of a line stands: left of its label, or on it.
  function beside(item) {
    if (item.label && item.labelAt) return [item.labelAt[0] - item.room[0] / 2 - 8, item.labelAt[1]];
    return middle(item.points);
  }

  // The middle of the longest piece of a line.
  function middle(points) {
    let best = 0, at = points[0];
    for (let i = 1; i < points.length; i += 1) {
      const [x, y] = points[i - 1], [nextX, nextY] = points[i];
      const length = Math.abs(nextX - x) + Math.abs(nextY - y);
      if (length > best) {
        best = length;
        at = [(x + nextX) / 2, (y + nextY) / 2];
      }
    }
    return at;
  }

  function draw(svg, picture, { marking, signals, highlights } = {}) {
    svg.classList.add("net");
    svg.setAttribute("viewBox", `0 0 ${number(picture.width)} ${number(picture.height)}`);
    const known = Object.assign({}, marking);
    svg.innerHTML = markup(picture, known);
    const drawn = new Map();
    for (const group of svg.querySelectorAll("[data-id]")) drawn.set(group.dataset.id, group);
    for (const item of picture.edges) {
      for (const other of [item.also, ...(item.stands || [])]) {
        if (other !== undefined && !drawn.has(other)) drawn.set(other, drawn.get(item.id));
      }
    }
    const references = new Map();
    for (const item of picture.nodes) {
      if (item.target !== undefined) references.set(item.target, [...(references.get(item.target) || []), item.id]);
    }
    const shown = new Map();
    let marked = [];
    const handle = {
      element: (id) => drawn.get(id),
      setMarking(changes) {
        for (const [id, count] of Object.entries(changes)) {
          known[id] = count;
          if (shown.get(id) === count) continue;
          shown.set(id, count);
          for (const one of [id, ...(references.get(id) || [])]) {
            const group = drawn.get(one) && drawn.get(one).querySelector(".tokens");
            if (group) group.innerHTML = tokens(count);
          }
        }
      },
      setSignals(values) {
        for (const [id, value] of Object.entries(values)) {
          const group = drawn.get(id);
          if (group) group.classList.toggle("true", value);
        }
      },
      highlight(ids) {
        for (const group of marked) group.classList.remove("marked");
        marked = [...ids].map((id) => drawn.get(id)).filter(Boolean);
        for (const group of marked) group.classList.add("marked");
      },
    };
    if (signals) handle.setSignals(signals);
    if (highlights) handle.highlight(highlights);
    return handle;
  }

  return { draw, markup };
})();
