// Runs the modules of a page without a server on what a test gives, and writes numbers as their bytes.
const [modules, given] = Deno.args, { data, build, steps, crowd, ahead, session, numbers } = JSON.parse(Deno.readTextFileSync(given));
const out = (values) => Deno.stdout.writeSync(new Uint8Array(Float64Array.from(values).buffer));
const load = (name) => import(`file://${modules}/${name}`);

if (data) {
  const { Loops } = await load("page-loops.js");
  const loops = !ahead && await Loops.open(build ? { ...data, wasm: { fused: data.wasm[build], exact: data.wasm[build] } } : data);
  if (!build && !ahead) console.log(loops.build);
  if (crowd) {
    const { Twelve } = await load("page-crowd.js");
    loops.at = crowd.at;
    const twelve = new Twelve(loops, { ...data, rate: 1 }); // however slow this machine is
    crowd.steps.forEach((path, block) => out(twelve.follow(Float64Array.from(path), 25 * (block + 1)).channels.map(([value]) => value)));
  }
  if (ahead) {
    const [{ reasonsOf }, { mapOf }, { unpacked }] = await Promise.all(["page-ahead.js", "maps.js", "page-loops.js"].map(load));
    console.log(JSON.stringify(reasonsOf(mapOf(await unpacked(data.maps[ahead.effect])), data.steep[ahead.effect], ahead.band)));
    Deno.exit();
  }
  for (const { at, path } of steps ?? []) {
    if (at) {
      loops.at = at;
      loops.change();
    }
    for (const row of loops.advance(Float64Array.from(path))) out(row);
  }
}
if (session) {
  const { Session } = await load("page-finger.js");
  const live = new Session((path) => [0, 1, 2].map((i) => path.filter((_, at) => at % 3 === i)), 5000);
  live.step(session[0][0]);
  for (const [now, events] of session) {
    if (events.length) live.touch(now, events.map((row) => row.map((value) => value ?? NaN)));
    for (const { first, rows, reached } of live.step(now)) out([first, reached, ...rows.flatMap((row) => [...row])]);
  }
}
if (numbers) {
  const { numbersOf } = await load("page-numbers.js");
  const told = numbersOf(numbers.rows.map((row) => Float32Array.from(row)), numbers.names, 5000, numbers.limits);
  console.log(JSON.stringify(told));
}
