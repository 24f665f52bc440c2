// Recorded runs as they were packed: from the page itself, or from the server that serves it.
import { mapOf } from "./maps.js";

const MISSING = 65535;

export async function shareRuns() {
  const within = document.getElementById("runs");
  if (within) return Promise.all(JSON.parse(within.textContent).map(opened));
  const answer = await fetch(`/runs.json${location.search}`);
  if (!answer.ok) throw new Error(await answer.text());
  return Promise.all((await answer.json()).map(opened));
}

async function opened(run) {
  const counts = new Uint16Array(await unpacked(run.values)), rows = run.rows;
  const values = run.least.map((least, c) => {
    const out = new Float32Array(rows);
    for (let row = 0; row < rows; row++) {
      const count = counts[c * rows + row];
      out[row] = count === MISSING ? NaN : least + run.step[c] * count;
    }
    return out;
  });
  return { ...run, values, map: run.map && mapOf(await unpacked(run.map)) };
}

async function unpacked(text) {
  const bytes = Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
  return new Response(new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"))).arrayBuffer();
}
