// The columns of numbers: inflated, their differences summed up, scaled.
const HOLE = -(2 ** 31);

async function inflated(text) {
  const raw = atob(text);
  const bytes = new Uint8Array(raw.length);
  for (let k = 0; k < raw.length; k++) bytes[k] = raw.charCodeAt(k);
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

function columnReader(bytes) {
  const count = bytes.length / 4;
  const known = new Map();
  return ([start, length, scale, offset]) => {
    if (!known.has(start)) {
      const values = new Float64Array(length);
      let sum = 0;
      for (let k = 0; k < length; k++) {
        const at = start + k;
        const step = bytes[at] | (bytes[count + at] << 8) | (bytes[2 * count + at] << 16)
          | (bytes[3 * count + at] << 24);
        sum = (sum + step) | 0;
        values[k] = sum === HOLE ? NaN : offset + scale * sum;
      }
      known.set(start, values);
    }
    return known.get(start);
  };
}
