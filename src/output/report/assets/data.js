// The data of the run: what is written in the page, unpacked.

// Bytes of what is packed in a text.
const unpack = async (packed) => {
  const text = atob(packed);
  const bytes = new Uint8Array(text.length);
  for (let i = 0; i < text.length; i += 1) bytes[i] = text.charCodeAt(i);
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate-raw"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
};

// Those of an element of the page, which is not needed any more.
const inflate = (id) => {
  const packed = $(id).textContent;
  $(id).textContent = "";
  return unpack(packed);
};

// Columns of the history by name.
const readHistory = async (data) => {
  const bytes = await inflate("history");
  const all = new Float64Array(bytes.buffer);
  const columns = new Map();
  data.columns.forEach((name, k) => columns.set(name, all.subarray(k * data.rows, (k + 1) * data.rows)));
  return columns;
};

// Bodies with their points, triangles, edges and outlines, and with tetrahedra where their inside is recorded.
const readBodies = async (data) => {
  const { buffer } = await inflate("geometry");
  let at = 0;
  const next = (kind, count) => {
    const array = new kind(buffer, at, count);
    at += array.byteLength;
    return array;
  };
  return data.bodies.map((body) => ({
    name: body.name, nodes: body.nodes, flows: body.flows,
    points: next(Float32Array, 3 * body.nodes), triangles: next(Uint32Array, 3 * body.triangles),
    edges: next(Uint32Array, 2 * body.edges), outline: next(Uint32Array, 2 * body.outline), cells: next(Uint32Array, 4 * body.tetrahedra),
  }));
};

// The stills of the run. Their bytes are unpacked chunk by chunk while the page is shown already, their numbers when they are asked for.
class Film {
  constructor(data, bodies) {
    this.data = data;
    this.bodies = bodies;
    this.places = new Array(data.stills.length).fill(null);
    this.dimension = data.dimension;
    this.stresses = data.dimension === 2 ? 4 : 6;
    this.at = -1;
    this.now = bodies.map((body) => ({
      values: Array.from({ length: this.components(body) }, () => new Float32Array(body.nodes)),
      touching: new Uint32Array(0), slip: new Uint8Array(0), pressure: new Float32Array(0), pressing: new Float32Array(0),
    }));
  }

  // Numbers of a node: displacement, velocity, stress, and plastic strain where the body flows.
  components({ flows }) {
    return 2 * this.dimension + this.stresses + (flows ? 1 : 0);
  }

  // Unpacks all chunks; `ready` is called after each.
  async load(ready) {
    let first = 0;
    for (let chunk = 0; chunk < this.data.chunks.length; chunk += 1) {
      this.put(first, this.data.chunks[chunk], await inflate(`stills-${chunk}`));
      first += this.data.chunks[chunk];
      ready();
    }
  }

  // Finds so many stills in their bytes, which are one after the other.
  put(first, count, bytes) {
    const view = new DataView(bytes.buffer);
    let at = 0;
    for (let k = 0; k < count; k += 1) {
      this.places[first + k] = { view, bytes, at };
      for (const body of this.bodies) {
        at += this.components(body) * (8 + 2 * body.nodes);
        at += 4 + view.getUint32(at, true) * 4 * (2 + this.dimension);
      }
    }
  }

  // Unpacks the numbers of a still; whether it is there already.
  show(index) {
    const place = this.places[index];
    if (!place) return false;
    if (this.at === index) return true;
    const { view, bytes } = place;
    let { at } = place;
    this.bodies.forEach((body, k) => {
      const now = this.now[k], { nodes } = body, components = this.components(body);
      const high = at + 8 * components, low = high + components * nodes;
      for (let c = 0; c < components; c += 1) {
        const least = view.getFloat32(at + 8 * c, true), greatest = view.getFloat32(at + 8 * c + 4, true);
        const factor = (greatest - least) / 65535, values = now.values[c], h = high + c * nodes, l = low + c * nodes;
        for (let i = 0, word = 0; i < nodes; i += 1) {
          word = (word + (bytes[h + i] << 8) + bytes[l + i]) & 65535;
          values[i] = least + factor * word;
        }
      }
      at = low + components * nodes;
      const count = view.getUint32(at, true), D = this.dimension;
      at += 4;
      now.touching = new Uint32Array(count);
      now.pressure = new Float32Array(count);
      now.pressing = new Float32Array(count * D);
      now.slip = new Uint8Array(count);
      for (let i = 0; i < count; i += 1) {
        const word = view.getUint32(at + 4 * i, true);
        now.touching[i] = word & 0x3fffffff;
        now.slip[i] = word >>> 30;
      }
      at += 4 * count;
      for (let i = 0; i < count; i += 1, at += 4 * (1 + D)) {
        now.pressure[i] = view.getFloat32(at, true);
        for (let d = 0; d < D; d += 1) now.pressing[i * D + d] = view.getFloat32(at + 4 * (1 + d), true);
      }
    });
    this.at = index;
    return true;
  }

  // Values of a field at the nodes of a body in the still that is shown.
  field(name, body, out) {
    const { values, touching, slip, pressure } = this.now[body];
    const D = this.dimension, S = values.slice(2 * D), count = out.length;
    const length = (vector) => {
      for (let i = 0; i < count; i += 1) out[i] = vector.length === 2 ? Math.hypot(vector[0][i], vector[1][i]) : Math.hypot(vector[0][i], vector[1][i], vector[2][i]);
    };
    if (name === "body") out.fill(body);
    else if (name === "displacement") length(values.slice(0, D));
    else if (name === "velocity") length(values.slice(D, 2 * D));
    else if (name === "contact_pressure") {
      out.fill(0);
      touching.forEach((node, i) => { out[node] = pressure[i]; });
    } else if (name === "plastic_strain") {
      if (this.bodies[body].flows) out.set(S[this.stresses]);
      else out.fill(0);
    } else if (name === "slip") {
      out.fill(0);
      touching.forEach((node, i) => { out[node] = slip[i]; });
    } else if (name === "pressure") for (let i = 0; i < count; i += 1) out[i] = -(S[0][i] + S[1][i] + S[2][i]) / 3;
    else if (name === "von_mises") {
      for (let i = 0; i < count; i += 1) {
        const a = S[0][i] - S[1][i], b = S[1][i] - S[2][i], c = S[2][i] - S[0][i];
        let shear = S[3][i] * S[3][i];
        if (D === 3) shear += S[4][i] * S[4][i] + S[5][i] * S[5][i];
        out[i] = Math.sqrt(0.5 * (a * a + b * b + c * c) + 3 * shear);
      }
    } else out.set(S[["stress_xx", "stress_yy", "stress_zz", "stress_xy", "stress_yz", "stress_xz"].indexOf(name)]);
    return out;
  }
}
