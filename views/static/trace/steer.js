// Steering a run: how its nodes are, what could fire, their signals as switches, and a button that pauses a node.

import { make } from "../elements.js";

/**
 * A node as views/live/steering.py tells of it; one that cannot tell now, since it is blocked, say, tells nothing of its net.
 *
 * @typedef {{ node: string, state: string, reason: string | null, signals?: Record<string, boolean | string>, values?: Record<string, string[]>, enabled?: string[] }} NodeState
 */

export class SteeringPanel {
  section = make("section", { id: "steer", "aria-label": "steering" }, make("h2", {}, "Steering"));
  said = make("p", { role: "alert" });
  /** @type {Map<string, Row>} */
  rows = new Map();

  /** @param {(message: object) => void} ask says something to Python */
  constructor(ask) {
    this.ask = ask;
    this.section.append(this.said);
    document.querySelector("aside")?.prepend(this.section);
  }

  /** Rows stay while they are changed: what is replaced while a user presses it is never clicked. @type {(nodes: NodeState[]) => void} */
  show(nodes) {
    const gone = new Set(this.rows.keys());
    for (const each of nodes) {
      gone.delete(each.node);
      let row = this.rows.get(each.node);
      if (row === undefined) {
        row = new Row(each.node, (message) => this.tell(message));
        this.rows.set(each.node, row);
        this.section.append(row.element);
      }
      row.show(each);
    }
    for (const node of gone) {
      this.rows.get(node)?.element.remove();
      this.rows.delete(node);
    }
  }

  /** @type {(reason: string) => void} */
  refused(reason) {
    this.said.textContent = reason;
  }

  /** @type {(message: object) => void} */
  tell(message) {
    this.said.textContent = "";
    this.ask(message);
  }
}

/** What is shown of one node. */
class Row {
  state = make("span");
  turn = make("button", {
    onclick: () => this.tell({ ask: this.isHalted ? "proceed" : "pause", node: this.node }),
  });
  /** A switch, or a choice of values, for each signal that was ever reported. @type {Map<string, HTMLElement>} */
  signals = new Map();
  switches = make("div", { class: "switches" });
  enabled = make("div", { class: "enabled" });
  isHalted = false;

  /**
   * @param {string} node
   * @param {(message: object) => void} tell
   */
  constructor(node, tell) {
    this.node = node;
    this.tell = tell;
    const { state, turn, switches, enabled } = this;
    this.element = make(
      "div",
      { class: "steered", "data-node": node },
      ...[make("b", {}, node), " ", state, " ", turn, switches, enabled],
    );
  }

  /** @type {(seen: NodeState) => void} */
  show({ state, reason, signals, values, enabled }) {
    this.isHalted = state === "halted";
    this.state.textContent = `${state}${reason ? `: ${reason}` : ""}`;
    this.turn.textContent = this.isHalted ? "Proceed" : "Pause";
    this.turn.setAttribute("aria-label", `${this.turn.textContent} ${this.node}`);
    this.turn.disabled = !["running", "halted"].includes(state);
    for (const [signal, value] of Object.entries(signals ?? {}))
      if (typeof value === "string") this.choose(signal, value, values?.[signal] ?? [value]);
      else this.switch(signal, value);
    this.switches.hidden = signals === undefined || this.signals.size === 0;
    this.enabled.hidden = enabled === undefined;
    this.enabled.textContent = enabled?.length ? `enabled: ${enabled.join(", ")}` : "nothing is enabled";
  }

  /** @type {(signal: string, value: string, values: string[]) => void} */
  choose(signal, value, values) {
    let found = /** @type {HTMLSelectElement | null} */ (this.signals.get(signal)?.querySelector("select"));
    if (!found) {
      const options = values.map((each) => make("option", { value: each }, each));
      const choice = make("select", { "aria-label": signal }, ...options);
      choice.onchange = () => this.tell({ ask: "signal", node: this.node, signal, value: choice.value });
      const element = make("label", {}, `${signal}: `, choice);
      this.signals.set(signal, element);
      this.switches.append(element);
      found = choice;
    }
    found.value = value;
  }

  /** @type {(signal: string, value: boolean) => void} */
  switch(signal, value) {
    let found = this.signals.get(signal);
    if (found === undefined) {
      const turned = make("button", {
        role: "switch",
        onclick: () => {
          const isOn = turned.getAttribute("aria-checked") === "true";
          this.tell({ ask: "signal", node: this.node, signal, value: !isOn });
        },
      });
      this.signals.set(signal, turned);
      this.switches.append(turned);
      found = turned;
    }
    found.setAttribute("aria-checked", String(value));
    found.textContent = `${signal}: ${value}`;
  }
}
