// Reads what packing.py wrote: a header and columns of whole numbers.

async function unpack(text) {
  const packed = Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("deflate"));
  const bytes = new Uint8Array(await new Response(stream).arrayBuffer());
  const size = new DataView(bytes.buffer).getUint32(0, true);
  const header = JSON.parse(new TextDecoder().decode(bytes.subarray(4, 4 + size)));
  const columns = {};
  let place = 4 + size;
  for (const [name, length, planes, summed] of header.columns) {
    columns[name] = column(bytes.subarray(place, place + length * planes), length, planes, summed);
    place += length * planes;
  }
  return [header, columns];
}

// Unfolds the signs (odd ones are negative) and sums differences. Plain arithmetic: folded ones may need over 31 bits.
function column(bytes, length, planes, summed) {
  const out = new Int32Array(length);
  for (let i = 0, before = 0; i < length; i++) {
    let folded = 0;
    for (let k = planes - 1; k >= 0; k--) folded = 256 * folded + bytes[k * length + i];
    out[i] = (summed ? before : 0) + (folded % 2 ? -(folded + 1) / 2 : folded / 2);
    before = out[i];
  }
  return out;
}

// Unit vectors from their places on the unfolded octahedron.
function normals(u, v, steps) {
  const out = new Float32Array(3 * u.length);
  for (let i = 0; i < u.length; i++) {
    let x = u[i] / steps, y = v[i] / steps;
    const z = 1 - Math.abs(x) - Math.abs(y);
    if (z < 0) [x, y] = [(1 - Math.abs(y)) * (x < 0 ? -1 : 1), (1 - Math.abs(x)) * (y < 0 ? -1 : 1)];
    const length = Math.hypot(x, y, z);
    out.set([x / length, y / length, z / length], 3 * i);
  }
  return out;
}
