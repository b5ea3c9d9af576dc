// Where a step stands: by its number, with runs of steps that do not matter folded, or by wall-clock time.
(function (T) {
  "use strict";

  const LEAST = 4; // shorter runs are not worth folding
  const FOLDED = 2.2; // width of a folded run, in steps; of a short one, less
  const SHORT = 0.55;

  T.Scale = class {
    /**
     * @param {T.Data} data
     * @param {{time?: boolean, shown?: Set<number>|null, least?: number, zoom?: number}} options `shown`: steps that matter; null: all;
     *   `least`: the shortest run that is folded
     */
    constructor(data, options = {}) {
      this.data = data;
      this.time = Boolean(options.time && data.timed);
      this.zoom = options.zoom || 1; // pixels per step or per second
      this.folds = []; // {from, to}: first and last step of a folded run
      const count = data.length;
      this.length = count;
      if (this.time) {
        this.at = data.times;
        this.total = (count ? data.times[count - 1] : 0) || 1;
      } else {
        this.at = new Float64Array(count + 1);
        let here = 0, index = 0;
        const shown = options.shown, least = options.least || LEAST;
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

    get width() { return this.total * this.zoom; }

    /** Left edge of a step's cell; of one past the last, the right end. */
    left(step) {
      if (this.time) return (step >= this.length ? this.total : this.at[Math.max(step, 0)]) * this.zoom;
      return this.at[Math.max(0, Math.min(step, this.length))] * this.zoom;
    }

    right(step) { return this.time ? this.left(step) : this.left(step + 1); }

    /** Where a step's mark stands: in the middle of its cell, or at its time. */
    x(step) {
      if (step < 0) return 0;
      if (step >= this.length) return this.width;
      return this.time ? this.left(step) : (this.left(step) + this.left(step + 1)) / 2;
    }

    /** The step at a place, the nearest one. */
    step(x) {
      if (!this.length) return -1;
      const value = x / this.zoom;
      let low = 0, high = this.length - 1;
      while (low < high) {
        const middle = (low + high + 1) >> 1;
        if (this.at[middle] <= value) low = middle; else high = middle - 1;
      }
      if (this.time && low + 1 < this.length && this.at[low + 1] - value < value - this.at[low]) low++;
      return low;
    }

    /** Distances of the ruler: 1, 2 or 5 times a power of ten, at least `apart` pixels. */
    ticks(apart) {
      const least = apart / this.zoom;
      let unit = 10 ** Math.floor(Math.log10(Math.max(least, 1e-6)));
      while (unit < least) unit *= unit * 2 >= least ? 2 : unit * 5 >= least ? 5 : 10;
      return this.time ? unit : Math.max(1, Math.round(unit));
    }
  };

  /** Steps that have a mark on one of these lanes. */
  T.stepsOf = function (lanes) {
    const shown = new Set();
    for (const lane of lanes) for (const [i, step] of lane.at.entries()) if (lane.marks[i][0] !== "n") shown.add(step);
    return shown;
  };
})((globalThis.DinerosTrace ??= {}));
