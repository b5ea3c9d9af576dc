// Steering a run: how its nodes are, what could fire, their signals as switches, and a button that pauses a node.

import { make } from "../elements.js";

/**
 * A node as views/live/steering.py tells of it; one that cannot tell now, since it is blocked, say, tells nothing of its net.
 *
 * @typedef {{ node: string, state: string, reason: string | null, signals?: Record<string, boolean>, enabled?: string[] }} NodeState
 */

export class SteeringPanel {
  section = make("section", { id: "steer", "aria-label": "steering" });
  said = make("p", { role: "alert" });

  /** @param {(message: object) => void} ask says something to Python */
  constructor(ask) {
    this.ask = ask;
    document.querySelector("aside")?.prepend(this.section);
  }

  /** @type {(nodes: NodeState[]) => void} */
  show(nodes) {
    const focused =
      document.activeElement instanceof HTMLElement ? document.activeElement.dataset.key : undefined;
    this.section.replaceChildren(
      make("h2", {}, "Steering"),
      this.said,
      ...nodes.map((each) => this.row(each)),
    );
    const same = [...this.section.querySelectorAll("button")].find(({ dataset }) => dataset.key === focused);
    if (focused !== undefined) same?.focus();
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

  /** @type {(node: NodeState) => HTMLElement} */
  row({ node, state, reason, signals = {}, enabled }) {
    const isHalted = state === "halted";
    const turn = make(
      "button",
      {
        "data-key": `${node} pause`,
        "aria-label": `${isHalted ? "Proceed" : "Pause"} ${node}`,
        disabled: !["running", "halted"].includes(state),
        onclick: () => this.tell({ ask: isHalted ? "proceed" : "pause", node }),
      },
      isHalted ? "Proceed" : "Pause",
    );
    const switches = Object.entries(signals).map(([signal, value]) =>
      make(
        "button",
        {
          role: "switch",
          "aria-checked": String(value),
          "data-key": `${node} ${signal}`,
          onclick: () => this.tell({ ask: "signal", node, signal, value: !value }),
        },
        `${signal}: ${value}`,
      ),
    );
    return make(
      "div",
      { class: "steered", "data-node": node },
      make("b", {}, node),
      ` ${state}${reason ? `: ${reason}` : ""} `,
      turn,
      switches.length > 0 && make("div", { class: "switches" }, ...switches),
      enabled &&
        make(
          "div",
          { class: "enabled" },
          enabled.length > 0 ? `enabled: ${enabled.join(", ")}` : "nothing is enabled",
        ),
    );
  }
}
