// The socket: frames and maps in, pointer events and commands out; it comes back by itself.
import { mapOf } from "./maps.js";

const FRAME = 1, MAP = 2, CROWD = 3, RETRY_MS = 700;

export class Link extends EventTarget {
  constructor(url) {
    super();
    this.url = url;
    this.open();
  }
  open() {
    this.socket = new WebSocket(this.url);
    this.socket.binaryType = "arraybuffer";
    this.socket.onopen = () => this.tell("link", { up: true });
    this.socket.onmessage = ({ data }) => (typeof data === "string" ? this.text(data) : this.binary(data));
    this.socket.onclose = (event) => {
      this.tell("link", { up: false, refused: event.code === 1008 || event.code === 1006 && !this.ever });
      setTimeout(() => this.open(), RETRY_MS);
    };
  }
  tell(name, detail) {
    this.dispatchEvent(Object.assign(new Event(name), { detail }));
  }
  text(data) {
    this.ever = true;
    const message = JSON.parse(data);
    if (message.type === "hello") this.page = message.page;
    this.tell(message.type, message);
  }
  binary(buffer) {
    const view = new DataView(buffer), kind = view.getUint32(0, true);
    if (kind === FRAME || kind === CROWD) {
      const rows = view.getUint16(28, true), count = view.getUint16(30, true), channels = [];
      for (let c = 0; c < count; c++) channels.push(new Float32Array(buffer, 32 + 4 * rows * c, rows));
      this.tell(kind === FRAME ? "frame" : "people", {
        time: view.getFloat64(8, true), reached: view.getFloat64(16, true), spacing: view.getFloat32(24, true), rows, channels,
      });
    } else if (kind === MAP) {
      this.tell("map", mapOf(buffer));
    }
  }
  get up() {
    return this.socket.readyState === WebSocket.OPEN;
  }
  ask(what, more = {}) {
    if (this.up) this.socket.send(JSON.stringify({ do: what, ...more }));
  }
  // An effect of the page's own; resolves to what was made of it, and rejects with why not.
  async bring(kind, asked, content) {
    const query = new URLSearchParams(location.search);
    for (const [name, value] of Object.entries({ kind, ...asked })) query.set(name, value);
    const answer = await fetch(`/effect?${query}`, { method: "POST", headers: { "X-Studio-Page": this.page }, body: content });
    const told = await answer.json().catch(() => ({ why: "The studio did not answer." }));
    if (!answer.ok) throw new Error(told.why);
    return told.told;
  }
  touch(events) {
    if (!this.up || !events.length) return;
    this.socket.send(new Float64Array(events));
    this.tell("slid", { events: events.length });
  }
}
