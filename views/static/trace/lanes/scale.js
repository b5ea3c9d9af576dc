// Where a step stands: by its number, with runs of steps that do not matter folded, or by wall-clock time.

/** @import { Data } from "../data.js" */
/** @import { FilledLane, LaneRow, Row } from "../types.js" */
/**
 * @typedef {object} Fold
 * @property {number} from first step of a folded run
 * @property {number} to last step
 * @property {number} start where it is drawn
 * @property {number} end
 */

const LEAST = 4; // shorter runs are not worth folding
const FOLDED = 2.2; // width of a folded run, in steps; of a short one, less
const SHORT = 0.55;

export class Scale {
  /** Pixels per step or per second. */
  zoom = 1;
  /** @type {Fold[]} */
  folds = [];

  /**
   * @param {Data} data
   * @param {{ time?: boolean, shown?: Set<number> | null, least?: number }} options
   *   `shown`: steps that matter, null for all; `least`: the shortest run that is folded
   */
  constructor(data, { time = false, shown = null, least = LEAST } = {}) {
    this.time = time && data.timed;
    const count = data.length;
    this.length = count;
    /** Where steps begin. @type {number[]} */
    this.at = [];
    if (this.time) {
      this.at = data.times;
      this.total = data.horizon || 1;
    } else {
      let here = 0;
      let index = 0;
      while (index < count) {
        let end = index;
        if (shown) while (end < count && !shown.has(end)) end++;
        if (end - index >= least) {
          const width = Math.min(FOLDED, SHORT * (end - index));
          this.folds.push({ from: index, to: end - 1, start: here, end: here + width });
          for (let i = index; i < end; i++) this.at[i] = here + (width * (i - index)) / (end - index);
          here += width;
          index = end;
        } else {
          const stop = Math.max(end, index + 1);
          for (; index < stop; index++) this.at[index] = here++;
        }
      }
      this.at[count] = here;
      this.total = here || 1;
    }
  }

  get width() {
    return this.total * this.zoom;
  }

  /** Left edge of a step's cell; of one past the last, the right end. @type {(step: number) => number} */
  left(step) {
    if (this.time) return (step >= this.length ? this.total : this.at[Math.max(step, 0)]) * this.zoom;
    return this.at[Math.max(0, Math.min(step, this.length))] * this.zoom;
  }

  /** @type {(step: number) => number} */
  right(step) {
    return this.time ? this.left(step) : this.left(step + 1);
  }

  /**
   * Where a step's mark stands: in the middle of its cell, or at its time.
   *
   * @type {(step: number) => number}
   */
  x(step) {
    if (step < 0) return 0;
    if (step >= this.length) return this.width;
    return this.time ? this.left(step) : (this.left(step) + this.left(step + 1)) / 2;
  }

  /** The step at a place, the nearest one. @type {(x: number) => number} */
  step(x) {
    if (!this.length) return -1;
    const value = x / this.zoom;
    let low = 0;
    let high = this.length - 1;
    while (low < high) {
      const middle = (low + high + 1) >> 1;
      if (this.at[middle] <= value) low = middle;
      else high = middle - 1;
    }
    if (this.time && low + 1 < this.length && this.at[low + 1] - value < value - this.at[low]) low++;
    return low;
  }

  /**
   * Distances of the ruler: 1, 2 or 5 times a power of ten, at least `apart` pixels.
   *
   * @type {(apart: number) => number}
   */
  ticks(apart) {
    const least = apart / this.zoom;
    let unit = 10 ** Math.floor(Math.log10(Math.max(least, 1e-6)));
    while (unit < least) unit *= unit * 2 >= least ? 2 : unit * 5 >= least ? 5 : 10;
    return this.time ? unit : Math.max(1, Math.round(unit));
  }
}

/** Steps that have a mark on one of these lanes. @type {(lanes: FilledLane[]) => number[]} */
const stepsOf = (lanes) =>
  lanes.flatMap((lane) => lane.at.filter((_, index) => lane.marks[index][0] !== "n"));

/**
 * The steps that matter: those that brought the outcome about, or those with a mark on a lane that is shown;
 * null for all.
 *
 * @type {(traces: Data[], rows: Row[], choice: { causes?: boolean, fold?: boolean }) => Set<number> | null}
 */
export function stepsShown(traces, rows, { causes, fold }) {
  if (causes) return new Set(traces.flatMap((data) => [...data.causal]));
  return fold ? new Set(stepsOf(rows.filter(isLane).map((row) => row.lane))) : null;
}

/**
 * @param {Row} row
 * @returns {row is LaneRow}
 */
export const isLane = (row) => row.type === "lane";
