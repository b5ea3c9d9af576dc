// A page that follows a running application: a snapshot, then numbered changes; it comes back by itself.
(function (T) {
  "use strict";
  const { make } = T;
  const FIRST_WAIT = 300, LONGEST_WAIT = 3000; // milliseconds between two attempts to come back

  T.startLive = function (content) {
    let stopped = null; // the breakpoint's step that the view stopped at
    let app = null, epoch = null, number = null, wait = FIRST_WAIT;
    const state = make("span", { id: "connection", role: "status", "data-state": "waiting" }, "connecting…");
    const follow = make("button", { id: "follow", "aria-pressed": "true", title: "stay at the last step", onclick: () => setFollowing(!app || !app.following) }, "Follow");
    document.getElementById("head").append(state);

    function tell(name, text) { state.dataset.state = name; state.textContent = text; }

    function setFollowing(on) {
      if (!app) return;
      app.following = on;
      if (on) { leave(); app.breakpoints.say(""); toEnd(); }
      follow.setAttribute("aria-pressed", String(on));
    }

    function toEnd() {
      const last = app.traces[0].length - 1;
      app.select(last, false);
      if (last >= 0) app.view.reveal(last);
    }

    function snapshot(message) {
      const before = app, seen = before ? before.traces[0].length : null;
      content.view = message.view;
      if (!content.net) content.net = message.net;
      if (!before) {
        app = globalThis.dinerosTrace = new T.App(content);
        app.following = true;
        app.onfollow = () => { follow.setAttribute("aria-pressed", String(app.following)); leave(); };
        document.getElementById("tools").prepend(follow);
      } else {
        // The same run, read again by a server that has restarted: cursor, filter and window stay.
        app.views[0] = message.view;
        app.traces[0] = new T.Data(message.view);
        app.cursor = Math.min(app.cursor, app.traces[0].length - 1);
        if (!app.net && message.net && T.NetPane) app.net = new T.NetPane(app, message.net);
        else if (app.net && message.net && !app.net.content) app.net.setContent(message.net);
        if (before.traces[0].timed && app.view.frames < 2) app.time = true;
        app.layout();
      }
      grown(seen);
    }

    /** Shows what is new; `seen` steps were there before, or null: then there was no page. */
    function grown(seen) {
      const data = app.traces[0];
      if (data.timed && !app.sawTime) { app.sawTime = true; app.time = true; }
      app.breakpoints.look();
      app.layout();
      const hit = seen === null ? null : app.breakpoints.hitFrom(seen);
      if (hit && app.following) stop(hit);
      else if (app.following) toEnd();
      else app.tell();
      if (stopped !== null) sayStopped();
      app.head();
      document.getElementById("head").append(state);
      sayLive();
    }

    /** The view stops at a breakpoint; the application knows nothing of it. */
    function stop(hit) {
      app.select(hit.step);
      stopped = hit;
    }

    /** The user goes elsewhere. */
    function leave() {
      stopped = null;
      if (state.dataset.state === "stopped") sayLive();
    }

    function sayStopped() {
      const all = app.breakpoints.steps(), more = all.length - 1 - T.lastAtMost(all, stopped.step);
      app.breakpoints.say(`stopped at step ${stopped.step + 1}: ${stopped.texts.join(", ")}. The application goes on${more ? `; ${more} more ${more === 1 ? "hit" : "hits"} since` : ""}. Follow returns to it.`, "hit");
    }

    function sayLive() {
      const length = app.traces[0].length;
      if (stopped !== null && !app.following) tell("stopped", `stopped at a breakpoint · live · ${length} steps`);
      else tell("live", `live · ${length} steps`);
    }

    function receive(message) {
      if (message.type === "snapshot") { epoch = message.epoch; number = message.number; snapshot(message); return true; }
      if (message.type === "change") {
        if (number === null || message.number !== number + 1) return false; // something is missing: ask for everything
        number = message.number;
        const seen = app.traces[0].length;
        app.traces[0].append(message);
        grown(seen);
      } else if (message.type === "problem") tell("lost", message.text);
      else if (app) sayLive();
      return true;
    }

    function connect() {
      const asked = new URLSearchParams({ token: new URLSearchParams(location.search).get("token") || "" });
      if (epoch !== null) { asked.set("epoch", epoch); asked.set("number", number); }
      const socket = new WebSocket(`ws://${location.host}/changes?${asked}`);
      socket.onmessage = (event) => {
        wait = FIRST_WAIT;
        if (!receive(JSON.parse(event.data))) { epoch = number = null; socket.close(); }
      };
      socket.onclose = (event) => {
        if (event.code === 4403) { tell("lost", "not allowed: open the printed address"); return; }
        tell("lost", "connection lost, trying again…");
        setTimeout(connect, wait);
        wait = Math.min(wait * 1.6, LONGEST_WAIT);
      };
    }

    connect();
  };
})((globalThis.DinerosTrace ??= {}));
