// The live finger of live/pointer_motion.py and live/live_session.py, from the same events to the same bits (tests/studio/test_static_page.py).
const LATE_S = 1 / 60, KEPT = 256, OFFSETS = 128, FASTEST_MM_S = 400, LANDING_N_S = 25, TURN_S = 0.1, STROKE_MM = 80;
const BLOCKS_HZ = 200, SPARSE = 5, CATCH_UP_S = 0.5, GONE_S = 0.25;
const between = (value, low, high) => Math.min(Math.max(value, low), high);

export class PointerPath {
  samples = [];
  offsets = [];
  reached = NaN;
  heard(arrived, pageMs) {
    this.offsets.push(arrived - 1e-3 * pageMs);
    if (this.offsets.length > OFFSETS) this.offsets.shift();
    return 1e-3 * pageMs + Math.min(...this.offsets);
  }
  add(events) {
    const offset = Math.min(...this.offsets);
    for (const [pageMs, x, y, load] of events) {
      const time = 1e-3 * pageMs + offset;
      if (this.samples.length && !(time > this.samples.at(-1).time)) continue;
      this.samples.push({ time, x, y, load, pageMs });
      if (this.samples.length > KEPT) this.samples.shift();
    }
  }
  next(after) {
    let found = Infinity;
    for (let i = this.samples.length - 1; i >= 0 && this.samples[i].time + LATE_S > after; i--) found = this.samples[i].time + LATE_S;
    return found;
  }
  at(time) {
    const wanted = time - LATE_S;
    let after = null;
    for (let i = this.samples.length - 1; i >= 0; i--) {
      const sample = this.samples[i];
      if (sample.time <= wanted) {
        this.reached = sample.pageMs;
        if (!after) return sample;
        const share = (wanted - sample.time) / (after.time - sample.time), mixed = (name) => sample[name] + share * (after[name] - sample[name]);
        return { x: mixed("x"), y: mixed("y"), load: mixed("load") };
      }
      after = sample;
    }
    return after;
  }
}

export class Session {
  // `advance` takes the path of a block and returns its channels.
  constructor(advance, rate) {
    Object.assign(this, { advance, rate, ghost: { speed: 40, x: 0, v: 0, way: 1 }, pointer: new PointerPath(), ghostOn: true, stopped: false });
    Object.assign(this, { ticks: 0, dropped: 0, load: 0.5, line: 0, down: false, heardAt: -Infinity, begun: NaN });
    Object.assign(this, { x: 0, pressed: 0, blockTicks: Math.max(Math.round(rate / BLOCKS_HZ), 1) });
  }
  touch(now, events) {
    const heard = this.pointer.heard(now, events.at(-1)[0]);
    if (now - heard > GONE_S) return;
    if (!this.down) {
      this.pointer.samples = [];
      this.line = events[0][2];
    }
    Object.assign(this, { down: true, heardAt: heard });
    this.pointer.add(events.map(([pageMs, x, y, load]) => [pageMs, x, y, Number.isNaN(load) ? this.load : load]));
  }
  step(now) {
    if (Number.isNaN(this.begun)) this.begun = now - this.ticks / this.rate;
    let behind = now - this.begun - this.ticks / this.rate;
    if (behind > CATCH_UP_S) {
      this.dropped += behind - CATCH_UP_S;
      this.begun += behind - CATCH_UP_S;
      behind = CATCH_UP_S;
    }
    const done = [], until = this.ticks + Math.trunc(behind * this.rate + 1e-6);
    for (let end = this.end(); end <= until; end = this.end()) done.push(this.block(end, now));
    return done;
  }
  end() {
    const grid = (Math.floor(this.ticks / this.blockTicks) + 1) * this.blockTicks;
    if (!this.down || this.ticks % this.blockTicks) return grid;
    const next = this.pointer.next(this.begun + this.ticks / this.rate);
    if (next === Infinity) return grid;
    return Math.min(this.ticks + SPARSE * Math.ceil(((next - this.begun) * this.rate - this.ticks) / SPARSE), grid);
  }
  block(end, now) {
    const ticks = end - this.ticks, first = this.ticks;
    if (now - this.heardAt > GONE_S) this.down = false;
    const wanted = this.wanted(this.begun + end / this.rate, ticks / this.rate);
    const rows = this.advance(this.path(wanted, ticks)).map((channel) => Float32Array.from(channel));
    this.ticks = end;
    return { first, rows, reached: this.down ? this.pointer.reached : NaN };
  }
  wanted(at, span) {
    if (this.stopped) return null;
    if (this.down) return this.pointer.at(at);
    return this.ghostOn ? { x: this.stroke(span), load: this.load } : null;
  }
  stroke(span) {
    const { ghost } = this, step = 2 * ghost.speed * span / TURN_S;
    if (ghost.way * ghost.x >= STROKE_MM / 2 - Math.abs(ghost.v) * TURN_S / 2) ghost.way = -ghost.way;
    ghost.v += between(ghost.way * ghost.speed - ghost.v, -step, step);
    return ghost.x += ghost.v * span;
  }
  path(wanted, ticks) {
    const span = ticks / this.rate, path = new Float64Array(3 * ticks);
    if (wanted && this.pressed === 0) this.x = wanted.x;
    const way = between(wanted ? wanted.x - this.x : 0, -FASTEST_MM_S * span, FASTEST_MM_S * span);
    const more = between((wanted ? wanted.load : 0) - this.pressed, -LANDING_N_S * span, LANDING_N_S * span);
    for (let i = 0; i < ticks; i++) {
      const share = (i + 1) / ticks;
      path.set([1e-3 * (this.x + way * share), 1e-3 * way / span, Math.max(this.pressed + more * share, 0)], 3 * i);
    }
    this.x += way;
    this.pressed = path[3 * ticks - 1];
    return path;
  }
}
