// Where the outcome of a witness may have begun, and the steps that brought it about.
(function (T) {
  "use strict";

  const HINT = "A hint, found from this trace alone: other runs from there may go another way.";

  /** Since when, and up to when, a condition was true, in words. */
  T.spanText = function (data, since, until) {
    if (since === until) return `at step ${since + 1}`;
    const from = since < 0 ? "from the start" : `since step ${since + 1}`;
    return until >= data.length - 1 ? `${from}, to the end` : `${from}, up to step ${until + 1}`;
  };

  /** What decides the outcome, one line for each condition. */
  T.causeLines = (data) => data.cause.decided.map(([text, since, until]) => `${text}: ${T.spanText(data, since, until)}`);

  /** Flag, line and bars of a trace's causes, on the ruler and below the strip of nodes. */
  T.drawCauseFlag = function (view, y, height) {
    const { surface, scale, theme, data } = view;
    if (!data.cause || data.cause.first < 0) return;
    const x = view.dx + scale.left(data.cause.first), said = `first cause? ${data.cause.first + 1}`;
    const wide = T.textWidth(said, 10.5) + 8;
    if (x + wide < view.left - 20 || x > view.left + view.width + 20) return;
    surface.begin("cause", "cause", "first cause?");
    const loop = typeof data.loop === "number" ? view.dx + scale.left(data.loop) : Infinity;
    const overLoop = x <= loop && x + wide > loop && x - wide > view.left; // whose name begins there
    const turned = overLoop || x + wide > view.left + view.width; // the flag blows to the left
    const from = turned ? x - wide : x;
    surface.path([[x, y], [x, y + height]], { stroke: theme.cause, width: 1.8 });
    surface.rect(from, y, wide, 15, { fill: theme.back, stroke: theme.cause, width: 1.2 });
    surface.text(from + 4, y + 11, said, { fill: theme.cause, size: 10.5, bold: true });
    surface.end();
  };

  T.drawCauseLine = function (view, y, height) {
    const { surface, scale, theme, data } = view;
    if (!data.cause || data.cause.first < 0) return;
    const x = view.dx + scale.left(data.cause.first);
    if (x < view.left || x > view.left + view.width) return;
    surface.path([[x, y], [x, y + height]], { stroke: theme.cause, width: 1.4, dash: [2, 3] });
  };

  T.drawCauseBars = function (view, y) {
    const { surface, scale, theme, data } = view;
    if (!data.cause) return;
    surface.begin("causes", "causes", "steps that brought the outcome about");
    let column = -Infinity;
    const steps = data.cause.steps;
    for (let i = Math.max(0, T.lastAtMost(steps, view.from - 1) + 1); i < steps.length && steps[i] <= view.to; i++) {
      const x = view.dx + scale.left(steps[i]), width = scale.right(steps[i]) - scale.left(steps[i]);
      if (x + width - column < 1) continue;
      column = x + width;
      surface.rect(x, y, Math.max(width - (width > 4 ? 0.6 : 0), 0.8), 2.4, { fill: theme.cause });
    }
    surface.end();
  };

  /** Breakpoints that were hit, as stop signs on the ruler. */
  T.drawStops = function (view, stops, y, height) {
    const { surface, scale, theme } = view;
    let column = -Infinity;
    for (let i = Math.max(0, T.lastAtMost(stops, view.from - 1) + 1); i < stops.length && stops[i] <= view.to; i++) {
      const x = view.dx + scale.x(stops[i]);
      if (x - column < 2) continue;
      column = x;
      T.shapes.stop(surface, x, y + height - 4, theme);
    }
  };

  const octagon = (x, y, size) => Array.from({ length: 8 }, (_, i) => [x + size * Math.cos(Math.PI * (i / 4 + 0.125)), y + size * Math.sin(Math.PI * (i / 4 + 0.125))]);
  T.shapes.stop = (surface, x, y, theme) => surface.path(octagon(x, y, 4.6), { fill: theme.alarm, stroke: theme.back, width: 1, closed: true });

  /** The button in the head of a trace. */
  T.causeButton = function (app, number) {
    const data = app.traces[number];
    if (!data.cause) return null;
    const { first } = data.cause;
    return T.make("button", { class: "cause", title: [...T.causeLines(data), HINT].join("\n"), onclick: () => app.select(first) },
      `first cause? ${first < 0 ? "from the start" : `step ${first + 1}`} `, T.make("kbd", {}, "c"));
  };

  /** What the detail of a step says of causes. */
  T.causeOf = function (data, step) {
    const { make } = T;
    if (!data.cause) return null;
    const { first, decided } = data.cause;
    const whole = step === first || step === data.length - 1;
    const shown = whole ? decided : decided.filter(([, since]) => since === step);
    const list = shown.length ? make("ul", {}, ...shown.map(([text, since, until]) => make("li", {}, make("code", {}, text), ` ${T.spanText(data, since, until)}`))) : null;
    const title = step === first ? "First cause?" : step === data.length - 1 ? "What decides the outcome" : shown.length ? "Decides the outcome" : null;
    const past = data.causal.has(step) ? "one of the steps that brought the outcome about" : step >= 0 ? "not needed for the outcome" : null;
    return make("div", { class: "causes" }, title && make("h3", {}, title), list, past && make("p", { class: "where" }, past),
      step === first && make("p", { class: "where" }, HINT));
  };

  /** The next step in a direction that is in the causal past, for moving while only these are shown. */
  T.nextCause = function (data, step, direction) {
    const steps = data.cause.steps, at = T.lastAtMost(steps, direction < 0 ? step - 1 : step) + (direction > 0 ? 1 : 0);
    return steps[at] === undefined ? step : steps[at];
  };
})((globalThis.DinerosTrace ??= {}));
