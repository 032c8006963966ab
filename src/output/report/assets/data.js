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
    name: body.name, nodes: body.nodes, flows: body.flows, further: body.further ?? [],
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

const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const cross = (a, b) => [0, 1, 2].map((d) => a[(d + 1) % 3] * b[(d + 2) % 3] - a[(d + 2) % 3] * b[(d + 1) % 3]);
const unit = (a) => a.map((component) => component / Math.hypot(...a));
const times = ([xx, yy, zz, xy, yz, xz], [x, y, z]) => [xx * x + xy * y + xz * z, xy * x + yy * y + yz * z, xz * x + yz * y + zz * z];

// The frame of local components: a direction, and radial, tangential and axial unit vectors at a place.
const localFrame = ({ center, axis, direction } = { center: [0, 0, 0], axis: [0, 0, 1], direction: [1, 0, 0] }) => {
  const along = unit(axis);
  const axesAt = (place) => {
    const arm = place.map((component, d) => component - center[d]), height = dot(along, arm);
    let radial = arm.map((component, d) => component - height * along[d]);
    if (!(Math.hypot(...radial) > Number.EPSILON * Math.hypot(...arm))) {
      const least = along.map(Math.abs).indexOf(Math.min(...along.map(Math.abs)));
      radial = cross(cross(along, [0, 1, 2].map((d) => Number(d === least))), along);
    }
    radial = unit(radial);
    return [radial, cross(along, radial), along];
  };
  return { direction: unit(direction), axesAt };
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

  // Numbers of a node: displacement, velocity, stress, plastic strain where the body flows, and further quantities.
  components(body) {
    return this.basic(body) + body.further.reduce((sum, [, count]) => sum + count, 0);
  }

  // Those of every recording.
  basic({ flows }) { return 2 * this.dimension + this.stresses + (flows ? 1 : 0); }

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
    return this.fieldOf(name, body, { values, touching, slip, pressure }, [0], node)[0];
  }

  // Least and greatest value of a field in all stills; of fields that are not basic they are found when they are asked for.
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

  // Components of a recorded quantity: the stress, or a further one by its name; nothing where it is not recorded.
  quantity(name, body, values) {
    if (name === "stress") return values.slice(2 * this.dimension, 2 * this.dimension + this.stresses);
    let at = this.basic(this.bodies[body]);
    for (const [other, count] of this.bodies[body].further) {
      if (other === name) return values.slice(at, at + count);
      at += count;
    }
    return null;
  }

  // Values that follow from a symmetric tensor at each node; `out` begins at the node `first`.
  ofTensors(name, body, values, out, first) {
    const isStrain = name.includes("strain"), tensors = this.quantity(isStrain ? "strain" : "stress", body, values);
    if (!tensors) return out.fill(NaN);
    const end = name.slice(name.lastIndexOf("_") + 1), { points } = this.bodies[body], frame = localFrame(this.data.frame), D = this.dimension;
    for (let i = 0; i < out.length; i += 1) {
      const [xx, yy, zz, xy, yz = 0, xz = 0] = tensors.map((component) => component[i]), tensor = [xx, yy, zz, xy, yz, xz];
      // Strains belong to the undeformed body.
      const place = () => [0, 1, 2].map((d) => points[3 * (first + i) + d] + (isStrain || d >= D ? 0 : values[d][i]));
      if (name === "tresca" || name.startsWith("principal_")) {
        const all = principal(...tensor);
        out[i] = name === "tresca" ? all[0] - all[2] : all[Number(end) - 1];
      } else if (name === "traction") out[i] = Math.hypot(...times(tensor, frame.direction));
      else if (end === "along") out[i] = dot(frame.direction, times(tensor, frame.direction));
      else if ("rta".includes(end[0])) {
        const axes = frame.axesAt(place());
        out[i] = dot(axes["rta".indexOf(end[0])], times(tensor, axes["rta".indexOf(end[1])]));
      } else out[i] = tensor[["xx", "yy", "zz", "xy", "yz", "xz"].indexOf(end)];
    }
    return out;
  }

  fieldOf(name, body, { values, touching, slip, pressure }, out, first = 0) {
    const further = this.quantity(name, body, values);
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
    } else if (further) {
      if (further.length > 1) length(further);
      else for (let i = 0; i < count; i += 1) out[i] = further[0][i];
    } else return this.ofTensors(name, body, values, out, first);
    return out;
  }
}
