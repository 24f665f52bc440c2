// Plays what comes in at the rate of the ticks; waits for a cushion first, and is silent when it runs dry.
const CUSHION_S = 0.06, ROOM = 65536;

class Friction extends AudioWorkletProcessor {
  constructor() {
    super();
    Object.assign(this, { ring: new Float32Array(ROOM), written: 0, at: 0, rate: 5000, plays: false });
    this.port.onmessage = ({ data }) => {
      this.rate = data.rate;
      for (const value of data.values) this.ring[this.written++ % ROOM] = value;
      if (this.written - this.at > ROOM / 2) this.at = this.written - CUSHION_S * this.rate;
    };
  }
  process(_, [[out]]) {
    if (this.written - this.at > CUSHION_S * this.rate) this.plays = true;
    const step = this.rate / sampleRate;
    for (let i = 0; this.plays && i < out.length; i++) {
      const cell = Math.floor(this.at);
      if (cell + 1 >= this.written) { this.plays = false; break; }
      const here = this.ring[cell % ROOM], after = this.ring[(cell + 1) % ROOM];
      out[i] = here + (this.at - cell) * (after - here);
      this.at += step;
    }
    return true;
  }
}
registerProcessor("friction", Friction);
