// Both loops of a bench as WebAssembly: numbers that Python lowered go in, and channels of every tick come out.
export async function unpacked(text) {
  const bytes = Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
  return new Response(new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"))).arrayBuffer();
}

// A plain stroke, to prove and to time loops by: place (m), speed (m/s) and load (N) of each period.
export const plain = (periods) => Float64Array.from({ length: 3 * periods }, (_, i) => [1e-5 * Math.floor(i / 3), 0.05, 0.5][i % 3]);

export class Loops {
  // The build that fuses is taken where 64 periods of it have the simulator's bits; the other has them everywhere.
  static async open(data) {
    const blob = new Uint8Array(await unpacked(data.blob));
    for (const build of ["fused", "exact"]) {
      const code = await unpacked(data.wasm[build]);
      if (!WebAssembly.validate(code)) continue;
      const loops = new Loops(data, blob, await WebAssembly.compile(code), build);
      if (loops.proven()) return loops;
    }
    throw new Error("this browser does not compute the simulator's numbers");
  }
  constructor(data, blob, module, build, known = new Map()) {
    const wasm = new WebAssembly.Instance(module).exports;
    Object.assign(this, { data, blob, module, wasm, build, top: wasm.__heap_base.value, at: { ...data.start }, known });
    this.shape = new Float64Array(this.words(data.shape).buffer);
    this.loops = ["closed", "open"].map((which) => ({ which, rooms: {} }));
    for (const loop of this.loops) this.lay(loop, this.image(loop), true);
  }
  // Loops of their own on the same numbers.
  another() {
    return new Loops(this.data, this.blob, this.module, this.build, this.known);
  }
  // Words of 64 bits, packed as differences, all first bytes first.
  words([offset, count]) {
    const key = `${offset} ${count}`;
    if (this.known.has(key)) return this.known.get(key).slice();
    const bytes = new Uint8Array(8 * count), words = new BigUint64Array(bytes.buffer);
    for (let i = 0; i < 8 * count; i++) bytes[8 * (i % count) + Math.floor(i / count)] = this.blob[8 * offset + i];
    for (let i = 1; i < count; i++) words[i] += words[i - 1];
    this.known.set(key, words);
    return words.slice();
  }
  // The choices of a loop, in the order in which they lie over one another.
  chosen(law) {
    const { effects, fingers, laws, stops, gains } = this.data.axes, found = [];
    for (const [axis, name] of [[effects, this.at.effect], [fingers, this.at.finger], [laws, law]]) {
      if (axis.choices.includes(name)) found.push([axis, axis.choices.indexOf(name)]);
    }
    for (const [path, axis] of Object.entries({ ...stops, ...gains[law] })) {
      if (this.at.stops[path] !== undefined) found.push([axis, axis.choices.indexOf(this.at.stops[path])]);
    }
    return found;
  }
  image({ which }) {
    const law = which === "open" ? "lookup" : this.at.law;
    const image = Object.fromEntries(Object.entries(this.data.base).map(([name, at]) => [name, this.words(at)]));
    for (const [axis, index] of this.chosen(law)) {
      for (const [name, places] of Object.entries(axis.places)) {
        const words = this.words(axis.words[index][name]);
        if (places) places.forEach((place, i) => { image[name][place] = words[i]; });
        else image[name] = words;
      }
    }
    return { law, ...image };
  }
  room(loop, name, bytes) {
    const room = loop.rooms[name];
    if (room?.size >= bytes) return room.at;
    const at = (this.top + 63) & ~63, pages = Math.ceil((at + bytes) / 65536) - this.wasm.memory.buffer.byteLength / 65536;
    this.top = at + bytes;
    if (pages > 0) this.wasm.memory.grow(pages);
    loop.rooms[name] = { at, size: bytes };
    return at;
  }
  point(loop, name, at) {
    const field = loop.rooms.record.at + 8 * this.data.fields[name];
    new DataView(this.wasm.memory.buffer).setBigUint64(field, BigInt(at >>> 0), true);
  }
  lay(loop, image, fresh) {
    const { scale, law, ...arrays } = image, { most, names } = this.data;
    const view = (name, words) => {
      const at = this.room(loop, name, 8 * words.length);
      new BigUint64Array(this.wasm.memory.buffer, at, words.length).set(words);
    };
    view("record", arrays.record); // which points to all others
    view("roughness", new BigUint64Array(this.shape.map((n) => new Float64Array(scale.buffer)[0] * n).buffer));
    for (const [name, words] of Object.entries(arrays)) if (name !== "record" && (fresh || name !== "history")) view(name, words);
    if (fresh) loop.period = 0;
    for (const [name, doubles] of [["trace", names.length * most], ["path", 3 * most]]) this.room(loop, name, 8 * doubles);
    for (const name of Object.keys(this.data.fields)) if (name in loop.rooms) this.point(loop, name, loop.rooms[name].at);
    loop.fresh = image;
  }
  // As `Guided.change`: numbers change and the state stays, but what makes another loop begins anew at rest.
  change() {
    for (const loop of this.loops) {
      const image = this.image(loop), before = loop.fresh, same = (name) => image[name].every((word, i) => word === before[name][i]);
      if (image.law !== before.law || !["record", "blocks", "ticks"].every(same)) {
        this.lay(loop, image, true);
        continue;
      }
      const running = new BigUint64Array(this.wasm.memory.buffer, loop.rooms.slab.at, image.slab.length).slice();
      const slab = image.slab.slice(), state = new Set(this.data.laws[image.law].state);
      slab.forEach((word, i) => { if (word === before.slab[i] || state.has(i)) slab[i] = running[i]; });
      this.lay(loop, { ...image, slab }, false);
      loop.fresh = image;
    }
  }
  // Place (m), speed (m/s) and load (N) of each period in; the traces of a loop out. Rows count from its beginning.
  run(loop, path) {
    const { most, names } = this.data, periods = path.length / 3, { buffer } = this.wasm.memory;
    new Float64Array(buffer, loop.rooms.path.at, path.length).set(path);
    this.point(loop, "path", loop.rooms.path.at - 24 * loop.period);
    this.point(loop, "trace", loop.rooms.trace.at - 8 * loop.period);
    this.wasm.advance(loop.rooms.slab.at, loop.period, loop.period + periods, loop.rooms.record.at);
    loop.period += periods;
    return Object.fromEntries(names.map((name, i) => [name, new Float64Array(buffer, loop.rooms.trace.at + 8 * most * i, periods).slice()]));
  }
  advance(path) {
    const [closed, open] = this.loops.map((loop) => this.run(loop, path));
    if ([closed, open].some((told) => told.f_a.some(Number.isNaN))) throw new Error("a force is no number");
    return [
      closed.position.map((x) => 1e3 * x), closed.load, closed.f_r, open.f_a, closed.f_a, closed.f_m, open.a, closed.a,
      closed.limit, closed.floor, closed.saturated,
    ];
  }
  // Whether 64 periods have the simulator's bits; both loops then begin anew.
  proven() {
    const told = new BigUint64Array(Float64Array.from(this.advance(plain(64)).flatMap((row) => [...row])).buffer);
    for (const loop of this.loops) this.lay(loop, loop.fresh, true);
    return this.words(this.data.proof).every((word, i) => word === told[i]);
  }
}
