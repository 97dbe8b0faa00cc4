// What live channels have brought: so many values are kept, and no more, however long it goes on.

/** Values of a channel that are kept: a minute at 1 kHz. What is older makes room. */
export const KEPT = 60_000;

/** Times and values of a channel. */
export class Ring {
  constructor() {
    this.at = new Float64Array(KEPT);
    this.values = new Float64Array(KEPT);
    this.count = 0;
    // How many there have been.
    this.all = 0;
    // What is drawn, in the order of time: the same memory for each picture.
    this.drawnAt = new Float64Array(KEPT);
    this.drawnValues = new Float64Array(KEPT);
  }

  push(at, value) {
    const place = this.all % KEPT;
    this.at[place] = at;
    this.values[place] = value;
    this.all += 1;
    this.count = Math.min(KEPT, this.count + 1);
  }

  /** When the last one came. */
  last() {
    return this.count === 0 ? 0 : this.at[(this.all - 1) % KEPT];
  }

  /** Which one is the first at this time or later, of all that there have been. */
  first(at) {
    let low = this.all - this.count;
    let high = this.all;
    while (high > low) {
      const middle = Math.floor((low + high) / 2);
      if (this.at[middle % KEPT] < at) low = middle + 1;
      else high = middle;
    }
    return low;
  }

  /** The value at this time, or the next one. */
  value(at) {
    return this.values[Math.min(this.first(at), this.all - 1) % KEPT];
  }

  /**
   * Those from `since` on; their times count from `zero`. They are good until the next call. Where there are many more than columns of the
   * picture, the least and the greatest of each few stand for them: what is drawn is the same, and takes less.
   */
  since(since, zero, columns = Infinity) {
    const from = this.first(since);
    const few = 2 ** Math.max(0, Math.floor(Math.log2((this.all - from) / columns)));
    const { at, values, drawnAt, drawnValues } = this;
    let drawn = 0;
    const draw = (place) => {
      drawnAt[drawn] = at[place] - zero;
      drawnValues[drawn] = values[place];
      drawn += 1;
    };
    // The same few are taken together in each picture, or it would shimmer. This runs half a million times in a picture of a minute.
    let place = from % KEPT;
    for (let one = from; one < this.all;) {
      const end = Math.min(this.all, one - (one % few) + few);
      let low = place;
      let high = place;
      let isRising = true;
      for (; one < end; one += 1) {
        const value = values[place];
        if (value < values[low]) {
          low = place;
          isRising = false;
        } else if (value > values[high]) {
          high = place;
          isRising = true;
        }
        place += 1;
        if (place === KEPT) place = 0;
      }
      draw(isRising ? low : high);
      if (low !== high) draw(isRising ? high : low);
    }
    return [this.drawnAt.subarray(0, drawn), this.drawnValues.subarray(0, drawn)];
  }
}
