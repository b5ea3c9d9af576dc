// The order in which a net is laid out, and which of its lines lead backwards; used by net_layout.js.
//
// NetOrder.nesting(view)         the boxes around each box and node
// NetOrder.ends(edge, around)    what an edge joins, from the outermost box in which both ends are apart
// NetOrder.order(view, around)   the children of each box in order, and the edges to lay out turned round
"use strict";

var NetOrder = (function () {
  // Laid out against their direction: a client's response comes back the way the request went.
  const BACKWARDS = { response: true, return: true };

  // The containers around each item, from the root inwards.
  function nesting(view) {
    const parents = new Map(view.boxes.map((box) => [box.id, box.parent === undefined ? null : box.parent]));
    const paths = new Map([[null, []]]);
    function path(id) {
      if (!paths.has(id)) paths.set(id, [...path(parents.get(id)), id]);
      return paths.get(id);
    }
    const around = new Map();
    for (const box of view.boxes) around.set(box.id, path(box.parent === undefined ? null : box.parent));
    for (const node of view.nodes) around.set(node.id, path(node.box === undefined ? null : node.box));
    return around;
  }

  // What the edge joins among the children of the innermost container of both ends.
  function ends(edge, around) {
    const from = [...around.get(edge.source), edge.source], to = [...around.get(edge.target), edge.target];
    let depth = 0;
    while (depth < from.length - 1 && depth < to.length - 1 && from[depth] === to[depth]) depth += 1;
    return { depth, from, to };
  }

  // Children of each container in the order they are met from where tokens are, and the edges to turn round.
  function order(view, around) {
    const children = new Map([["", []]]);
    const inside = (path) => path.length ? path[path.length - 1] : "";
    const marked = new Set();
    for (const box of view.boxes) if (!box.collapsed) children.set(box.id, []);
    for (const item of [...view.boxes, ...view.nodes]) {
      children.get(inside(around.get(item.id))).push(item.id);
      if (item.tokens) for (const id of [...around.get(item.id), item.id]) marked.add(id);
    }
    const links = new Map([...children.keys()].map((id) => [id, []]));
    for (const edge of view.edges) {
      const { depth, from, to } = ends(edge, around);
      const [one, other] = BACKWARDS[edge.kind] ? [to[depth], from[depth]] : [from[depth], to[depth]];
      if (one !== other) links.get(depth ? from[depth - 1] : "").push([one, other, edge.id]);
    }
    // A client goes on from its request to its response; this orders, but is no line.
    const waiting = new Map();
    for (const edge of view.edges) {
      const client = JSON.stringify([edge.label, edge.kind === "request" ? edge.target : edge.source]);
      if (edge.kind === "request") waiting.set(client, edge.source);
      else if (edge.kind === "response" && waiting.has(client)) {
        const { depth, from, to } = ends({ source: waiting.get(client), target: edge.target }, around);
        if (from[depth] !== to[depth]) links.get(depth ? from[depth - 1] : "").push([from[depth], to[depth], null]);
      }
    }
    const turned = new Set();
    for (const [container, ids] of children) {
      const next = new Map(ids.map((id) => [id, []])), entries = new Map(ids.map((id) => [id, 0]));
      for (const [one, other, edge] of links.get(container)) {
        next.get(one).push([other, edge]);
        entries.set(other, entries.get(other) + 1);
      }
      const starts = [
        ...ids.filter((id) => !entries.get(id) && next.get(id).length),
        ...ids.filter((id) => marked.has(id)),
        ...ids,
      ];
      const state = new Map(), met = [];
      for (const start of starts) {
        if (state.has(start)) continue;
        const stack = [[start, 0]];
        state.set(start, "open");
        met.push(start);
        while (stack.length) {
          const top = stack[stack.length - 1], [id, index] = top;
          if (index === next.get(id).length) {
            state.set(id, "done");
            stack.pop();
          } else {
            top[1] += 1;
            const [other, edge] = next.get(id)[index];
            if (state.get(other) === "open") {
              if (edge !== null) turned.add(edge);
            } else if (!state.has(other)) {
              state.set(other, "open");
              met.push(other);
              stack.push([other, 0]);
            }
          }
        }
      }
      sortBy(ids, met, links.get(container), turned);
    }
    return { children, turned };
  }

  // Sort so that all edges, turned round or not, lead onwards; otherwise in the order things were met.
  function sortBy(ids, met, links, turned) {
    const rank = new Map(met.map((id, index) => [id, index]));
    const next = new Map(ids.map((id) => [id, []])), waits = new Map(ids.map((id) => [id, 0]));
    for (const [one, other, edge] of links) {
      if (edge === null) continue;
      const [first, second] = turned.has(edge) ? [other, one] : [one, other];
      next.get(first).push(second);
      waits.set(second, waits.get(second) + 1);
    }
    const free = ids.filter((id) => !waits.get(id)), sorted = [];
    while (free.length) {
      let best = 0;
      for (let index = 1; index < free.length; index += 1) if (rank.get(free[index]) < rank.get(free[best])) best = index;
      const [id] = free.splice(best, 1);
      sorted.push(id);
      for (const other of next.get(id)) {
        waits.set(other, waits.get(other) - 1);
        if (!waits.get(other)) free.push(other);
      }
    }
    ids.splice(0, ids.length, ...sorted);
  }

  return { BACKWARDS, nesting, ends, order };
})();
