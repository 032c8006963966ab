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

// Columns of the history by name. On a page of several runs the names of packed arrays begin with that of the run.
const readHistory = async (data) => {
  const bytes = await inflate(`${data.prefix ?? ""}history`);
  const all = new Float64Array(bytes.buffer);
  const columns = new Map();
  data.columns.forEach((name, k) => columns.set(name, all.subarray(k * data.rows, (k + 1) * data.rows)));
  return columns;
};

// Bodies with their points, triangles, edges and outlines, and with tetrahedra where their inside is recorded.
const readBodies = async (data) => {
  const { buffer } = await inflate(`${data.prefix ?? ""}geometry`);
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
    // Numbers of the nodes in the mesh, of which only some are recorded.
    numbers: body.numbered ? next(Uint32Array, body.nodes) : null,
  }));
};

// Principal values of a symmetric tensor, descending: the roots of its characteristic polynomial by the cosine of a third of an angle.
const principal = (xx, yy, zz, xy, yz, xz) => {
  const mean = (xx + yy + zz) / 3, [a, b, c] = [xx - mean, yy - mean, zz - mean];
  const size = Math.sqrt((a * a + b * b + c * c + 2 * (xy * xy + yz * yz + xz * xz)) / 6);
  if (!(size > 0)) return [mean, mean, mean];
  const determinant = a * (b * c - yz * yz) - xy * (xy * c - yz * xz) + xz * (xy * yz - b * xz);
  const angle = Math.acos(clamp(determinant / (2 * size ** 3), -1, 1)) / 3;
  const [first, last] = [mean + 2 * size * Math.cos(angle), mean + 2 * size * Math.cos(angle + 2 * Math.PI / 3)];
  return [first, 3 * mean - first - last, last];
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
      this.put(first, this.data.chunks[chunk], await inflate(`${this.data.prefix ?? ""}stills-${chunk}`));
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
  field(name, body, out) { return this.fieldOf(name, body, this.now[body], out); }

  // Value of a field at one node of a body in any still; NaN where that is not unpacked yet.
  valueAt(name, still, body, node) {
    const place = this.places[still];
    if (!place) return NaN;
    const { view, bytes } = place;
    let { at } = place;
    for (let k = 0; k < body; k += 1) {
      at += this.components(this.bodies[k]) * (8 + 2 * this.bodies[k].nodes);
      at += 4 + view.getUint32(at, true) * 4 * (2 + this.dimension);
    }
    const { nodes } = this.bodies[body], components = this.components(this.bodies[body]), values = [];
    for (let c = 0; c < components; c += 1) {
      const least = view.getFloat32(at + 8 * c, true), greatest = view.getFloat32(at + 8 * c + 4, true);
      const h = at + 8 * components + c * nodes, l = h + components * nodes;
      let word = 0;
      for (let i = 0; i <= node; i += 1) word = (word + (bytes[h + i] << 8) + bytes[l + i]) & 65535;
      values.push([Math.fround(least + (greatest - least) / 65535 * word)]);
    }
    at += components * (8 + 2 * nodes);
    const count = view.getUint32(at, true), touching = [], slip = [], pressure = [];
    at += 4;
    for (let i = 0; i < count; i += 1) {
      const word = view.getUint32(at + 4 * i, true);
      if ((word & 0x3fffffff) !== node) continue;
      touching.push(0);
      slip.push(word >>> 30);
      pressure.push(view.getFloat32(at + 4 * count + 4 * i * (1 + this.dimension), true));
    }
    return this.fieldOf(name, body, { values, touching, slip, pressure }, [0])[0];
  }

  // Least and greatest value of a field in all stills; of fields that follow from the stress they are found when they are asked for.
  range(field) {
    if (field.low !== null) return [field.low, field.high];
    const before = this.at;
    let [low, high] = [Infinity, -Infinity];
    this.places.forEach((_, still) => {
      if (!this.show(still)) return;
      this.bodies.forEach(({ nodes }, k) => {
        for (const value of this.field(field.name, k, new Float32Array(nodes))) [low, high] = [Math.min(low, value), Math.max(high, value)];
      });
    });
    if (before >= 0) this.show(before);
    if (this.places.every((place) => place)) [field.low, field.high] = [low, high];
    return [low, high];
  }

  fieldOf(name, body, { values, touching, slip, pressure }, out) {
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
      for (let i = 0; i < count; i += 1) out[i] = this.bodies[body].flows ? S[this.stresses][i] : 0;
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
    } else if (name === "tresca" || name.startsWith("principal_")) {
      const zero = new Float32Array(D === 3 ? 0 : count);
      for (let i = 0; i < count; i += 1) {
        const all = principal(S[0][i], S[1][i], S[2][i], S[3][i], (S[4] && D === 3 ? S[4] : zero)[i], (S[5] && D === 3 ? S[5] : zero)[i]);
        out[i] = name === "tresca" ? all[0] - all[2] : all[Number(name.slice(-1)) - 1];
      }
    } else {
      const stress = S[["stress_xx", "stress_yy", "stress_zz", "stress_xy", "stress_yz", "stress_xz"].indexOf(name)];
      for (let i = 0; i < count; i += 1) out[i] = stress[i];
    }
    return out;
  }
}
