// What happens in one step: in the panel for the cursor, and in short beside the mouse.
(function (T) {
  "use strict";
  const { make } = T;

  function changes(data, step) {
    const coded = data.steps[step].c || [], after = data.marking(step), found = [];
    for (let i = 0; i < coded.length; i += 2) {
      const now = after.get(coded[i]) || 0;
      found.push({ place: data.places[coded[i]], inner: !data.inModel(data.places[coded[i]]), tokens: coded[i + 1], before: now - coded[i + 1], after: now });
    }
    return found.sort((a, b) => a.inner - b.inner || a.tokens - b.tokens);
  }

  const signed = (value) => (value > 0 ? `+${value}` : `−${-value}`);
  const clock = (seconds) => new Date(seconds * 1000).toLocaleTimeString([], { hour12: false }) + (seconds % 1).toFixed(3).slice(1);

  function clauseOf(data, step) {
    const clause = data.clause(step);
    if (!clause) return null;
    const parts = [];
    clause.disjunctions.forEach((literals, i) => {
      if (i) parts.push(make("span", { class: "and" }, " ∧ "));
      if (literals.length > 1) parts.push("(");
      literals.forEach((literal, j) => {
        if (j) parts.push(" ∨ ");
        const state = literal.value === null ? "value unknown" : `${literal.signal} is ${literal.value}`;
        const since = literal.since >= 0 ? ` since step ${literal.since + 1}` : literal.value === null ? "" : " from the start";
        parts.push(make("span", { class: `literal ${literal.holds ? "holds" : literal.holds === false ? "fails" : ""}${literal.deciding ? " deciding" : ""}`, title: state + since },
          `${literal.holds ? "✓" : literal.holds === false ? "✗" : "?"}${literal.negated ? "¬" : ""}${literal.signal}`));
      });
      if (literals.length > 1) parts.push(")");
    });
    const deciding = clause.disjunctions.flat().find((literal) => literal.deciding);
    const why = deciding && make("p", { class: "why" }, "decided by ", make("b", {}, `${deciding.negated ? "¬" : ""}${deciding.signal}`),
      deciding.since >= 0 ? `, since step ${deciding.since + 1}` : ", from the start");
    return make("div", { class: "clause" }, make("h3", {}, "Clause"), make("p", { title: clause.text }, ...parts), why);
  }

  function fields(data, step) {
    const details = data.steps[step].d || {};
    const rows = [];
    const add = (name, value) => rows.push(make("dt", {}, name), make("dd", {}, value));
    if (details.handlers) add("handlers", details.handlers.join(", "));
    if (details.duration !== undefined) add("took", T.seconds(details.duration));
    for (const name of ["error", "handler", "policy", "attempt", "instance", "message", "source", "reason", "stage"]) {
      if (details[name] !== undefined) add(name, String(details[name]));
    }
    if (details.taken) add("taken", Object.entries(details.taken).map(([place, ids]) => `${place}: ${ids.map((id) => `#${id}`).join(" ")}`).join("; "));
    const tokens = details.made ? Object.entries(details.made).flatMap(([place, made]) => made.map(([id, content]) => [`${place} #${id}`, content])) : [];
    if (details.data) tokens.push([details.token !== undefined ? `token #${details.token}` : "token", details.data]);
    for (const [name, content] of tokens) add(name, make("code", {}, JSON.stringify(content, null, 1).replace(/\n\s*/g, " ")));
    return rows.length ? make("dl", {}, ...rows) : null;
  }

  /** The panel of one trace at a step. */
  T.detailOf = function (app, number, step) {
    const data = app.traces[number];
    const side = app.traces.length > 1 ? `${"AB"[number]}: ` : "";
    if (!data.length) return make("div", {}, make("h2", {}, `${side}no step yet`));
    if (step < 0) return make("div", {}, make("h2", {}, `${side}before the first step`), T.causeOf(data, step));
    if (step >= data.length) return make("div", {}, make("h2", {}, `${side}has ended after ${data.length} steps`));
    const one = data.steps[step], node = data.node(step), transition = data.transition(step);
    const where = [one.e, node || "inside a channel"];
    if (one.w !== undefined) where.push(`${clock(one.w)} (+${T.seconds(data.times[step])})`);
    if (data.loop !== null && data.loop !== undefined) where.push(step >= data.loop ? "in the loop ↻" : "in the stem");
    const table = changes(data, step);
    return make("div", { class: one.e === "drop" || one.e === "error" ? "alarm" : "" },
      make("h2", {}, `${side}step ${step + 1} of ${data.length}`),
      make("p", { class: "text" }, data.text(step)),
      make("p", { class: "where" }, where.join(" · ")),
      transition && transition !== data.text(step) && make("p", { class: "where" }, `transition ${transition}`),
      clauseOf(data, step),
      T.causeOf(data, step),
      table.length ? make("table", {}, make("tbody", {}, ...table.map((row) => make("tr", { class: `${row.tokens < 0 ? "lost" : "gained"}${row.inner ? " inner" : ""}` },
        make("td", {}, signed(row.tokens)), make("td", {}, row.place), make("td", {}, `${row.before} → ${row.after}`))))) : null,
      fields(data, step));
  };

  T.fillTip = function (tip, app, step, row) {
    const number = row ? row.trace : 0, data = app.traces[number];
    if (step >= data.length) return tip.replaceChildren("this trace has ended");
    const lines = [make("b", {}, `${step + 1}  ${data.text(step)}`)];
    const node = data.node(step), time = data.timed ? ` · +${T.seconds(data.times[step])}` : "";
    lines.push(make("div", {}, `${node || "inside a channel"}${time}`));
    const table = changes(data, step);
    if (table.length) lines.push(make("div", {}, table.filter((one) => !one.inner || table.length < 5).map((one) => `${signed(one.tokens)} ${one.place}`).join(", ")));
    const clause = data.clause(step), deciding = clause && clause.disjunctions.flat().find((literal) => literal.deciding);
    if (deciding) lines.push(make("div", {}, `decided by ${deciding.negated ? "¬" : ""}${deciding.signal}`));
    if (row && row.lane.kind !== "transition" && row.lane.kind !== "client") lines.push(make("div", { class: "level" }, `${row.lane.label} ${row.lane.note || ""}: ${data.level(row.lane, step)}${row.lane.capacity ? ` of ${row.lane.capacity}` : ""}`));
    tip.replaceChildren(...lines);
  };
})((globalThis.DinerosTrace ??= {}));
