// Layout of a net view: which boxes and edges are visible, and where they go. Runs in browsers and, through
// mini-racer, inside Python; needs the globals ELK (elkjs), NetOrder, NetPieces, NetStored, NetBlocks, NetCaptions, NetLines and NetDrawn.
//
// NetLayout.visible(view)             what is left when collapsed boxes hide their content
// NetLayout.around(view, ids, steps)  the neighbourhood of some elements
// NetLayout.layout(view)              a promise of the positioned picture: the visible part with coordinates
"use strict";

var NetLayout = (function () {
  function visible(view) {
    const boxes = new Map((view.boxes || []).map((box) => [box.id, box]));
    // The outermost collapsed box around a box, itself included.
    const shown = new Map();
    function standIn(id) {
      if (id === undefined || id === null) return null;
      if (shown.has(id)) return shown.get(id);
      const box = boxes.get(id);
      const result = standIn(box.parent) || (box.collapsed ? id : null);
      shown.set(id, result);
      return result;
    }
    const result = {
      boxes: (view.boxes || []).filter((box) => !standIn(box.parent)),
      nodes: (view.nodes || []).filter((node) => !standIn(node.box)),
      edges: [],
    };
    const home = new Map((view.nodes || []).map((node) => [node.id, standIn(node.box) || node.id]));
    const merged = new Map();
    for (const edge of view.edges || []) {
      const source = home.get(edge.source), target = home.get(edge.target);
      if (source === undefined || target === undefined) continue;
      if (source === edge.source && target === edge.target) {
        result.edges.push(edge);
      } else if (source !== target) {
        // Lines of one kind to the same collapsed box are one line.
        const key = JSON.stringify([edge.kind, source, target, edge.change || ""]);
        const known = merged.get(key);
        if (known) {
          known.stands.push(edge.id);
          if (known.label !== edge.label) { known.label = ""; known.room = [0, 0]; }
        } else {
          const copy = Object.assign({}, edge, { source, target, stands: [edge.id] });
          delete copy.bends;
          merged.set(key, copy);
          result.edges.push(copy);
        }
      }
    }
    return Object.assign({}, view, result);
  }

  // The part of a view that is at most some steps away from some nodes, boxes or edges.
  function around(view, ids, steps) {
    const neighbours = new Map(view.nodes.map((node) => [node.id, []]));
    for (const edge of view.edges) {
      if (!neighbours.has(edge.source) || !neighbours.has(edge.target)) continue;
      neighbours.get(edge.source).push(edge.target);
      neighbours.get(edge.target).push(edge.source);
    }
    let border = ids.flatMap((id) => nodesOf(view, id));
    const kept = new Set(border);
    for (let step = 0; step < steps; step += 1) {
      const next = [];
      for (const id of border) {
        for (const other of neighbours.get(id)) {
          if (!kept.has(other)) {
            kept.add(other);
            next.push(other);
          }
        }
      }
      border = next;
    }
    const parents = new Map(view.boxes.map((box) => [box.id, box.parent]));
    const needed = new Set();
    const nodes = view.nodes.filter((node) => kept.has(node.id));
    for (const node of nodes) {
      for (let box = node.box; box !== undefined && box !== null && !needed.has(box); box = parents.get(box)) needed.add(box);
    }
    const boxes = view.boxes.filter((box) => needed.has(box.id)).map((box) => {
      const open = Object.assign({}, box);
      delete open.collapsed;
      return open;
    });
    const edges = view.edges.filter((edge) => kept.has(edge.source) && kept.has(edge.target));
    return Object.assign({}, view, { boxes, nodes, edges });
  }

  // A node itself, the nodes in a box, or the ends of an edge.
  function nodesOf(view, id) {
    if (view.nodes.some((node) => node.id === id)) return [id];
    if (view.boxes.some((box) => box.id === id)) {
      const inside = new Set([id]);
      for (const box of view.boxes) if (inside.has(box.parent)) inside.add(box.id);
      return view.nodes.filter((node) => inside.has(node.box)).map((node) => node.id);
    }
    const edge = view.edges.find((item) => item.id === id || item.also === id);
    return edge ? [edge.source, edge.target] : [];
  }

  // Lay out what ELK lays out and arrange what was arranged, inner sheets first.
  async function sheetsOf(plan, run) {
    const laid = new Map(), sizes = new Map();
    for (const id of [...plan.order].reverse()) {
      if (plan.sheets.get(id).arranged) await arrange(plan, id, laid, sizes, run);
    }
    if (!plan.sheets.get("").arranged) laid.set("", await run(NetPieces.graph(plan, "", sizes)));
    return { laid, sizes };
  }

  async function arrange(plan, id, laid, sizes, run) {
    const sheet = plan.sheets.get(id), items = [];
    for (const { id: child } of sheet.members) {
      let item = plan.items.get(child);
      if (plan.sheets.has(child)) {
        if (!sheet.free.has(child) && !plan.sheets.get(child).arranged) {
          const wrapped = await run({ id: " one", children: [NetPieces.graph(plan, child, sizes)], layoutOptions: { "elk.hierarchyHandling": "SEPARATE_CHILDREN" } });
          laid.set(child, wrapped.children[0]);
          sizes.set(child, wrapped.children[0]);
        }
        if (sizes.has(child)) item = Object.assign({}, item, { open: [sizes.get(child).width, sizes.get(child).height] });
      }
      items.push(item);
    }
    const free = sheet.free.size ? await run(NetPieces.freeGraph(plan, id, sizes)) : null;
    const { blocks, parts } = free ? NetBlocks.split(free, sheet.links, plan.items) : { blocks: [], parts: [] };
    const bends = sheet.lines.filter((line) => line.bent).flatMap((line) => line.edge.bends);
    const placed = NetStored.place(items, sheet.box, blocks, bends);
    NetBlocks.move(parts, placed.at);
    sizes.set(id, { ...placed, free, ports: NetBlocks.ports(sheet, placed) });
  }

  // Everything's place in the picture: areas of items, ends of ports, paths of what ELK laid out.
  function places(plan, laid, sizes) {
    const found = { at: new Map(), ports: new Map(), paths: new Map(), sides: new Map() };
    for (const sheet of plan.sheets.values()) for (const port of sheet.ports) found.sides.set(port.id, port.side);
    function inside(id, x, y) {
      if (!plan.sheets.get(id).arranged) return walk(laid.get(id), x, y);
      const { at, free } = sizes.get(id);
      if (free) walk(free, x, y);
      for (const [child, centre] of at) {
        if (found.at.has(child)) continue;
        const open = plan.sheets.has(child), { width, height } = open ? sizes.get(child) : plan.items.get(child);
        put(child, { ...((laid.get(child) || {})), x: centre.x - width / 2, y: centre.y - height / 2, width, height }, x, y);
      }
      return undefined;
    }
    function put(id, child, x, y) {
      const at = { x: x + child.x, y: y + child.y, width: child.width, height: child.height };
      found.at.set(id, at);
      for (const port of child.ports || []) found.ports.set(port.id, { x: at.x + port.x, y: at.y + port.y });
      if (!plan.sheets.has(id)) return;
      if (plan.sheets.get(id).arranged) inside(id, at.x, at.y);
      else walk(child, at.x, at.y);
    }
    function walk(item, x, y) {
      for (const child of item.children || []) put(child.id, child, x, y);
      for (const edge of item.edges || []) {
        const section = (edge.sections || [])[0];
        if (!section) continue;
        const points = [section.startPoint, ...(section.bendPoints || []), section.endPoint];
        const label = (edge.labels || [])[0];
        found.paths.set(edge.id, {
          points: points.map((point) => [x + point.x, y + point.y]),
          label: label && [x + label.x + label.width / 2, y + label.y + label.height / 2],
        });
      }
    }
    inside("", 0, 0);
    return found;
  }

  function positioned(view, plan, laid, sizes) {
    const found = places(plan, laid, sizes);
    const whole = plan.sheets.get("").arranged ? sizes.get("") : laid.get("");
    const round = (value) => Math.round(value * 10) / 10;
    const boxes = view.boxes.map((box) => {
      const at = found.at.get(box.id);
      return Object.assign({}, box, { x: round(at.x), y: round(at.y), width: round(at.width), height: round(at.height) });
    });
    const nodes = view.nodes.map((node) => {
      const at = found.at.get(node.id);
      return Object.assign({}, node, { x: round(at.x + at.width / 2), y: round(at.y + at.height / 2) });
    });
    const shapes = new Map(nodes.map((node) => [node.id, node]));
    const picture = Object.assign({}, view, { width: round(whole.width), height: round(whole.height), boxes, nodes });
    NetDrawn.route(picture, plan, sizes, found);
    const edges = view.edges.map((edge) => {
      const { pieces, back } = plan.chains.get(edge.id);
      let points = [], label;
      for (const { id, flip } of pieces) {
        const path = found.paths.get(id);
        if (!path) continue;
        points.push(...(flip ? [...path.points].reverse() : path.points));
        label = label || path.label;
      }
      if (back) points.reverse();
      points = simplified(points);
      meetShape(points, shapes.get(edge.source), true);
      meetShape(points, shapes.get(edge.target), false);
      const made = Object.assign({}, edge, { points: points.map(([px, py]) => [round(px), round(py)]) });
      if (label) made.labelAt = label.map(round);
      return made;
    });
    picture.edges = edges;
    NetDrawn.label(picture, plan);
    return picture;
  }

  // Without points on the way from one to the next.
  function simplified(points) {
    const kept = [];
    for (const point of points) {
      const last = kept[kept.length - 1], before = kept[kept.length - 2];
      if (last && Math.abs(last[0] - point[0]) < 0.05 && Math.abs(last[1] - point[1]) < 0.05) continue;
      const along = (axis) => before && Math.abs(before[axis] - last[axis]) < 0.05 && Math.abs(last[axis] - point[axis]) < 0.05;
      const turns = (axis) => (point[axis] - last[axis]) * (last[axis] - before[axis]) < 0;
      if ((along(0) && !turns(1)) || (along(1) && !turns(0))) kept.pop();
      kept.push(point);
    }
    return kept;
  }

  // The router ends lines at the square around a circle; they go on to the circle.
  function meetShape(points, node, first) {
    if (!node || !/^place/.test(node.kind) || points.length < 2) return;
    const end = first ? 0 : points.length - 1;
    const point = points[end], radius = node.width / 2;
    const next = points[first ? 1 : end - 1];
    const flat = Math.abs(point[1] - next[1]) <= Math.abs(point[0] - next[0]);
    const off = Math.min(Math.abs(flat ? point[1] - node.y : point[0] - node.x), radius * 0.95);
    const reach = Math.sqrt(radius * radius - off * off);
    points[end] = flat
      ? [node.x + Math.sign(point[0] - node.x) * reach, point[1]]
      : [point[0], node.y + Math.sign(point[1] - node.y) * reach];
  }

  async function layout(view, elk) {
    const seen = visible(view), plan = NetPieces.cut(seen);
    // Where everything was arranged, there is nothing to lay out.
    const run = (graph) => (elk || (elk = new ELK())).layout(graph);
    const { laid, sizes } = await sheetsOf(plan, run);
    return positioned(seen, plan, laid, sizes);
  }

  return { visible, around, layout };
})();
