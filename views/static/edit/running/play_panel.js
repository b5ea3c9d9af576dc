// The panel of a token game: where it is, signals, what is enabled, the steps.

import { make } from "../../elements.js";

/** @import { Player } from "./play.js" */
/** @import { Firing, Game } from "../types.js" */

const SPEEDS = [1, 2, 5, 10, 50, 200];
const VARIANTS = { "fully-enabled": "at any time", "input-enabled": "where something waits for them" };

/** @type {(panel: HTMLElement, player: Player, game: Game) => void} */
export function showGame(panel, player, game) {
  const focused = document.activeElement instanceof HTMLElement ? document.activeElement.dataset.key : null;
  panel.replaceChildren(
    make("h2", {}, "Token game"),
    make(
      "p",
      { class: "quiet" },
      game.title || "Click what is enabled. What fires is the net that find, verify and check ask.",
    ),
    ...stale(player),
    controls(player, game),
    position(player, game),
    ...signals(player, game),
    ...channels(player, game),
    make("h3", {}, "Enabled"),
    firings(player, game),
    make("h3", {}, "Steps"),
    steps(player, game),
    files(player),
  );
  // What is drawn again keeps the focus.
  const same = [...panel.querySelectorAll("[data-key]")].find(
    (each) => each instanceof HTMLElement && each.dataset.key === focused,
  );
  if (same instanceof HTMLElement) same.focus();
}

/** @type {(player: Player) => HTMLElement[]} */
function stale(player) {
  if (!player.isStale) return [];
  const said = make(
    "p",
    { class: "stale", role: "alert" },
    "The model has changed since this game began. ",
    make("button", { onclick: () => player.begin() }, "Begin again"),
  );
  return [said];
}

/** @type {(key: string, words: string, title: string, isOn: boolean, action: () => void, pressed?: boolean) => HTMLButtonElement} */
const button = (key, words, title, isOn, action, pressed) =>
  make(
    "button",
    {
      "data-key": key,
      title,
      disabled: !isOn,
      "aria-label": title,
      "aria-pressed": pressed === undefined ? null : String(pressed),
      onclick: action,
    },
    words,
  );

/** @type {(player: Player, game: Game) => HTMLElement} */
function controls(player, game) {
  const { running } = player;
  const canGo = !player.isStale;
  const hasMore = game.at < game.length || game.loop !== null;
  const speed = make(
    "select",
    { "aria-label": "Steps a second", "data-key": "speed" },
    ...SPEEDS.map((each) => make("option", { value: each, selected: each === player.speed }, `${each}/s`)),
  );
  speed.onchange = () => {
    player.speed = Number(speed.value);
  };
  return make(
    "div",
    { class: "controls", role: "toolbar", "aria-label": "Game" },
    button("first", "|◀", "To the beginning", canGo && game.at > 0, () => player.go(0)),
    button("back", "◀", "One step back (←)", canGo && game.at > 0, () => player.back()),
    button("forward", "▶", "One step forward (→)", canGo && game.at < game.length, () => player.forward()),
    button("last", "▶|", "To the end", canGo && game.at < game.length, () => player.go(game.length)),
    button(
      "steps",
      running === "steps" ? "Pause" : "Play",
      "Play the steps",
      canGo && hasMore,
      () => player.run("steps"),
      running === "steps",
    ),
    button(
      "random",
      running === "random" ? "Pause" : "Random",
      "Fire at random (r)",
      canGo,
      () => player.run("random"),
      running === "random",
    ),
    speed,
    button("end", "End", "End the game (p)", true, () => player.end()),
  );
}

/** @type {(player: Player, game: Game) => HTMLElement} */
function position(player, game) {
  const slider = make("input", {
    type: "range",
    min: 0,
    max: game.length,
    value: game.at,
    "data-key": "slider",
    "aria-label": "Step",
    disabled: player.isStale || game.length === 0,
  });
  slider.onchange = () => player.go(Number(slider.value));
  const follow = make("input", {
    type: "checkbox",
    checked: player.isFollowing,
    "data-key": "follow",
  });
  follow.onchange = () => {
    player.isFollowing = follow.checked;
  };
  const loops = game.loop === null ? "" : `, those from ${game.loop + 1} on forever`;
  return make(
    "div",
    { class: "position" },
    slider,
    make("output", {}, `step ${game.at} of ${game.length}${loops}`),
    make("label", {}, follow, " show where steps are"),
  );
}

/** The values that a signal can get now. @type {(player: Player, game: Game, handle: string, value: string) => HTMLElement} */
function choice(player, game, handle, value) {
  const { model } = player.editor;
  /** By value, what gives it: where several transitions test the signal, the first that is enabled. */
  const changes = new Map(
    game.firings
      .filter(({ kind, elements }) => kind === "signal" && elements[0] === handle)
      .reverse()
      .map((firing) => [String(firing.value), firing.id]),
  );
  const names = model.links(handle, "values").map((each) => model.label(each));
  const options = names.map((name) =>
    make(
      "option",
      { value: name, selected: name === value, disabled: name !== value && !changes.has(name) },
      name,
    ),
  );
  const select = make(
    "select",
    { "data-key": `signal ${handle}`, disabled: changes.size === 0 || player.isStale },
    ...options,
  );
  select.onchange = () => {
    const id = changes.get(select.value);
    if (id !== undefined) player.fire(id);
  };
  return make("label", {}, `${model.label(handle)}: `, select);
}

/** @type {(player: Player, game: Game) => HTMLElement[]} */
function signals(player, game) {
  const { model } = player.editor;
  const known = Object.entries(game.signals).filter(([handle]) => model.objects.has(handle));
  const rows = known.map(([handle, value]) => {
    if (typeof value === "string") return make("li", {}, choice(player, game, handle, value));
    const change = game.firings.find(({ kind, elements }) => kind === "signal" && elements[0] === handle);
    const above = model.get(handle).in;
    return make(
      "li",
      {},
      make(
        "button",
        {
          role: "switch",
          "aria-checked": String(value),
          "data-key": `signal ${handle}`,
          disabled: change === undefined || player.isStale,
          title: above === undefined ? "" : model.label(above),
          onclick: () => change && player.fire(change.id),
        },
        `${model.label(handle)}: ${value}`,
      ),
    );
  });
  const when = make(
    "select",
    { "aria-label": "When signals may change", "data-key": "variant" },
    ...Object.entries(VARIANTS).map(([name, words]) =>
      make("option", { value: name, selected: name === player.signals }, words),
    ),
  );
  when.onchange = () => {
    player.signals = when.value;
    player.begin();
  };
  if (rows.length === 0) return [];
  return [
    make("h3", {}, "Signals"),
    make("ul", { class: "signals" }, ...rows),
    ...(game.title ? [] : [make("label", { class: "quiet" }, "they change ", when)]),
  ];
}

/** What is in channels. @type {(player: Player, game: Game) => HTMLElement[]} */
function channels(player, game) {
  const { model } = player.editor;
  const items = Object.entries(game.queues).flatMap(([handle, queues]) =>
    queues
      .filter(({ load }) => load > 0 && model.objects.has(handle))
      .map(({ text, load, room }) => {
        const full = room === 0 ? " full" : "";
        return make(
          "li",
          { class: `queue${full}` },
          `${model.label(handle)}: ${text}: ${load} of ${load + room}${full}`,
        );
      }),
  );
  const others = Object.values(game.under).flat();
  items.push(...others.map(({ text, tokens }) => make("li", {}, tokens === 1 ? text : `${text}: ${tokens}`)));
  return items.length === 0
    ? []
    : [make("h3", {}, "In channels"), make("ul", { class: "channels" }, ...items)];
}

/** @type {(player: Player, game: Game) => HTMLElement} */
function firings(player, game) {
  const { model, canvas } = player.editor;
  const isHere = (/** @type {Firing} */ { elements }) =>
    elements.some((each) => model.objects.has(each) && model.sheetOf(each) === canvas.sheet);
  const shown = game.firings.filter(({ kind }) => kind !== "signal");
  const sorted = [...shown.filter(isHere), ...shown.filter((each) => !isHere(each))];
  const items = sorted.map((each) => {
    const fire = () => player.fire(each.id);
    const pressed = { "data-key": `fire ${each.id}`, disabled: player.isStale, onclick: fire };
    return make("li", { class: each.kind }, make("button", pressed, each.text));
  });
  if (items.length === 0) {
    const text = game.firings.length === 0 ? "nothing" : "nothing but signals";
    items.push(make("li", { class: "quiet" }, text));
  }
  return make("ul", { class: "firings" }, ...items);
}

/** @type {(player: Player, game: Game) => HTMLElement} */
function steps(player, game) {
  const items = game.steps.map(({ text }, index) => {
    const to = game.first + index + 1;
    const go = { "data-key": `step ${to}`, disabled: player.isStale, onclick: () => player.go(to) };
    return make("li", { "aria-current": to === game.at ? "step" : null }, make("button", go, text));
  });
  const list = make("ol", { class: "steps", start: game.first + 1 }, ...items);
  queueMicrotask(() => {
    // In the list alone: the buttons above stay where they are.
    const now = list.querySelector("[aria-current]");
    if (now instanceof HTMLElement) list.scrollTop = now.offsetTop - list.clientHeight / 2;
  });
  return list;
}

/** @type {(player: Player) => HTMLElement} */
function files(player) {
  const { connection, model } = player.editor;
  const query = new URLSearchParams(location.search);
  query.set("tab", connection.tab);
  const name = model.state.file.replace(/(\.sym)?\.[a-z]+$/, "");
  const open = make("input", {
    type: "file",
    multiple: true,
    accept: ".jsonl",
    "data-key": "open",
  });
  open.onchange = () => open.files && player.open(open.files);
  return make(
    "div",
    { class: "files" },
    make("a", { href: `/trace?${query}`, download: `${name}.jsonl`, "data-key": "keep" }, "Keep as a trace"),
    make("label", {}, "Play a trace: ", open),
  );
}
