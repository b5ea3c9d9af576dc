// The stream to Python: numbered questions, their answers, and what changes; it comes back by itself.

/** @import { Done, Message, Refused } from "./types.js" */

const FIRST_WAIT = 300; // milliseconds between two attempts to come back
const LONGEST_WAIT = 3000;
const NOT_ALLOWED = 4403;

/**
 * A question, and who waits for its answer.
 *
 * @typedef {{ text: string, settle: (answer: Done | Refused) => void }} Question
 */

export class Connection {
  /** By number; those that were not answered are asked again after a loss: what is done already is not done twice. @type {Map<number, Question>} */
  waiting = new Map();
  number = 0;
  wait = FIRST_WAIT;
  /** @type {WebSocket | null} */
  socket = null;
  tab = Array.from(crypto.getRandomValues(new Uint8Array(12)), (byte) =>
    byte.toString(16).padStart(2, "0"),
  ).join("");

  /**
   * @param {(message: Message) => void} hear called with every message that is not an answer
   * @param {(name: "live" | "lost" | "refused") => void} tell what is called when the state of the stream changes
   */
  constructor(hear, tell) {
    this.hear = hear;
    this.tell = tell;
    this.connect();
  }

  connect() {
    const token = new URLSearchParams(location.search).get("token") ?? "";
    const query = new URLSearchParams({ token, tab: this.tab });
    const socket = new WebSocket(`ws://${location.host}/commands?${query}`);
    socket.onmessage = ({ data }) => this.receive(JSON.parse(data));
    socket.onclose = ({ code }) => {
      this.socket = null;
      if (code === NOT_ALLOWED) {
        this.tell("refused");
        return;
      }
      this.tell("lost");
      setTimeout(() => this.connect(), this.wait);
      this.wait = Math.min(2 * this.wait, LONGEST_WAIT);
    };
    socket.onopen = () => {
      this.socket = socket;
      this.wait = FIRST_WAIT;
      this.tell("live");
      for (const [, { text }] of [...this.waiting].sort(([one], [other]) => one - other)) socket.send(text);
    };
  }

  /** @type {(message: Message) => void} */
  receive(message) {
    if (message.type !== "done" && message.type !== "refused") {
      this.hear(message);
      return;
    }
    const question = this.waiting.get(message.number ?? -1);
    this.waiting.delete(message.number ?? -1);
    question?.settle(message);
  }

  /**
   * Asks for something.
   *
   * @param {"do" | "compose" | "clause" | "undo" | "redo" | "save" | "reload" | "play" | "work"} ask
   * @param {object} [more]
   * @returns {Promise<Done | Refused>}
   */
  ask(ask, more = {}) {
    this.number += 1;
    const text = JSON.stringify({ number: this.number, ask, ...more });
    return new Promise((settle) => {
      this.waiting.set(this.number, { text, settle });
      this.socket?.send(text);
    });
  }
}
