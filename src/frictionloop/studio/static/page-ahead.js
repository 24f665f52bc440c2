// What of an effect will not arrive, told as a server tells it: out of the reach that the finger has now, or too steep.
const SLACK_N = 5e-3, LINE_MM = 1, BEYOND = 1, STEEP = 2;

// Of a map, the cells that are too steep by line, and the least and largest force within reach.
export function reasonsOf(map, steep, [low, high]) {
  const step = (map.right - map.left) / map.columns, tall = (map.top - map.bottom) / map.rows, lines = steep.length;
  const reasons = Array.from({ length: lines }, (_, line) => {
    const row = lines === 1 ? Math.floor(map.rows / 2) : Math.floor((line + 0.5) * LINE_MM / tall), cells = new Uint8Array(map.columns);
    for (let column = 0; column < map.columns; column++) {
      const force = map.low + map.shares[row * map.columns + column] / 255 * (map.high - map.low);
      if (force < low - SLACK_N || force > high + SLACK_N) cells[column] = BEYOND;
    }
    for (const cell of steep[line]) cells[cell] |= STEEP;
    return [...cells];
  });
  const share = (bit) => reasons.flat().filter((cell) => cell & bit).length / (lines * map.columns);
  return {
    why: "", reasons, from_mm: map.left + step / 2, step_mm: step, row_mm: LINE_MM, bottom_mm: lines === 1 ? 0 : map.bottom + LINE_MM / 2,
    shares: { beyond: share(BEYOND), steep: share(STEEP), weak: 0 },
  };
}
