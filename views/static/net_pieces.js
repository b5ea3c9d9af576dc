// Cuts the edges of a net view at the borders of its open boxes, each of which is laid out on its own; and makes the
// graphs that ELK lays out. Used by net_layout.js.
//
// NetPieces.cut(view)   the sheets of a view (its open boxes, and "" for the whole) and the pieces of its edges
//
// A sheet: {id, box, children in the order of the layout, members in that of the view, arranged, ports, edges, lines}. Between two arranged sheets a line is not cut: it runs
// straight on. `edges` are laid out by ELK, `lines` are drawn when everything has its place.
"use strict";

var NetPieces = (function () {
  const SPACE = { node: 22, layer: 34, edge: 9 };
  // What makes small pictures read in the order of the model takes minutes for large ones.
  const MANY = 150;
  const SMALL = {
    "elk.layered.nodePlacement.strategy": "NETWORK_SIMPLEX",
    "elk.layered.considerModelOrder.strategy": "PREFER_NODES",
    "elk.layered.considerModelOrder.crossingCounterNodeInfluence": "0.1",
    "elk.layered.considerModelOrder.components": "MODEL_ORDER",
  };
  const LARGE = { "elk.layered.nodePlacement.strategy": "BRANDES_KOEPF" };
  const OPTIONS = {
    "elk.algorithm": "layered",
    "elk.direction": "RIGHT",
    "elk.edgeRouting": "ORTHOGONAL",
    "elk.hierarchyHandling": "SEPARATE_CHILDREN",
    "elk.layered.cycleBreaking.strategy": "MODEL_ORDER",
    "elk.layered.nodePlacement.favorStraightEdges": "true",
    "elk.layered.spacing.nodeNodeBetweenLayers": String(SPACE.layer),
    "elk.layered.spacing.edgeNodeBetweenLayers": "14",
    "elk.layered.spacing.edgeEdgeBetweenLayers": String(SPACE.edge),
    "elk.spacing.nodeNode": String(SPACE.node),
    "elk.spacing.edgeNode": "12",
    "elk.spacing.edgeEdge": String(SPACE.edge),
    "elk.spacing.edgeLabel": "2",
    "elk.spacing.componentComponent": "22",
    "elk.spacing.portPort": "12",
    "elk.spacing.labelNode": "0",
    "elk.randomSeed": "1",
  };
  const OUT = { WEST: [-1, 0], EAST: [1, 0], NORTH: [0, -1], SOUTH: [0, 1] };

  function cut(view) {
    const around = NetOrder.nesting(view);
    const { children, turned } = NetOrder.order(view, around);
    const items = new Map([...view.boxes, ...view.nodes].map((item) => [item.id, item]));
    const rank = new Map([...items.values()].map((item, index) => [item, index]));
    const sheets = new Map();
    for (const [id, inner] of children) {
      const box = items.get(id), members = inner.map((child) => items.get(child)).sort((a, b) => rank.get(a) - rank.get(b));
      const arranged = NetStored.arranged(members, box);
      const free = new Set(inner);
      if (arranged) for (const item of NetStored.kept(members)) free.delete(item.id);
      sheets.set(id, { id, box, children: inner, members, arranged, free, ports: [], edges: [], lines: [], links: [] });
    }
    const chains = new Map();
    view.edges.forEach((edge, number) => chains.set(edge.id, chain(edge, number, around, turned, sheets, items)));
    return { sheets, items, chains, order: ["", ...view.boxes.filter((box) => !box.collapsed).map((box) => box.id)], large: view.nodes.length > MANY };
  }

  // The pieces of an edge: [{id, flip}], in the direction of the layout, which `back` tells is not the edge's own.
  function chain(edge, number, around, turned, sheets, items) {
    const { depth, from, to } = NetOrder.ends(edge, around);
    const back = Boolean(NetOrder.BACKWARDS[edge.kind]) !== turned.has(edge.id);
    const start = back ? to : from, end = back ? from : to;
    const sheetAt = (path, level) => sheets.get(level ? path[level - 1] : "");
    const steps = [];
    for (let level = start.length - 1; level > depth; level -= 1) steps.push({ sheet: sheetAt(start, level), item: start[level] });
    const middle = steps.length;
    steps.push({ sheet: sheetAt(start, depth), item: start[depth], other: end[depth] });
    for (let level = depth + 1; level < end.length; level += 1) steps.push({ sheet: sheetAt(end, level), item: end[level] });
    const pieces = [];
    let point = start[start.length - 1], first = 0;
    const close = (target, last) => {
      const id = "edge " + number + " " + pieces.length;
      pieces.push({ id, flip: add(id, edge, back, steps.slice(first, last + 1), point, target, first <= middle && middle <= last && edge.label, items) });
    };
    for (let index = 0; index + 1 < steps.length; index += 1) {
      const out = index < middle, [inner, outer] = out ? [steps[index], steps[index + 1]] : [steps[index + 1], steps[index]];
      if (inner.sheet.arranged && outer.sheet.arranged) continue;
      const id = "port " + number + " " + index;
      const beyond = outer.other && (out ? outer.other : outer.item);
      const side = (outer.sheet.arranged && beyond && direction(items.get(inner.sheet.id), items.get(beyond))) || (out ? "EAST" : "WEST");
      inner.sheet.ports.push({ id, side, via: inner.item });
      close(id, index);
      [point, first] = [id, index + 1];
    }
    close(end[end.length - 1], steps.length - 1);
    return { pieces, back };
  }

  // Hand a piece to its sheet; returns whether ELK gets it turned round.
  function add(id, edge, back, steps, source, target, labelled, items) {
    const [{ sheet, item, other }] = steps;
    const alone = steps.length === 1;
    const together = alone && other && sheet.free.has(item) && sheet.free.has(other);
    const byElk = alone && (!sheet.arranged || together);
    if (!byElk) {
      const outermost = steps.find((step) => step.other) || steps[0];
      outermost.sheet.lines.push({
        id, edge, back, source, target, labelled, sheets: steps.map((step) => step.sheet),
        bent: Boolean(alone && other && edge.bends && !sheet.free.has(item) && !sheet.free.has(other)),
      });
      if (outermost.other) outermost.sheet.links.push([outermost.item, outermost.other, id]);
      return false;
    }
    // A line that leaves to the left, or enters from the right, is laid out from there.
    const side = (port) => (sheet.ports.find((found) => found.id === port) || {}).side;
    const flip = side(target) === "WEST" || side(source) === "EAST";
    const made = { id, sources: [flip ? target : source], targets: [flip ? source : target] };
    if (labelled) {
      made.labels = [{ id: id + " label", text: edge.label, width: edge.room[0], height: edge.room[1] }];
      made.layoutOptions = { "elk.edgeLabels.placement": "CENTER" };
    }
    sheet.edges.push(made);
    if (together) sheet.links.push([item, other, id]);
    return flip;
  }

  // The side of a box that faces another item of an arranged sheet.
  function direction(box, other) {
    if (!box.position || !other.position) return null;
    const dx = other.position[0] - box.position[0], dy = other.position[1] - box.position[1];
    if (Math.abs(dx) * 2 < Math.abs(dy)) return dy < 0 ? "NORTH" : "SOUTH";
    return dx < 0 ? "WEST" : "EAST";
  }

  // The graph of a sheet that ELK lays out, and of what is in it. `sizes` tells those of arranged sheets in it.
  function graph(plan, id, sizes) {
    const sheet = plan.sheets.get(id), box = sheet.box;
    const made = frame(plan, id || " root", box);
    made.children = sheet.children.map((child) => inner(plan, child, sizes));
    made.edges = sheet.edges;
    made.ports = sheet.ports.map((port) => ({ id: port.id, width: 0, height: 0, layoutOptions: { "elk.port.side": port.side } }));
    if (box) {
      made.layoutOptions["elk.portConstraints"] = "FIXED_SIDE";
      made.layoutOptions["elk.nodeSize.constraints"] = "MINIMUM_SIZE PORTS";
      made.layoutOptions["elk.nodeSize.minimum"] = "(" + (box.header[0] + 8) + "," + (box.header[1] + 20) + ")";
    }
    return made;
  }

  // The graph of those items of an arranged sheet that have no position.
  function freeGraph(plan, id, sizes) {
    const sheet = plan.sheets.get(id), made = frame(plan, " free", null);
    made.layoutOptions["elk.padding"] = "[top=0,left=0,bottom=0,right=0]";
    made.children = sheet.children.filter((child) => sheet.free.has(child)).map((child) => inner(plan, child, sizes));
    // Items whose line is not laid out are to stand near each other nevertheless.
    const known = new Set(sheet.edges.map(({ id: edge }) => edge));
    const near = sheet.links.filter(([one, other, edge]) => !known.has(edge) && one !== other && sheet.free.has(one) && sheet.free.has(other));
    made.edges = [...sheet.edges, ...near.map(([one, other], index) => ({ id: " near " + index, sources: [one], targets: [other] }))];
    return made;
  }

  function frame(plan, id, box) {
    const padding = box ? "[top=" + (box.header[1] + 10) + ",left=16,bottom=14,right=16]" : "[top=16,left=16,bottom=16,right=16]";
    return { id, children: [], edges: [], ports: [], layoutOptions: { ...OPTIONS, ...(plan.large ? LARGE : SMALL), "elk.padding": padding } };
  }

  function inner(plan, id, sizes) {
    const item = plan.items.get(id), sheet = plan.sheets.get(id);
    if (!sheet) return leaf(item);
    if (!sheet.arranged) return graph(plan, id, sizes);
    const { width, height, ports } = sizes.get(id);
    const fixed = ports.map(({ id: port, side, x, y }) => ({ id: port, x, y, width: 0, height: 0, layoutOptions: { "elk.port.side": side } }));
    return { id, width, height, ports: fixed, layoutOptions: { "elk.portConstraints": "FIXED_POS" } };
  }

  function leaf(item) {
    const made = { id: item.id, width: item.width, height: item.height };
    if (item.room && item.room[0]) {
      made.labels = [{ id: item.id + " label", text: " ", width: item.room[0], height: item.room[1] }];
      made.layoutOptions = { "elk.nodeLabels.placement": "OUTSIDE V_BOTTOM H_CENTER" };
    }
    return made;
  }

  return { OUT, cut, graph, freeGraph };
})();
