// The map of an effect out of its bytes: the force over the plate, as the server packs it.
export function mapOf(buffer) {
  const view = new DataView(buffer), number = (at) => view.getFloat32(at, true);
  return {
    columns: view.getUint32(4, true), rows: view.getUint32(8, true), left: number(12), right: number(16),
    bottom: number(20), top: number(24), low: number(28), high: number(32), shares: new Uint8Array(buffer, 36),
  };
}
