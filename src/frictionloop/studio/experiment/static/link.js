// The socket of a page: messages as events, the host's clock by its shortest round trip, and it comes back by itself.
const RETRY_MS = 700, CLOCK_MS = 500, KEPT = 20;

export class Link extends EventTarget {
  constructor(role) {
    super();
    this.url = `${location.protocol === "https:" ? "wss" : "ws"}://${location.host}/live/${role}${location.search}`;
    this.readings = [];
    this.unsent = [];
    this.open();
    setInterval(() => this.up && this.ask("clock", { sent: performance.now() }), CLOCK_MS);
  }
  open() {
    this.socket = new WebSocket(this.url);
    this.socket.binaryType = "arraybuffer";
    this.socket.onopen = () => { this.readings = []; this.tell("link", { up: true }); this.ask("clock", { sent: performance.now() }); this.unsent.splice(0).forEach((each) => this.socket.send(each)); };
    this.socket.onmessage = ({ data }) => {
      // What is of the moment alone comes as bytes: a slow page may miss it.
      const message = JSON.parse(typeof data === "string" ? data : new TextDecoder().decode(data));
      if (message.type === "clock") this.read(message);
      else this.tell(message.type, message);
    };
    this.socket.onclose = () => { this.tell("link", { up: false }); setTimeout(() => this.open(), RETRY_MS); };
  }
  read({ sent, host_s }) {
    const now = performance.now(), trip = (now - sent) / 1e3;
    this.readings.push({ trip, offset: host_s - (sent + now) / 2e3 });
    if (this.readings.length > KEPT) this.readings.shift();
  }
  // A time of the page in ms on the host's clock in s; its standard deviation is that of any time in the round trip.
  host(at_ms) {
    if (!this.readings.length) return { at_s: 0, sd_s: 9 };
    const best = this.readings.reduce((a, b) => (b.trip < a.trip ? b : a));
    return { at_s: at_ms / 1e3 + best.offset, sd_s: best.trip / Math.sqrt(12) };
  }
  tell(name, detail) { this.dispatchEvent(Object.assign(new Event(name), { detail })); }
  get up() { return this.socket.readyState === WebSocket.OPEN; }
  // What is asked while the socket is away goes out when it is back: an answer is not lost.
  ask(what, more = {}) {
    const message = JSON.stringify({ do: what, ...more });
    if (this.up) this.socket.send(message);
    else this.unsent.push(message);
  }
}
