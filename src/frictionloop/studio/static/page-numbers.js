// Numbers of the last two seconds as studio/live_numbers.py tells them.
export const LEAST_S = 0.2, WINDOW_S = 2;
const TURNED_MM = 2, OVER_S = 0.004, LATEST_S = 0.03, LAGS = 76;

// Where the finger slides, further than 2 mm from a turn, a landing or a lift.
export function sliding(x, load, rate, { touch_n: touches, turns_mm_s: turns }) {
  const size = x.length, over = Math.max(Math.round(OVER_S * rate / 2), 1), way = new Int8Array(size), moves = new Uint8Array(size), far = new Uint8Array(size);
  for (let i = 0, last = 0; i < size; i++) {
    const after = Math.min(i + over, size - 1), before = Math.max(i - over, 0), speed = (x[after] - x[before]) / (after - before) * rate;
    moves[i] = load[i] >= touches && Math.abs(speed) > turns;
    if (moves[i]) last = Math.sign(speed);
    else if (load[i] < touches) last = 0;
    way[i] = last;
  }
  for (let begin = 0, end = 0; begin < size; begin = end) {
    for (end = begin + 1; end < size && way[end] === way[begin];) end++;
    for (let i = begin; i < end; i++) {
      far[i] = moves[i] && Math.abs(x[i] - x[begin]) >= TURNED_MM && (end === size || Math.abs(x[i] - x[end]) >= TURNED_MM);
    }
  }
  return far;
}

// Slope of the force over the wish at the delay at which they correlate best, as preview/pattern_measures.py has it.
function slopeOf(wish, force, far, rate) {
  let best = -Infinity, slope = 0;
  for (const late of new Set(Array.from({ length: LAGS }, (_, lag) => Math.round(lag / (LAGS - 1) * LATEST_S * rate)))) {
    let n = 0, w = 0, f = 0, ww = 0, wf = 0, ff = 0;
    for (let i = late; i < far.length; i++) {
      if (!far[i] || !far[i - late]) continue;
      const a = wish[i - late], b = force[i];
      n++; w += a; f += b; ww += a * a; wf += a * b; ff += b * b;
    }
    const both = wf - w * f / n, spread = ww - w * w / n, found = both / Math.sqrt(spread * (ff - f * f / n));
    if (found > best) [best, slope] = [found, both / spread];
  }
  return slope;
}

export function numbersOf(rows, names, rate, limits) {
  const at = (name) => rows[names.indexOf(name)], far = sliding(at("x_mm"), at("load_n"), rate, limits);
  const ticks = [...far.keys()].filter((i) => far[i]), mean = (of) => ticks.reduce((sum, i) => sum + of(i), 0) / ticks.length;
  if (ticks.length < LEAST_S * rate) return {};
  const asked = at("asked_n"), saturated = at("saturated"), um = at("closed_um"), most = ticks.reduce((found, i) => Math.max(found, um[i]), 0);
  const middle = mean((i) => asked[i]), wish = Math.sqrt(mean((i) => (asked[i] - middle) ** 2)), told = {
    saturated: mean((i) => saturated[i]), reach: ["floor_n", "limit_n"].map((end) => mean((i) => at(end)[i])),
    beyond: mean((i) => asked[i] < at("floor_n")[i] || asked[i] > at("limit_n")[i]),
    swings: Math.min(mean((i) => saturated[i] > 0 && um[i] > 0.5 * most), mean((i) => saturated[i] > 0 && !(um[i] > 0.5 * most))),
  };
  for (const name of ["open", "closed"]) {
    const force = at(`${name}_n`), rms = Math.sqrt(mean((i) => (force[i] - asked[i]) ** 2));
    Object.assign(told, { [`${name}_error_n`]: rms });
    if (wish > 1e-3) Object.assign(told, { [`${name}_r2`]: 1 - (rms / wish) ** 2, [`${name}_contrast`]: slopeOf(asked, force, far, rate) });
  }
  return told;
}
