// Packed numbers, as skylimb/analysis/viewer/packing.py writes them, to arrays.

const NOTHING = 65535;

async function inflated(text) {
  const bytes = Uint8Array.from(atob(text), (c) => c.charCodeAt(0));
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"));
  return await new Response(stream).arrayBuffer();
}

/** Columns of a pack: one Float32Array each. */
export async function columns(pack) {
  const codes = new Uint16Array(await inflated(pack.data));
  const { rows, low, step } = pack;
  return low.map((least, c) => {
    const values = new Float32Array(rows);
    for (let i = 0, code = 0; i < rows; i++) {
      code = (code + codes[c * rows + i]) & 0xffff;
      values[i] = code === NOTHING ? NaN : least + code * step[c];
    }
    return values;
  });
}

/** Vertices and triangles of a mesh. */
export async function mesh(packed) {
  return {
    vertices: new Float32Array(await inflated(packed.vertices)),
    faces: new Uint32Array(await inflated(packed.faces)),
  };
}

/** Index of the last entry of `sorted` that is not above `value`; -1 before the first. */
export function lastNotAbove(sorted, value) {
  let low = 0, high = sorted.length;
  while (low < high) {
    const middle = (low + high) >> 1;
    if (sorted[middle] <= value) low = middle + 1; else high = middle;
  }
  return low - 1;
}
