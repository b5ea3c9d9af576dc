// Which lanes are shown, in which order and where; shared by the page and by figures.
(function (T) {
  "use strict";

  T.GROUPS = [
    ["property", "Property"], ["signals", "Signals"], ["topics", "Topics"], ["services", "Services"], ["transitions", "Transitions"],
  ];

  /** Whether anything ever happens on a lane. */
  T.idle = (lane) => !lane.at.length && lane.kind !== "place";

  /** A filter: words that must all occur; `a|b` is one or the other; `-word` must not. */
  T.filterOf = function (text) {
    const words = text.trim().toLowerCase().split(/\s+/).filter(Boolean);
    return (lane, heading) => {
      const said = `${lane.id} ${lane.label} ${lane.note || ""} ${lane.node || ""} ${lane.channel || ""} ${heading}`.toLowerCase();
      return words.every((word) => word.startsWith("-") && word.length > 1
        ? !said.includes(word.slice(1))
        : word.split("|").some((part) => part && said.includes(part)));
    };
  };

  /**
   * Rows from top to bottom.
   * @param {T.Data[]} traces one, or two to compare
   * @param {{filter?: string, closed?: Set<string>, open?: Set<string>, nodes?: Set<string>, hidden?: Set<string>}} options
   *   `closed`: headings folded; `open`: groups whose idle lanes are shown; `nodes`: node nets left out; `hidden`: keys of lanes
   */
  T.rowsOf = function (traces, options = {}) {
    const matches = T.filterOf(options.filter || "");
    const rows = [];
    let y = 0;
    const push = (row, height) => { rows.push({ ...row, y, height }); y += height; };
    const groups = new Map(); // group -> key -> the lanes of this key, by trace; the first trace says which group
    const groupOf = new Map();
    traces.forEach((data, number) => {
      for (const lane of data.lanes) {
        const key = T.laneKey(lane);
        if (!groupOf.has(key)) groupOf.set(key, lane.group);
        const group = groupOf.get(key);
        if (!groups.has(group)) groups.set(group, new Map());
        if (!groups.get(group).has(key)) groups.get(group).set(key, []);
        groups.get(group).get(key)[number] = lane;
      }
    });
    for (const [group, heading] of T.GROUPS) {
      const seen = groups.get(group) || new Map();
      const keys = [...seen.keys()].filter((key) => {
        const lane = seen.get(key).find(Boolean);
        return matches(lane, heading) && !(options.hidden && options.hidden.has(key)) && !(options.nodes && options.nodes.has(lane.node || ""));
      });
      if (group === "transitions") {
        const order = (key) => { const lane = seen.get(key).find(Boolean); const node = traces[0].nodes.indexOf(lane.node || ""); return node < 0 ? 1e6 : node; };
        keys.sort((a, b) => order(a) - order(b));
      }
      const idle = keys.filter((key) => seen.get(key).every((lane) => !lane || T.idle(lane)));
      const silent = group === "transitions" ? traces[0].silent().filter((name) => matches({ id: name, label: name }, heading)) : [];
      if (!keys.length && !silent.length) continue;
      const closed = Boolean(options.closed && options.closed.has(group));
      const open = Boolean(options.open && options.open.has(group));
      push({ type: "heading", group, label: heading, count: keys.length - idle.length, closed }, T.HEIGHTS.heading);
      if (closed) continue;
      for (const key of keys) {
        if (!open && idle.includes(key)) continue;
        traces.forEach((data, number) => {
          const lane = seen.get(key)[number];
          const shown = lane || { ...seen.get(key).find(Boolean), at: [], marks: [], calls: [], initial: 0, absent: true };
          push({ type: "lane", group, key, lane: shown, trace: number }, T.HEIGHTS[shown.kind]);
        });
      }
      const quiet = idle.length + silent.length;
      if (quiet) push({ type: "silent", group, open, count: quiet, names: silent }, T.HEIGHTS.transition);
      if (quiet && open) for (const name of silent) push({ type: "name", group, label: name }, T.HEIGHTS.transition);
    }
    return { rows, height: y };
  };
})((globalThis.DinerosTrace ??= {}));
