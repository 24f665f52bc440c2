// The past of every channel, in arrays that are made once and written round and round.
export class Ring {
  constructor(names, seconds, rate) {
    this.names = names;
    this.rate = rate;
    this.size = Math.round(seconds * rate);
    this.time = new Float64Array(this.size);
    this.values = Object.fromEntries(names.map((name) => [name, new Float32Array(this.size)]));
    this.clear();
  }
  clear() {
    this.count = 0;
    this.era = (this.era ?? 0) + 1;
  }
  push(frame) {
    const every = Math.max(1, Math.round(1 / (this.rate * frame.spacing)));
    if (this.count && frame.time < this.now - 0.5) this.clear();
    this.leaveOut(frame.time + (every - 1) * frame.spacing);
    for (let row = every - 1; row < frame.rows; row += every) {
      const at = this.count++ % this.size;
      this.time[at] = frame.time + row * frame.spacing;
      this.names.forEach((name, c) => { this.values[name][at] = frame.channels[c][row]; });
    }
  }
  // What was lost on the way is a gap, not a line from before it to after it.
  leaveOut(time) {
    const missing = this.count ? Math.min(this.size, Math.round((time - this.now) * this.rate) - 1) : 0, from = this.now;
    for (let row = 1; row <= missing; row++) {
      const at = this.count++ % this.size;
      this.time[at] = from + row / this.rate;
      for (const name of this.names) this.values[name][at] = NaN;
    }
  }
  get now() {
    return this.count ? this.time[(this.count - 1) % this.size] : 0;
  }
  latest(name) {
    return this.count ? this.values[name][(this.count - 1) % this.size] : NaN;
  }
  // Lowest and highest value in each of so many stretches, so that no peak is lost on the way to the screen;
  // values below the least are left out.
  envelope(names, from, to, stretches, least) {
    const kept = Math.min(this.count, this.size), first = this.count - kept;
    const start = Math.max(first, this.count - 1 - Math.round((this.now - from) * this.rate));
    const stop = Math.max(start, this.count - Math.round((this.now - to) * this.rate));
    const step = Math.max(1, Math.ceil((stop - start) / stretches)), x = [], out = names.map(() => []);
    for (let at = start - (start % step) + (start % step ? step : 0); at < stop; at += step) {
      const end = Math.min(at + step, stop), head = this.time[at % this.size];
      x.push(head);
      if (step > 1) x.push(head + step / (2 * this.rate));
      names.forEach((name, n) => {
        const values = this.values[name];
        let low = Infinity, high = -Infinity, lowAt = 0, highAt = 0;
        for (let j = at; j < end; j++) {
          const value = values[j % this.size];
          if (value < least) continue;
          if (value < low) { low = value; lowAt = j; }
          if (value > high) { high = value; highAt = j; }
        }
        if (low === Infinity) out[n].push(...(step === 1 ? [null] : [null, null]));
        else if (step === 1) out[n].push(low);
        else if (lowAt < highAt) out[n].push(low, high);
        else out[n].push(high, low);
      });
    }
    return [x, ...out];
  }
}
