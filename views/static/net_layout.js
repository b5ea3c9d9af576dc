// Layout of a net view: which boxes and edges are visible, and where they go. Runs in browsers and, through
// mini-racer, inside Python; needs the globals ELK (elkjs), NetOrder and NetStored.
//
// NetLayout.visible(view)             what is left when collapsed boxes hide their content
// NetLayout.around(view, ids, steps)  the neighbourhood of some elements
// NetLayout.layout(view)              a promise of the positioned picture: the visible part with coordinates
"use strict";

var NetLayout = (function () {
  const SPACE = { node: 22, layer: 34, edge: 9, padding: 14 };
  // What makes small pictures read in the order of the model takes minutes for large ones.
  const MANY = 150;
  const SMALL = {
    "elk.layered.nodePlacement.strategy": "NETWORK_SIMPLEX",
    "elk.layered.considerModelOrder.strategy": "PREFER_NODES",
    "elk.layered.considerModelOrder.crossingCounterNodeInfluence": "0.1",
    "elk.layered.considerModelOrder.components": "MODEL_ORDER",
  };
  const LARGE = { "elk.layered.nodePlacement.strategy": "BRANDES_KOEPF" };

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

  function toElk(view) {
    const around = NetOrder.nesting(view);
    const { children, turned } = NetOrder.order(view, around);
    const nodes = new Map(view.nodes.map((node) => [node.id, node]));
    const boxes = new Map(view.boxes.map((box) => [box.id, box]));
    const large = view.nodes.length > MANY;
    const containers = new Map(), stored = new Map();
    const touching = new Map(view.nodes.map((node) => [node.id, []]));
    for (const edge of view.edges) {
      if (touching.has(edge.source)) touching.get(edge.source).push(edge.target);
      if (touching.has(edge.target)) touching.get(edge.target).push(edge.source);
    }
    function arrangement(inner, box) {
      const ids = new Set(inner.map((node) => node.id));
      const bends = view.edges.filter((edge) => edge.bends && ids.has(edge.source) && ids.has(edge.target)).flatMap((edge) => edge.bends);
      return NetStored.arrangement(inner, box ? box.header : [0, 0], (node) => touching.get(node), bends);
    }
    function container(id) {
      const box = boxes.get(id);
      const inner = children.get(id).map((child) => nodes.get(child));
      const kept = inner.every(Boolean) && arrangement(inner, box);
      if (kept) {
        stored.set(id, { ...kept, lines: [], ports: new Map() });
        const made = { id: id === "" ? " root" : id, width: kept.width, height: kept.height, ports: [], layoutOptions: { "elk.portConstraints": "FIXED_POS" } };
        containers.set(id, made);
        return made;
      }
      const made = {
        id: id === "" ? " root" : id,
        children: [],
        edges: [],
        ports: [],
        layoutOptions: {
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
          ...(large ? LARGE : SMALL),
          "elk.padding": box
            ? "[top=" + (box.header[1] + 10) + ",left=16,bottom=14,right=16]"
            : "[top=16,left=16,bottom=16,right=16]",
        },
      };
      if (box) {
        made.layoutOptions["elk.portConstraints"] = "FIXED_SIDE";
        made.layoutOptions["elk.nodeSize.constraints"] = "MINIMUM_SIZE PORTS";
        made.layoutOptions["elk.nodeSize.minimum"] = "(" + (box.header[0] + 8) + "," + (box.header[1] + 20) + ")";
      }
      containers.set(id, made);
      for (const child of children.get(id)) {
        if (nodes.has(child)) made.children.push(leaf(nodes.get(child)));
        else if (boxes.get(child).collapsed) made.children.push(leaf(boxes.get(child)));
        else made.children.push(container(child));
      }
      return made;
    }
    function leaf(item) {
      const made = { id: item.id, width: item.width, height: item.height };
      if (item.room && item.room[0]) {
        made.labels = [{ id: item.id + " label", text: " ", width: item.room[0], height: item.room[1] }];
        made.layoutOptions = { "elk.nodeLabels.placement": "OUTSIDE V_BOTTOM H_CENTER" };
      }
      return made;
    }
    const root = container("");
    const chains = new Map();
    view.edges.forEach((edge, number) => {
      const { depth, from, to } = NetOrder.ends(edge, around);
      // In the direction of the layout.
      const back = Boolean(NetOrder.BACKWARDS[edge.kind]) !== turned.has(edge.id);
      const start = back ? to : from, end = back ? from : to;
      const pieces = [];
      let point = start[start.length - 1];
      for (let level = start.length - 1; level > depth; level -= 1) {
        const box = containers.get(start[level - 1]);
        const port = "port " + number + " out " + level;
        box.ports.push({ id: port, width: 0, height: 0, layoutOptions: { "elk.port.side": "EAST" } });
        pieces.push([start[level - 1], point, port]);
        point = port;
      }
      const later = [];
      let last = end[end.length - 1];
      for (let level = end.length - 1; level > depth; level -= 1) {
        const box = containers.get(end[level - 1]);
        const port = "port " + number + " in " + level;
        box.ports.push({ id: port, width: 0, height: 0, layoutOptions: { "elk.port.side": "WEST" } });
        later.unshift([end[level - 1], port, last]);
        last = port;
      }
      pieces.push([depth ? from[depth - 1] : "", point, last]);
      const middle = pieces.length - 1;
      pieces.push(...later);
      pieces.forEach(([owner, source, target], index) => {
        if (stored.has(owner)) {
          stored.get(owner).lines.push({ id: "edge " + number + " " + index, source, target, edge, back, labelled: index === middle && edge.label });
          return;
        }
        const made = { id: "edge " + number + " " + index, sources: [source], targets: [target] };
        if (index === middle && edge.label) {
          made.labels = [{ id: made.id + " label", text: edge.label, width: edge.room[0], height: edge.room[1] }];
          made.layoutOptions = { "elk.edgeLabels.placement": "CENTER" };
        }
        containers.get(owner).edges.push(made);
      });
      chains.set(edge.id, { number, count: pieces.length, back });
    });
    for (const [id, page] of stored) fixPorts(containers.get(id), page);
    return { root, chains, stored };
  }

  // Ports of a page with stored positions stand as high as the nodes they lead to.
  function fixPorts(container, page) {
    for (const side of ["WEST", "EAST"]) {
      const ports = container.ports.filter((port) => port.layoutOptions["elk.port.side"] === side);
      const height = (port) => {
        const line = page.lines.find(({ source, target }) => source === port.id || target === port.id);
        return page.at.get(line.source === port.id ? line.target : line.source).y;
      };
      const wanted = ports.map((port) => [height(port), port]).sort((a, b) => a[0] - b[0]);
      let above = -Infinity;
      for (const [y, port] of wanted) {
        above = Math.max(y, above + 9);
        Object.assign(port, { x: side === "WEST" ? 0 : page.width, y: above });
        page.ports.set(port.id, port);
      }
    }
  }

  function positioned(view, root, chains, stored) {
    const places = new Map(), paths = new Map();
    const known = new Map(view.nodes.map((node) => [node.id, node]));
    (function walk(item, x, y) {
      for (const child of item.children || []) {
        const at = { x: x + child.x, y: y + child.y, width: child.width, height: child.height };
        places.set(child.id, at);
        walk(child, at.x, at.y);
      }
      for (const edge of item.edges || []) {
        const section = (edge.sections || [])[0];
        if (!section) continue;
        const points = [section.startPoint, ...(section.bendPoints || []), section.endPoint];
        const label = (edge.labels || [])[0];
        paths.set(edge.id, {
          points: points.map((point) => [x + point.x, y + point.y]),
          label: label && [x + label.x + label.width / 2, y + label.y + label.height / 2],
        });
      }
      const page = stored.get(item === root ? "" : item.id);
      if (page) drawStored(page, x, y, known, places, paths);
    })(root, 0, 0);
    const round = (value) => Math.round(value * 10) / 10;
    const boxes = view.boxes.map((box) => {
      const at = places.get(box.id);
      return Object.assign({}, box, { x: round(at.x), y: round(at.y), width: round(at.width), height: round(at.height) });
    });
    const nodes = view.nodes.map((node) => {
      const at = places.get(node.id);
      return Object.assign({}, node, { x: round(at.x + at.width / 2), y: round(at.y + at.height / 2) });
    });
    const shapes = new Map(nodes.map((node) => [node.id, node]));
    const edges = view.edges.map((edge) => {
      const { number, count, back } = chains.get(edge.id);
      let points = [], label;
      for (let index = 0; index < count; index += 1) {
        const path = paths.get("edge " + number + " " + index);
        if (!path) continue;
        points.push(...path.points);
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
    return Object.assign({}, view, { width: round(root.width), height: round(root.height), boxes, nodes, edges });
  }

  function drawStored(page, x, y, known, places, paths) {
    for (const [id, at] of page.at) {
      const { width, height } = known.get(id);
      places.set(id, { x: x + at.x - width / 2, y: y + at.y - height / 2, width, height });
    }
    const end = (id) => {
      const at = page.at.get(id) || page.ports.get(id);
      return { x: x + at.x, y: y + at.y, item: known.get(id) };
    };
    const between = new Map();
    for (const line of page.lines) {
      const key = [line.source, line.target].sort().join("\n");
      between.set(key, [...(between.get(key) || []), line]);
    }
    for (const lines of between.values()) {
      lines.forEach((line, index) => {
        const aside = (index - (lines.length - 1) / 2) * 10 * (line.source < line.target ? 1 : -1);
        let bends = page.bends(line.edge.bends).map(([bendX, bendY]) => [x + bendX, y + bendY]);
        if (line.back) bends.reverse();
        if (!page.at.has(line.source) || !page.at.has(line.target)) bends = [];
        const points = NetStored.line(end(line.source), end(line.target), bends, bends.length ? 0 : aside);
        const half = Math.floor(points.length / 2);
        const label = line.labelled && [(points[half - 1][0] + points[half][0]) / 2, (points[half - 1][1] + points[half][1]) / 2 - 8];
        paths.set(line.id, { points, label });
      });
    }
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

  function layout(view, elk) {
    const seen = visible(view);
    const { root, chains, stored } = toElk(seen);
    // A picture without pages whose nodes were all arranged leaves nothing to lay out.
    const laidOut = stored.has("") ? Promise.resolve(root) : (elk || new ELK()).layout(root);
    return laidOut.then((result) => positioned(seen, result, chains, stored));
  }

  return { visible, around, layout };
})();
