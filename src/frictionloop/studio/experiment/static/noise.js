// Masking noise against the plate's sound: pink (P. Kellet's filter, musicdsp.org), as loud as asked, in dB rms under full scale.
const SECONDS = 8;

export class Noise {
  constructor() { this.db = null; }
  // A browser lets a page sound after somebody has pressed something on it.
  begin() {
    if (this.context) return;
    this.context = new AudioContext();
    const n = SECONDS * this.context.sampleRate, buffer = this.context.createBuffer(1, n, this.context.sampleRate);
    const out = buffer.getChannelData(0);
    let b0 = 0, b1 = 0, b2 = 0, sum = 0;
    for (let i = 0; i < n; i++) {
      const white = 2 * Math.random() - 1;
      b0 = 0.99765 * b0 + white * 0.0990460;
      b1 = 0.96300 * b1 + white * 0.2965164;
      b2 = 0.57000 * b2 + white * 1.0526913;
      out[i] = b0 + b1 + b2 + white * 0.1848;
      sum += out[i] ** 2;
    }
    const scale = 1 / Math.sqrt(sum / n);
    for (let i = 0; i < n; i++) out[i] *= scale;
    this.source = new AudioBufferSourceNode(this.context, { buffer, loop: true });
    this.gain = new GainNode(this.context, { gain: 0 });
    this.meter = new AnalyserNode(this.context, { fftSize: 32768 });
    this.source.connect(this.gain).connect(this.meter).connect(this.context.destination);
    this.source.start();
    this.set(this.db);
  }
  set(db) {
    this.db = db;
    if (!this.gain) return;
    this.gain.gain.value = db === null ? 0 : 10 ** (db / 20);
    this.since = this.context.currentTime;
  }
  // What sounds now, dB rms under full scale; null until the meter holds nothing from before the last change.
  level() {
    if (!this.meter) return null;
    const filled_s = this.context.currentTime - this.since;
    if (filled_s < this.meter.fftSize / this.context.sampleRate + 0.05) return null;
    const now = new Float32Array(this.meter.fftSize);
    this.meter.getFloatTimeDomainData(now);
    return 10 * Math.log10(now.reduce((sum, x) => sum + x * x, 0) / now.length);
  }
}
