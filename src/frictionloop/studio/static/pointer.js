// Mouse, touch, pen and arrow keys on the plate: events with their own time, sent as they come.
const KEY_MM_S = 60, SEND_MS = 4, STILL_MS = 25; // a block of the loop is 5 ms; a pointer moves 60 times a second

export class Pointer {
  constructor(canvas, plate, link) {
    Object.assign(this, { canvas, plate, link, events: [], down: false, key: 0, place: [0, 0], arrivals: new Map() });
    canvas.addEventListener("pointerdown", (event) => this.begin(event));
    // A browser holds moves back until its next picture, but for who asks for them raw; some know no raw ones.
    const moves = "onpointerrawupdate" in canvas ? "pointerrawupdate" : "pointermove";
    canvas.addEventListener(moves, (event) => this.down && event.pointerId === this.id && this.move(event));
    for (const name of ["pointerup", "pointercancel", "lostpointercapture"]) canvas.addEventListener(name, (event) => this.end(event));
    canvas.addEventListener("keydown", (event) => this.press(event));
    canvas.addEventListener("keyup", (event) => { if (event.key === "ArrowLeft" || event.key === "ArrowRight") this.key = 0; });
    canvas.addEventListener("blur", () => this.lift());
  }
  load(event) {
    // A mouse tells 0.5 for any press, and a screen without pressure 0, 0.5 or 1: the slider's load then counts.
    const told = event.pointerType === "pen" ? event.pressure > 0 : event.pointerType === "touch" && ![0, 0.5, 1].includes(event.pressure);
    return told ? 2 * event.pressure : NaN;
  }
  begin(event) {
    if (event.button !== 0 || this.canvas.dataset.tool) return;
    this.canvas.focus({ preventScroll: true });
    try { this.canvas.setPointerCapture(event.pointerId); } catch { /* a pointer that is gone already */ }
    this.id = event.pointerId;
    this.down = true;
    this.move(event);
    event.preventDefault();
  }
  move(event) {
    const all = event.getCoalescedEvents?.() ?? [];
    for (const each of all.length ? all : [event]) this.add(each);
    if (!(event.timeStamp - this.sent < SEND_MS)) this.send(event.timeStamp);
  }
  send(now) {
    this.sent = now;
    this.link.touch(this.events.slice(-1000));
    this.events = [];
  }
  add(event) {
    this.place = this.plate.mm(event.clientX, event.clientY);
    this.pressed = this.load(event);
    this.events.push(event.timeStamp, ...this.place, this.pressed);
    this.last = event.timeStamp;
    this.arrivals.set(event.timeStamp, performance.now());
  }
  // When the event of this time came to the page, told once: by the first force that knows of it.
  arrival(reached) {
    const found = this.arrivals.get(reached);
    for (const time of this.arrivals.keys()) if (time <= reached) this.arrivals.delete(time);
    return found;
  }
  end(event) {
    if (this.down && event.pointerId === this.id) this.lift();
  }
  lift() {
    if (this.down || this.keyed) this.link.ask("lift");
    this.down = this.keyed = false;
    this.key = 0;
    this.events = [];
    this.arrivals.clear();
  }
  press(event) {
    if (this.canvas.dataset.tool) return;
    const way = { ArrowLeft: -1, ArrowRight: 1 }[event.key];
    if (way) {
      if (!this.keyed && !this.down) this.place = [this.plate.finger.x, this.plate.finger.y];
      this.key = way * (event.shiftKey ? 2.5 : 1);
      this.keyed = true;
      event.preventDefault();
    } else if (event.key === "ArrowUp" || event.key === "ArrowDown") {
      // Another line: the finger leaves the plate and lands anew.
      if (!this.keyed && !this.down) this.place = [this.plate.finger.x, this.plate.finger.y];
      this.lift();
      this.place[1] += event.key === "ArrowUp" ? 1 : -1;
      this.keyed = true;
      event.preventDefault();
    } else if (event.key === "+" || event.key === "-") {
      const load = document.getElementById("load");
      load.value = Number(load.value) + (event.key === "+" ? 0.05 : -0.05);
      load.dispatchEvent(new Event("input"));
    } else if (event.key === "l" || event.key === "L" || event.key === "Escape") this.lift();
  }
  // Once per animation frame: what waits goes out. A finger at rest says so too, else it would seem to creep to where it
  // moves next; between two moves of a slow pointer it is not at rest.
  flush(now) {
    if (this.keyed) {
      const half = this.plate.canvas.clientWidth / 2 / this.plate.scale;
      this.place[0] = Math.max(-half, Math.min(half, this.place[0] + this.key * KEY_MM_S * Math.min(0.05, (now - (this.before ?? now)) / 1e3)));
      this.events.push(now, ...this.place, NaN);
    } else if (this.down && !this.events.length && now > this.last + STILL_MS) this.events.push(now, ...this.place, this.pressed);
    this.before = now;
    if (this.events.length) this.send(now);
  }
}
