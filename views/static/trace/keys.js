// The keyboard.
(function (T) {
  "use strict";

  T.KEYS = [
    ["← →", "one step; with Shift ten"], ["Home End", "first, last step"], ["↑ ↓", "choose a lane"], ["[ ]", "mark before, next mark on the chosen lane"],
    ["n N", "next, previous loss or error"],
    ["c", "first cause?"], ["C", "show only what brought the outcome about"], ["b", "set a breakpoint"], [". ,", "run to the next, previous breakpoint"], ["h", "hide the chosen lane"], ["+ − 0", "zoom; all in the window"], ["f", "fold what does not matter"],
    ["t", "firings or wall-clock time"], ["/", "filter lanes"], ["s", "search steps"], ["d", "dark or light"], ["v", "first divergence of two traces"], ["Esc", "leave a field"],
  ];

  T.bindKeys = function (app) {
    const last = () => Math.max(...app.traces.map((data) => data.length)) - 1;
    const move = (to) => app.select(Math.max(-1, Math.min(to, last())));
    const alarm = (direction) => {
      const alarms = app.traces[0].alarms, at = T.lastAtMost(alarms, app.cursor - (direction < 0 ? 1 : 0)) + (direction > 0 ? 1 : 0);
      if (alarms[at] !== undefined) move(alarms[at]);
    };
    const walk = (direction, event) => move(app.onlyCauses && app.traces[0].cause
      ? T.nextCause(app.traces[0], app.cursor, direction) : app.cursor + direction * (event.shiftKey ? 10 : 1));
    const actions = {
      ArrowLeft: (event) => walk(-1, event), ArrowRight: (event) => walk(1, event),
      Home: () => move(0), End: () => move(last()),
      ArrowUp: () => app.chooseNext(-1), ArrowDown: () => app.chooseNext(1),
      "[": () => app.toMark(-1), "]": () => app.toMark(1),
      n: () => alarm(1), N: () => alarm(-1),
      c: () => app.traces[0].cause && move(app.traces[0].cause.first), C: () => app.setOnlyCauses(!app.onlyCauses),
      b: () => app.breakpoints.open(), ".": () => app.breakpoints.jump(1), ",": () => app.breakpoints.jump(-1),
      h: () => app.hideChosen(),
      "+": () => app.view.zoomBy(1.5), "=": () => app.view.zoomBy(1.5), "-": () => app.view.zoomBy(1 / 1.5), 0: () => app.view.fit(),
      f: () => app.setFold(!app.fold), t: () => app.setTime(!app.time),
      d: () => app.setTheme(app.themeName === "dark" ? "light" : "dark"),
      "/": () => document.getElementById("filter").focus(), s: () => document.getElementById("search").focus(),
      v: () => app.divergence && move(app.divergence.a),
      "?": () => document.getElementById("keys").showModal(),
    };
    document.addEventListener("keydown", (event) => {
      if (event.key === "Escape") return document.activeElement.blur();
      if (event.ctrlKey || event.metaKey || event.altKey || /^(INPUT|TEXTAREA|SELECT)$/.test(event.target.tagName)) return undefined;
      const action = actions[event.key];
      if (!action) return undefined;
      event.preventDefault();
      return action(event);
    });
    const list = document.getElementById("keylist");
    for (const [key, what] of T.KEYS) list.append(T.make("dt", {}, key), T.make("dd", {}, what));
  };
})((globalThis.DinerosTrace ??= {}));
