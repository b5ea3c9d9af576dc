// A page that follows a running application: a snapshot, then numbered changes; it comes back by itself.
(function (T) {
  "use strict";
  const { make } = T;
  const FIRST_WAIT = 300, LONGEST_WAIT = 3000; // milliseconds between two attempts to come back

  T.startLive = function (content) {
    let app = null, epoch = null, number = null, wait = FIRST_WAIT;
    const state = make("span", { id: "connection", role: "status", "data-state": "waiting" }, "connecting…");
    const follow = make("button", { id: "follow", "aria-pressed": "true", title: "stay at the last step", onclick: () => setFollowing(!app || !app.following) }, "Follow");
    document.getElementById("head").append(state);

    function tell(name, text) { state.dataset.state = name; state.textContent = text; }

    function setFollowing(on) {
      if (!app) return;
      app.following = on;
      if (on) toEnd();
      follow.setAttribute("aria-pressed", String(on));
    }

    function toEnd() {
      const last = app.traces[0].length - 1;
      app.select(last, false);
      if (last >= 0) app.view.reveal(last);
    }

    function snapshot(message) {
      const before = app;
      content.view = message.view;
      if (!content.net) content.net = message.net;
      if (!before) {
        app = globalThis.dinerosTrace = new T.App(content);
        app.following = true;
        app.onfollow = () => follow.setAttribute("aria-pressed", String(app.following));
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
      grown();
    }

    function grown() {
      const data = app.traces[0];
      if (data.timed && !app.sawTime) { app.sawTime = true; app.time = true; }
      app.layout();
      if (app.following) toEnd();
      else app.tell();
      app.head();
      document.getElementById("head").append(state);
      tell("live", `live · ${data.length} steps`);
    }

    function receive(message) {
      if (message.type === "snapshot") { epoch = message.epoch; number = message.number; snapshot(message); return true; }
      if (message.type === "change") {
        if (number === null || message.number !== number + 1) return false; // something is missing: ask for everything
        number = message.number;
        app.traces[0].append(message);
        grown();
      } else if (message.type === "problem") tell("lost", message.text);
      else if (app) tell("live", `live · ${app.traces[0].length} steps`);
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
