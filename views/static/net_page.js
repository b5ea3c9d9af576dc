// The page of a net: shows a view, collapses and expands its pages in place, searches, shows neighbourhoods.
// Works from a file: everything it needs stands in the page.
"use strict";

(function () {
  const byId = (id) => document.getElementById(id);
  const data = (id) => JSON.parse(byId(id).textContent);
  const everything = data("view");
  const WORDS = {
    place: "place", transition: "transition", "place-reference": "reference to a place", "transition-reference": "reference to a transition",
    topic: "topic", service: "service", normal: "arc", read: "read arc", inhibitor: "inhibitor arc", reference: "reference",
    publish: "publishes", subscribe: "receives", request: "request", response: "response", call: "calls the server", return: "server's answer",
    node: "ROS node", page: "page", timer: "timer callback", subscriber: "subscriber callback", server: "server callback", group: "group",
  };
  const SIGNS = { added: "+", removed: "−", changed: "≠" };

  const svg = byId("picture"), hint = byId("hint"), state = byId("state"), side = byId("detail");
  const folded = new Map(everything.boxes.map((box) => [box.id, Boolean(box.collapsed)]));
  let part = null; // {ids, steps} of a neighbourhood
  let picture, drawn, pan, selected = null, working = Promise.resolve();
  const labels = new Map([...everything.boxes.map((box) => [box.id, box.title]), ...everything.nodes.map((node) => [node.id, node.label])]);
  const items = new Map([...everything.edges, ...everything.boxes, ...everything.nodes].map((item) => [item.id, item]));
  for (const edge of everything.edges) if (edge.also) items.set(edge.also, edge);

  // Drawing

  function show(positioned) {
    picture = positioned;
    drawn = NetRenderer.draw(svg, positioned, { highlights: selected ? [selected] : [] });
    for (const group of svg.querySelectorAll("g[data-id]:not(.edge):not(.signal)")) {
      group.setAttribute("tabindex", "0");
      group.setAttribute("role", "button");
      group.setAttribute("aria-label", spoken(items.get(group.dataset.id)));
    }
    if (pan) pan.redrawn(); else pan = NetPan.attach(svg);
    const hidden = everything.nodes.length - positioned.nodes.length;
    say(`${positioned.nodes.length} of ${everything.nodes.length} nodes shown` + (hidden ? "; open a page by its + sign" : "") +
      (part ? `; ${part.steps} steps around ${part.ids.map((id) => labels.get(id) || id).join(", ")}` : ""));
    document.body.dataset.ready = String(Number(document.body.dataset.ready || 0) + 1);
  }

  function relayout(focus) {
    let view = Object.assign({}, everything, {
      boxes: everything.boxes.map((box) => Object.assign({}, box, { collapsed: folded.get(box.id) || undefined })),
    });
    if (part) view = NetLayout.around(view, part.ids, part.steps);
    document.body.classList.add("busy");
    say("laying out …");
    working = working.then(loadElk).then(() => NetLayout.layout(view)).then((positioned) => {
      show(positioned);
      if (focus) go(focus);
    }, (error) => say(`the layout failed: ${error.message}`)).finally(() => document.body.classList.remove("busy"));
    return working;
  }

  async function loadElk() {
    if (typeof ELK !== "undefined") return;
    const packed = Uint8Array.from(atob(byId("elk").textContent.trim()), (letter) => letter.charCodeAt(0));
    const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("gzip"));
    const script = document.createElement("script");
    script.textContent = await new Response(stream).text();
    document.head.append(script);
  }

  const say = (text) => { state.textContent = text; };

  // Detail

  const heading = (item) => item.title || item.label || item.id;

  function facts(item) {
    const found = [["Id", item.id]];
    if (item.summary) found.push(["Holds", item.summary]);
    if (item.tokens !== undefined) found.push(["Tokens", item.tokens]);
    if (item.source !== undefined) found.push(["From", labels.get(item.source)], ["To", labels.get(item.target)]);
    if (item.weight !== undefined) found.push(["Weight", item.weight]);
    if (item.source !== undefined && item.label) found.push(["Label", item.label]);
    for (const signal of item.signals || []) found.push(["Signal " + signal.label, `starts ${Boolean(signal.initial)}`]);
    for (const [name, text] of Object.entries(item.detail || {})) found.push([name, text]);
    if (item.change) found.push(["Change", [item.change, ...(item.notes || [])].join("; ")]);
    return found;
  }

  const spoken = (item) => `${WORDS[item.kind]} ${heading(item)}` + (item.tokens ? `, ${item.tokens} tokens` : "") + (item.change ? `, ${item.change}` : "");

  function element(tag, text, attributes) {
    const made = Object.assign(document.createElement(tag), attributes);
    if (text !== undefined) made.textContent = text;
    return made;
  }

  function describe(item) {
    side.replaceChildren(element("h2", heading(item)), element("div", WORDS[item.kind], { className: "kind" }));
    const list = element("dl");
    for (const [name, text] of facts(item)) list.append(element("dt", name), element("dd", text));
    side.append(list);
    if (item.source === undefined) {
      const row = element("p");
      row.append("Show what is ", ...[1, 2, 3].map((steps) => element("button", String(steps), { onclick: () => showAround([item.id], steps) })), " steps around it");
      side.append(row);
      neighbours(item.id, side);
    }
    if (folded.has(item.id)) {
      side.append(element("button", folded.get(item.id) ? "Expand" : "Collapse", { onclick: () => toggle(item.id) }));
    }
  }

  function neighbours(id, place) {
    for (const [title, from, to] of [["Comes from", "target", "source"], ["Goes to", "source", "target"]]) {
      const list = element("ul");
      for (const edge of everything.edges) {
        if (edge[from] !== id) continue;
        const line = element("li");
        line.append(element("button", `${labels.get(edge[to])} (${WORDS[edge.kind]}${edge.label ? ", " + edge.label : ""})`, { onclick: () => find(edge[to]) }));
        list.append(line);
      }
      if (list.children.length) place.append(element("dt", title), list);
    }
  }

  function select(id) {
    selected = id;
    drawn.highlight(id ? [id] : []);
    side.hidden = !id && !hasChanges;
    if (id) describe(items.get(id));
    else if (hasChanges) listChanges();
  }

  // Going about

  function go(id) {
    const shape = picture.nodes.find((node) => node.id === id) || picture.boxes.find((box) => box.id === id);
    if (!shape) return;
    if (shape.title === undefined) pan.show(shape.x - shape.width / 2, shape.y - shape.height / 2, shape.width, shape.height);
    else pan.show(shape.x, shape.y, shape.width, shape.height);
  }

  // Show an element, opening what hides it.
  function find(id) {
    const item = items.get(id);
    if (!item) return;
    let opened = false;
    if (part && !picture.nodes.some((node) => node.id === id) && !picture.boxes.some((box) => box.id === id)) {
      part = null;
      opened = true;
    }
    const boxes = new Map(everything.boxes.map((box) => [box.id, box]));
    const node = item.source !== undefined ? items.get(item.source) : item;
    for (let box = node.box || node.parent; box !== undefined && box !== null; box = boxes.get(box).parent) {
      if (folded.get(box)) {
        folded.set(box, false);
        opened = true;
      }
    }
    const finish = () => { select(id); go(node.id); };
    if (opened) relayout().then(finish); else finish();
  }

  function toggle(id) {
    folded.set(id, !folded.get(id));
    if (part) part = null;
    relayout().then(() => {
      const group = drawn.element(id);
      if (group) group.focus({ preventScroll: true });
      if (selected === id) describe(items.get(id));
    });
  }

  function foldAll(value) {
    for (const id of folded.keys()) folded.set(id, value);
    part = null;
    relayout();
  }

  function showAround(ids, steps) {
    part = { ids, steps };
    byId("steps").value = steps;
    relayout();
  }

  function showEverything() {
    part = null;
    relayout();
  }

  // Changes between two models

  const changes = [...everything.boxes, ...everything.nodes, ...everything.edges].filter((item) => item.change);
  const hasChanges = Boolean(everything.compared);

  function listChanges() {
    side.hidden = false;
    side.replaceChildren(element("h2", changes.length ? `${changes.length} differences` : "no differences"));
    const list = element("ul");
    for (const item of changes) {
      const name = item.source === undefined ? heading(item) : `${labels.get(item.source)} → ${labels.get(item.target)}`;
      const button = element("button", undefined, { onclick: () => find(item.id) });
      button.append(element("span", SIGNS[item.change], { className: `sign ${item.change}` }), ` ${WORDS[item.kind]} ${name}`);
      if (item.notes) button.append(element("div", item.notes.join("; "), { className: "kind" }));
      const line = element("li");
      line.append(button);
      list.append(line);
    }
    side.append(list);
  }

  function nextChange(by) {
    if (!changes.length) return;
    const at = changes.findIndex((item) => item.id === selected);
    find(changes[(at + by + changes.length + (at < 0 && by < 0 ? 1 : 0)) % changes.length].id);
  }

  // Search

  const search = byId("search"), results = byId("search-list");
  let chosen = 0, matches = [];

  function matching(text) {
    const wanted = text.trim().toLowerCase();
    if (!wanted) return [];
    const texts = (item) => [heading(item), item.id, ...Object.values(item.detail || {})].map((one) => one.toLowerCase());
    const rank = (item) => {
      const found = texts(item);
      if (found[0] === wanted || found[1] === wanted) return 0;
      if (found[0].startsWith(wanted) || found[1].startsWith(wanted)) return 1;
      return found[0].includes(wanted) || found[1].includes(wanted) ? 2 : found.some((one) => one.includes(wanted)) ? 3 : 4;
    };
    return [...everything.boxes, ...everything.nodes].map((item) => [rank(item), item]).filter(([value]) => value < 4)
      .sort((a, b) => a[0] - b[0]).map(([, item]) => item);
  }

  function listMatches() {
    matches = matching(search.value);
    chosen = Math.min(chosen, Math.max(matches.length - 1, 0));
    results.replaceChildren(...matches.slice(0, 30).map((item, index) => {
      const line = element("li", heading(item), { onmousedown: (event) => { event.preventDefault(); choose(index); } });
      line.setAttribute("role", "option");
      line.setAttribute("aria-selected", String(index === chosen));
      line.append(element("small", WORDS[item.kind] + (item.id === heading(item) ? "" : ` ${item.id}`)));
      return line;
    }));
    results.hidden = !matches.length;
    if (search.value.trim()) say(matches.length ? `${matches.length} found` : "nothing found");
  }

  function choose(index) {
    results.hidden = true;
    svg.focus({ preventScroll: true });
    if (matches[index]) find(matches[index].id);
  }

  search.addEventListener("input", () => { chosen = 0; listMatches(); });
  search.addEventListener("blur", () => { results.hidden = true; });
  search.addEventListener("keydown", (event) => {
    const step = { ArrowDown: 1, ArrowUp: -1 }[event.key];
    if (step) {
      chosen = Math.max(0, Math.min(matches.length - 1, chosen + step));
      listMatches();
    } else if (event.key === "Enter") choose(chosen);
    else if (event.key === "Escape") { search.value = ""; listMatches(); svg.focus(); }
    else return;
    event.preventDefault();
    event.stopPropagation();
  });

  // Pointer and keys

  const groupAt = (event) => event.target.closest && event.target.closest("#picture g[data-id]");

  svg.addEventListener("click", (event) => {
    const group = groupAt(event);
    if (!group) return select(null);
    const id = group.dataset.id;
    if (event.target.closest(".fold")) return toggle(id);
    if (items.has(id)) select(id);
    return undefined;
  });
  svg.addEventListener("dblclick", (event) => {
    const group = groupAt(event);
    if (group && folded.has(group.dataset.id)) toggle(group.dataset.id);
  });
  svg.addEventListener("pointermove", (event) => {
    const group = event.buttons ? null : groupAt(event);
    const item = group && items.get(group.dataset.id);
    hint.hidden = !item;
    if (!item) return;
    const stands = picture.edges.find((edge) => edge.id === item.id && edge.stands && edge.stands.length > 1);
    const lines = facts(item).filter(([name]) => name !== "Id" || heading(item) !== item.id).map(([name, text]) => element("div", `${name}: ${text}`));
    hint.replaceChildren(element("b", stands ? `${stands.stands.length} lines` : item.source !== undefined ? WORDS[item.kind] : heading(item)),
      ` ${item.source === undefined ? WORDS[item.kind] : ""}`, ...lines);
    const right = Math.min(event.clientX + 14, window.innerWidth - hint.offsetWidth - 8);
    const down = event.clientY + 16 + hint.offsetHeight > window.innerHeight ? event.clientY - hint.offsetHeight - 10 : event.clientY + 16;
    hint.style.left = `${Math.max(4, right)}px`;
    hint.style.top = `${Math.max(4, down)}px`;
  });
  svg.addEventListener("pointerleave", () => { hint.hidden = true; });

  const KEYS = {
    ArrowLeft: () => pan.move(-0.1, 0), ArrowRight: () => pan.move(0.1, 0), ArrowUp: () => pan.move(0, -0.1), ArrowDown: () => pan.move(0, 0.1),
    "+": () => pan.zoom(1.25), "=": () => pan.zoom(1.25), "-": () => pan.zoom(0.8), 0: () => pan.fit(),
    "/": () => search.focus(), f: () => search.focus(), a: () => selected && showAround([selected], Number(byId("steps").value)),
    e: showEverything, x: () => foldAll(false), c: () => foldAll(true), n: () => nextChange(1), p: () => nextChange(-1),
    "?": () => byId("help").showModal(), Escape: () => select(null),
  };
  document.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey || /^(INPUT|SELECT|TEXTAREA)$/.test(event.target.tagName) || byId("help").open) return;
    const group = groupAt(event);
    if (group && (event.key === "Enter" || event.key === " ")) {
      if (folded.has(group.dataset.id) && event.key === " ") toggle(group.dataset.id);
      else select(group.dataset.id);
    } else if (event.target.tagName === "BUTTON" && (event.key === "Enter" || event.key === " ")) return;
    else if (KEYS[event.key]) KEYS[event.key]();
    else return;
    event.preventDefault();
  });

  byId("around").addEventListener("click", () => {
    if (selected) showAround([selected], Number(byId("steps").value));
    else say("choose an element first: click it, or search for it");
  });
  byId("everything").addEventListener("click", showEverything);
  byId("expand").addEventListener("click", () => foldAll(false));
  byId("collapse").addEventListener("click", () => foldAll(true));
  byId("fit").addEventListener("click", () => pan.fit());
  byId("keys").addEventListener("click", () => byId("help").showModal());

  const dark = matchMedia("(prefers-color-scheme: dark)"), theme = byId("theme");
  const paint = () => { document.body.dataset.theme = theme.value === "auto" ? (dark.matches ? "dark" : "light") : theme.value; };
  theme.addEventListener("change", paint);
  dark.addEventListener("change", paint);
  paint();

  show(data("positioned"));
  if (hasChanges) listChanges();
})();
