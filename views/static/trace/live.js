// A page that follows a running application: a snapshot, then numbered changes; it comes back by itself.

import { counted } from "../counting.js";
import { byId, make } from "../elements.js";
import { Data, lastAtMost } from "./data.js";
import { NetPane } from "./net_pane.js";
import { App, known } from "./page.js";
import { SteeringPanel } from "./steer.js";

/** @import { Picture } from "../net/types.js" */
/** @import { Growth, View } from "./types.js" */
/**
 * @typedef {object} Snapshot
 * @property {"snapshot"} type
 * @property {string} epoch
 * @property {number} number
 * @property {boolean} ended whether all nodes have stopped
 * @property {View} view
 * @property {Picture | null} net
 */
/** @typedef {Growth & { type: "change", number: number, ended: boolean }} Change */
/** @import { NodeState } from "./steer.js" */
/** @typedef {{ type: "nodes", nodes: NodeState[] } | { type: "refused", reason: string }} Steered */
/** @typedef {{ type: "nothing new" } | { type: "end" } | Steered} Other */
/** @typedef {Snapshot | Change | { type: "problem", text: string } | Other} Message */

const FIRST_WAIT = 300; // milliseconds between two attempts to come back
const LONGEST_WAIT = 3000;
const NOT_ALLOWED = 4403;

class Live {
  /** None before the first snapshot. @type {App | null} */
  app = null;
  /** The breakpoint's step that the view stopped at. @type {{ step: number, texts: string[] } | null} */
  stopped = null;
  /**
   * Of the server's run, and of the last change: what is asked for after a loss.
   *
   * @type {{ epoch: string, number: number } | null}
   */
  known = null;
  wait = FIRST_WAIT;
  /** @type {WebSocket | null} */
  socket = null;
  /** Where the run can be steered. @type {SteeringPanel | null} */
  steering = null;
  /** Whether all nodes have stopped. */
  ended = false;
  /** Whether the server has said that nothing more will come. */
  left = false;
  state = make("span", { id: "connection", role: "status", "data-state": "waiting" }, "connecting…");
  button = make(
    "button",
    {
      id: "follow",
      "aria-pressed": "true",
      title: "stay at the last step",
      onclick: () => this.app && this.setFollowing(this.app, !this.app.following),
    },
    "Follow",
  );

  constructor() {
    byId("head", HTMLElement).append(this.state);
    this.connect();
  }

  /** @type {(name: "live" | "lost" | "stopped" | "ended", text: string) => void} */
  tell(name, text) {
    this.state.dataset.state = name;
    this.state.textContent = text;
  }

  /** @type {(app: App, on: boolean) => void} */
  setFollowing(app, on) {
    app.following = on;
    if (on) {
      this.leave(app);
      app.breakpoints.say("");
      this.toEnd(app);
    }
    this.button.setAttribute("aria-pressed", String(on));
  }

  /** @param {App} app */
  toEnd(app) {
    const last = app.traces[0].length - 1;
    app.select(last, false);
    if (last >= 0) app.view.reveal(last);
  }

  /** @param {Snapshot} message */
  begin({ view, net }) {
    const app = known(new App({ view, net, live: true }));
    app.following = true;
    app.onfollow = () => {
      this.button.setAttribute("aria-pressed", String(app.following));
      this.leave(app);
    };
    byId("tools", HTMLElement).prepend(this.button);
    this.app = app;
    this.grown(app, null);
  }

  /**
   * The same run, read again by a server that has restarted: cursor, filter and window stay.
   *
   * @type {(app: App, message: Snapshot) => void}
   */
  resume(app, { view, net }) {
    const seen = app.traces[0];
    app.views[0] = view;
    app.traces[0] = new Data(view);
    app.cursor = Math.min(app.cursor, app.traces[0].length - 1);
    if (net) app.net ??= new NetPane(net, app.themeName);
    if (!seen.timed && app.traces[0].timed) app.time = true;
    app.layout();
    this.grown(app, seen.length);
  }

  /**
   * Shows what is new; `seen` steps were there before, or null: then there was no page.
   *
   * @type {(app: App, seen: number | null) => void}
   */
  grown(app, seen) {
    app.breakpoints.look();
    app.layout();
    const hit = seen === null ? null : app.breakpoints.hitFrom(seen);
    if (hit && app.following) {
      app.select(hit.step); // the view stops; the application knows nothing of it
      this.stopped = hit;
    } else if (app.following) this.toEnd(app);
    else app.tell();
    if (this.stopped) this.sayStopped(app, this.stopped);
    app.head();
    byId("head", HTMLElement).append(this.state);
    this.sayLive(app);
  }

  /** The user goes elsewhere. @type {(app: App) => void} */
  leave(app) {
    this.stopped = null;
    if (this.state.dataset.state === "stopped") this.sayLive(app);
  }

  /** @type {(app: App, stopped: { step: number, texts: string[] }) => void} */
  sayStopped(app, { step, texts }) {
    const all = app.breakpoints.steps;
    const more = all.length - 1 - lastAtMost(all, step);
    const since = more ? `; ${more} more ${more === 1 ? "hit" : "hits"} since` : "";
    const said = `stopped at step ${step + 1}: ${texts.join(", ")}`;
    app.breakpoints.say(`${said}. The application continues${since}. Follow returns to it.`, "hit");
  }

  /** @param {App} app */
  sayLive(app) {
    const { length } = app.traces[0];
    if (this.stopped && !app.following)
      this.tell("stopped", `stopped at a breakpoint · live · ${counted(length, "step")}`);
    else if (this.ended) this.tell("ended", `the run has ended · ${counted(length, "step")}`);
    else if (this.left) this.tell("ended", `no longer followed · ${counted(length, "step")}`);
    else this.tell("live", `live · ${counted(length, "step")}`);
  }

  /** Takes a message; false where something is missing before it. @type {(message: Message) => boolean} */
  receive(message) {
    const { app } = this;
    if (message.type === "nodes") {
      this.steering ??= new SteeringPanel((said) => this.socket?.send(JSON.stringify(said)));
      this.steering.show(message.nodes);
      return true;
    }
    if (message.type === "refused") {
      this.steering?.refused(message.reason);
      return true;
    }
    this.left = message.type === "end";
    if (message.type === "snapshot") {
      this.ended = message.ended;
      this.known = { epoch: message.epoch, number: message.number };
      if (app) this.resume(app, message);
      else this.begin(message);
    } else if (message.type === "change") {
      if (!app || !this.known || message.number !== this.known.number + 1) return false;
      this.known.number = message.number;
      this.ended = message.ended;
      const [data] = app.traces;
      const { length, timed } = data;
      data.append(message);
      if (!timed && data.timed) app.time = true;
      this.grown(app, length);
    } else if (message.type === "problem") this.tell("lost", message.text);
    else if (app) this.sayLive(app);
    return true;
  }

  connect() {
    const asked = new URLSearchParams({ token: new URLSearchParams(location.search).get("token") ?? "" });
    if (this.known) {
      asked.set("epoch", this.known.epoch);
      asked.set("number", String(this.known.number));
    }
    const socket = new WebSocket(`ws://${location.host}/changes?${asked}`);
    this.socket = socket;
    socket.onmessage = (event) => {
      this.wait = FIRST_WAIT;
      if (this.receive(JSON.parse(event.data))) return;
      this.known = null; // ask for everything
      socket.close();
    };
    socket.onclose = (event) => {
      if (event.code === NOT_ALLOWED) {
        this.tell("lost", "not allowed: open the printed address");
        return;
      }
      // Somebody may continue with the run later, at the same address: the page comes back then.
      if (this.left) this.wait = LONGEST_WAIT;
      else this.tell("lost", "connection lost, trying again…");
      setTimeout(() => this.connect(), this.wait);
      this.wait = Math.min(this.wait * 1.6, LONGEST_WAIT);
    };
  }
}

new Live();
