// Twelve fingers under the stroke of a page without a server, each with two loops of its own, told as studio/parallel_fingers.py tells them.
import { plain } from "./page-loops.js";
import { LEAST_S, WINDOW_S, sliding } from "./page-numbers.js";

const PEOPLE = 12, SHARE = 0.5, TRIES = 5, CALLS = 10, BLOCKS_HZ = 200;

export class Twelve {
  // Refused where all of them would take more than half of the time.
  constructor(loops, data) {
    const names = data.axes.fingers.choices, us = 1e6 * cost(loops.another(), data.most), most = 1e6 * SHARE / data.rate / PEOPLE;
    if (names.length < PEOPLE) throw new Error("not all of them can have it");
    if (us > most) throw new Error(`a period of one finger takes ${us.toFixed(0)} µs here, at most ${most.toFixed(0)}`);
    this.people = names.map((name) => ({ name, own: data.fingers[name], loops: loops.another() }));
    Object.assign(this, { data, kept: [] });
    this.put(loops.at);
  }
  put(at) {
    for (const { name, own, loops } of this.people) {
      loops.at = { ...at, finger: name, stops: Object.fromEntries(Object.entries(at.stops).filter(([path]) => !(path in own))) };
      loops.change();
    }
  }
  // Goes on along a path that ends at a tick, and returns the last row of a block once it is whole.
  follow(path, end) {
    const told = this.people.map(({ loops }) => loops.advance(path)), { rate } = this.data;
    if (end % Math.round(rate / BLOCKS_HZ)) return null;
    const [asked, open, closed, limit, floor] = [2, 3, 4, 8, 9].map((row) => told.map((rows) => rows[row].at(-1)));
    this.kept = [...this.kept.slice(1 - WINDOW_S * BLOCKS_HZ), { end, asked, open, closed, beyond: asked.map((n, who) => n < floor[who] || n > limit[who]) }];
    return { time: end / rate, reached: NaN, spacing: 1 / BLOCKS_HZ, rows: 1, channels: [asked[0], ...open, ...closed].map((value) => [value]) };
  }
  // Errors where the finger of the page slid in the last seconds, which end at a tick, and the share out of reach.
  summary(x, load, end) {
    const far = sliding(x, load, this.data.rate, this.data.limits), counted = this.kept.filter((row) => far[x.length - 1 - end + row.end]);
    const mean = (of) => (counted.length < LEAST_S * BLOCKS_HZ ? null : counted.reduce((sum, row) => sum + of(row), 0) / counted.length);
    return this.people.map(({ own }, who) => {
      const [open, closed] = ["open", "closed"].map((loop) => mean((row) => (row[loop][who] - row.asked[who]) ** 2)), rms = (power) => power && Math.sqrt(power);
      return { nominal_n: own["friction.nominal_n"], open_error_n: rms(open), closed_error_n: rms(closed), beyond: mean((row) => row.beyond[who]) };
    });
  }
}

// Time of a period of both loops at best, s.
function cost(loops, periods) {
  const path = plain(periods), tries = Array.from({ length: TRIES }, () => {
    const since = performance.now();
    for (let call = 0; call < CALLS; call++) loops.advance(path);
    return performance.now() - since;
  });
  return 1e-3 * Math.min(...tries) / CALLS / periods;
}
