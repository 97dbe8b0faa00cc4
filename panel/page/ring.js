// What live channels have brought: so many values are kept, and no more, however long it goes on.

/** Values of a channel that are kept: a minute at 1 kHz. What is older makes room. */
export const KEPT = 60_000;

/** Times and values of a channel. */
export class Ring {
  constructor() {
    this.at = new Float64Array(KEPT);
    this.values = new Float64Array(KEPT);
    this.count = 0;
    this.next = 0;
    // What is drawn, in the order of time: the same memory for each picture.
    this.drawnAt = new Float64Array(KEPT);
    this.drawnValues = new Float64Array(KEPT);
  }

  push(at, value) {
    this.at[this.next] = at;
    this.values[this.next] = value;
    this.next = (this.next + 1) % KEPT;
    this.count = Math.min(KEPT, this.count + 1);
  }

  /** When the last one came. */
  last() {
    return this.count === 0 ? 0 : this.at[(this.next - 1 + KEPT) % KEPT];
  }

  /** Those from `since` on; their times count from `zero`. They are good until the next call. */
  since(since, zero) {
    const oldest = this.next - this.count + KEPT;
    let low = 0;
    let high = this.count;
    while (high > low) {
      const middle = (low + high) >> 1;
      if (this.at[(oldest + middle) % KEPT] < since) low = middle + 1;
      else high = middle;
    }
    const count = this.count - low;
    for (let step = 0; step < count; step += 1) {
      const place = (oldest + low + step) % KEPT;
      this.drawnAt[step] = this.at[place] - zero;
      this.drawnValues[step] = this.values[place];
    }
    return [this.drawnAt.subarray(0, count), this.drawnValues.subarray(0, count)];
  }
}
