// The picture of the bodies. Cells are painted into an array of pixels, triangle by triangle, with the values between the nodes, in space
// with a buffer of depths; lines and arrows are drawn over it.

// The function that turns points by a rotation vector.
function rotation(spin) {
  const angle = Math.hypot(...spin);
  if (angle === 0) return (p) => p;
  const [a, b, c] = spin.map((x) => x / angle), cos = Math.cos(angle), sin = Math.sin(angle);
  return ([x, y, z]) => {
    const along = (1 - cos) * (a * x + b * y + c * z);
    return [cos * x + sin * (b * z - c * y) + along * a, cos * y + sin * (c * x - a * z) + along * b, cos * z + sin * (a * y - b * x) + along * c];
  };
}

class Scene {
  constructor(canvas, data, bodies, film) {
    Object.assign(this, { canvas, data, bodies, film });
    this.context = canvas.getContext("2d");
    this.isSpace = data.dimension === 3;
    this.values = bodies.map((body) => new Float32Array(body.nodes));
    this.places = bodies.map((body) => new Float32Array(3 * body.nodes));
    this.shades = Array.from({ length: 8 }, (_, k) => {
      const light = 0.72 + 0.28 * (k / 7);
      return Uint32Array.from(data.colors, ([r, g, b]) => (255 << 24) | (Math.round(b * light) << 16) | (Math.round(g * light) << 8) | Math.round(r * light));
    });
    this.bounds = this.box();
    // The plane that opens bodies in space: its axis, and how far it is along their box.
    this.cut = null;
    this.fit();
  }

  // Middle and size of what the bodies ever cover: the undeformed points, widened by the largest displacement where that is not far.
  box() {
    const low = [Infinity, Infinity, Infinity], high = [-Infinity, -Infinity, -Infinity];
    for (const { points } of this.bodies) {
      for (let i = 0; i < points.length; i += 1) {
        low[i % 3] = Math.min(low[i % 3], points[i]);
        high[i % 3] = Math.max(high[i % 3], points[i]);
      }
    }
    const extent = Math.max(...[0, 1, 2].map((d) => high[d] - low[d]), 1e-300);
    // The far ends of springs and links, where they are not much farther away.
    const fixed = this.data.marks.flatMap(({ places }) => places.flatMap(({ point }) => (point ? [point] : [])));
    const near = fixed.filter((point) => point.every((x, d) => x > low[d] - extent && x < high[d] + extent));
    for (const point of near) point.forEach((x, d) => { [low[d], high[d]] = [Math.min(low[d], x), Math.max(high[d], x)]; });
    return { low, high, extent };
  }

  // Widens the box by where the bodies are now.
  widen(low, high) {
    for (let d = 0; d < 3; d += 1) {
      this.bounds.low[d] = Math.min(this.bounds.low[d], low[d]);
      this.bounds.high[d] = Math.max(this.bounds.high[d], high[d]);
    }
  }

  fit() {
    const { low, high } = this.bounds;
    this.center = [0, 1, 2].map((d) => 0.5 * (low[d] + high[d]));
    this.shift = [0, 0];
    this.magnify = 1;
    this.turn = this.isSpace ? [-0.65, 0.5] : [0, 0];
  }

  // Directions in the picture: right, up, toward the viewer.
  axes() {
    if (!this.isSpace) return [[1, 0, 0], [0, 1, 0], [0, 0, 1]];
    const [a, b] = this.turn, ca = Math.cos(a), sa = Math.sin(a), cb = Math.cos(b), sb = Math.sin(b);
    return [[ca, sa, 0], [-sb * sa, sb * ca, cb], [cb * sa, -cb * ca, sb]];
  }

  size() {
    const fineness = Math.min(window.devicePixelRatio || 1, 2);
    const width = Math.max(Math.round(this.canvas.clientWidth * fineness), 16), height = Math.max(Math.round(this.canvas.clientHeight * fineness), 16);
    if (this.canvas.width !== width || this.canvas.height !== height || !this.image) {
      this.canvas.width = width;
      this.canvas.height = height;
      this.image = this.context.createImageData(width, height);
      this.pixels = new Uint32Array(this.image.data.buffer);
      this.depths = this.isSpace ? new Float32Array(width * height) : null;
    }
    this.fineness = fineness;
    const { low, high } = this.bounds;
    if (this.isSpace) {
      const diagonal = Math.hypot(high[0] - low[0], high[1] - low[1], high[2] - low[2]);
      this.zoom = this.magnify * 0.86 * Math.min(width, height) / diagonal;
    } else {
      const room = 0.9;
      this.zoom = this.magnify * room * Math.min(width / Math.max(high[0] - low[0], 1e-300), height / Math.max(high[1] - low[1], 1e-300));
    }
  }

  // The plane of the cut: pixels with x p[0] + y p[1] + depth p[2] + p[3] > 0 are taken away, those on the viewer's side. Nodes in the plane
  // are left, whatever their round-off: it lies a hundredth of a pixel before them.
  plane() {
    if (!this.isSpace || !this.cut) return null;
    const { axis, share } = this.cut, { low, high } = this.bounds, { width, height } = this.canvas, { zoom, shift, center } = this;
    const [a, b, c] = this.axes().map((direction) => direction[axis]), sign = c < 0 ? -1 : 1;
    const at = low[axis] + share * (high[axis] - low[axis]) - center[axis];
    return [sign * a, -sign * b, sign * c, -sign * (a * (width / 2 + shift[0] * zoom) - b * (height / 2 + shift[1] * zoom) + at * zoom) - 0.01];
  }

  // Places of all nodes in pixels, with their depth, magnified displacements included.
  project(factor) {
    const [right, up, toward] = this.axes(), { width, height } = this.canvas, D = this.data.dimension;
    const [cx, cy, cz] = this.center, zoom = this.zoom;
    const x0 = width / 2 + this.shift[0] * zoom, y0 = height / 2 + this.shift[1] * zoom;
    this.bodies.forEach(({ points, nodes }, k) => {
      const out = this.places[k], values = this.film.now[k].values, u = values[0], v = values[1], w = D === 3 ? values[2] : null;
      for (let i = 0, j = 0; i < nodes; i += 1, j += 3) {
        const x = points[j] + factor * u[i] - cx, y = points[j + 1] + factor * v[i] - cy, z = points[j + 2] + (w ? factor * w[i] : 0) - cz;
        out[j] = x0 + zoom * (right[0] * x + right[1] * y + right[2] * z);
        out[j + 1] = y0 - zoom * (up[0] * x + up[1] * y + up[2] * z);
        out[j + 2] = zoom * (toward[0] * x + toward[1] * y + toward[2] * z);
      }
    });
  }

  place([x, y, z = 0]) {
    const [right, up] = this.axes(), p = [x - this.center[0], y - this.center[1], z - this.center[2]];
    const dot = (a) => a[0] * p[0] + a[1] * p[1] + a[2] * p[2];
    return [this.canvas.width / 2 + this.shift[0] * this.zoom + this.zoom * dot(right), this.canvas.height / 2 + this.shift[1] * this.zoom - this.zoom * dot(up)];
  }

  // One triangle with colors at its corners (0 to 255), clipped to the picture.
  triangle(ax, ay, az, av, bx, by, bz, bv, cx, cy, cz, cv, colors) {
    const { width } = this.canvas, { pixels, depths, knife } = this;
    const area = (bx - ax) * (cy - ay) - (cx - ax) * (by - ay);
    if (!(Math.abs(area) > 1e-6)) return;
    const gx = ((bv - av) * (cy - ay) - (cv - av) * (by - ay)) / area, gy = ((cv - av) * (bx - ax) - (bv - av) * (cx - ax)) / area;
    const hx = ((bz - az) * (cy - ay) - (cz - az) * (by - ay)) / area, hy = ((cz - az) * (bx - ax) - (bz - az) * (cx - ax)) / area;
    const rise = knife ? knife[0] + knife[2] * hx : 0;
    this.rows(ax, ay, bx, by, cx, cy, (y, first, last) => {
      let value = av + gx * (first + 0.5 - ax) + gy * (y - ay), at = (y - 0.5) * width + first;
      if (depths) {
        let depth = az + hx * (first + 0.5 - ax) + hy * (y - ay), beyond = knife ? this.beyond(first + 0.5, y, depth) : 0;
        for (let x = first; x <= last; x += 1, at += 1, value += gx, depth += hx, beyond += rise) {
          if (beyond <= 0 && depth > depths[at]) {
            depths[at] = depth;
            pixels[at] = colors[value < 0 ? 0 : value > 255 ? 255 : value | 0];
          }
        }
      } else {
        for (let x = first; x <= last; x += 1, at += 1, value += gx) pixels[at] = colors[value < 0 ? 0 : value > 255 ? 255 : value | 0];
      }
    });
  }

  // Pixels of a triangle, row by row: the middle of the row, its first and its last pixel.
  rows(ax, ay, bx, by, cx, cy, visit) {
    const { width, height } = this.canvas;
    const top = Math.max(Math.ceil(Math.min(ay, by, cy) - 0.5), 0), bottom = Math.min(Math.floor(Math.max(ay, by, cy) - 0.5), height - 1);
    for (let row = top; row <= bottom; row += 1) {
      const y = row + 0.5;
      let left = Infinity, right = -Infinity;
      // Where the row crosses the sides.
      if ((ay <= y) !== (by <= y)) { const x = ax + (bx - ax) * (y - ay) / (by - ay); if (x < left) left = x; if (x > right) right = x; }
      if ((by <= y) !== (cy <= y)) { const x = bx + (cx - bx) * (y - by) / (cy - by); if (x < left) left = x; if (x > right) right = x; }
      if ((cy <= y) !== (ay <= y)) { const x = cx + (ax - cx) * (y - cy) / (ay - cy); if (x < left) left = x; if (x > right) right = x; }
      visit(y, Math.max(Math.ceil(left - 0.5), 0), Math.min(Math.ceil(right - 0.5) - 1, width - 1));
    }
  }

  // How far a place of the picture lies on the side of the cut that is taken away.
  beyond(x, y, depth) {
    const { knife } = this;
    return knife[0] * x + knife[1] * y + knife[2] * depth + knife[3];
  }

  paintBody(k, plain) {
    const { triangles } = this.bodies[k], p = this.places[k], v = this.values[k], flat = plain ?? this.shades[7];
    for (let t = 0; t < triangles.length; t += 3) {
      const a = triangles[t], b = triangles[t + 1], c = triangles[t + 2], i = 3 * a, j = 3 * b, l = 3 * c;
      let colors = flat;
      if (this.isSpace) {
        const ux = p[j] - p[i], uy = p[j + 1] - p[i + 1], uz = p[j + 2] - p[i + 2], wx = p[l] - p[i], wy = p[l + 1] - p[i + 1], wz = p[l + 2] - p[i + 2];
        const nx = uy * wz - uz * wy, ny = uz * wx - ux * wz, nz = ux * wy - uy * wx;
        // The picture's y points down, so a facet that faces the viewer turns clockwise.
        if (nz >= 0) continue;
        const lit = (-0.21 * -nx + 0.4 * ny + 0.89 * -nz) / Math.hypot(nx, ny, nz);
        colors = plain ?? this.shades[Math.round(7 * clamp(lit, 0, 1))];
      }
      this.triangle(p[i], p[i + 1], p[i + 2], v[a], p[j], p[j + 1], p[j + 2], v[b], p[l], p[l + 1], p[l + 2], v[c], colors);
    }
  }

  // The face of the cut through a body: with the values inside where its cells are known, else plain where its surface is left more often
  // than entered behind the plane.
  paintCut(k, plain, color) {
    const { cells, triangles } = this.bodies[k], { knife } = this, p = this.places[k], v = this.values[k];
    if (Math.abs(knife[2]) < 1e-3) return;
    if (cells.length) {
      const heights = Float64Array.from({ length: p.length / 3 }, (_, i) => this.beyond(p[3 * i], p[3 * i + 1], p[3 * i + 2]));
      // Its faces lie in the plane, and are not cut themselves.
      this.knife = null;
      for (let t = 0; t < cells.length; t += 4) this.paintCell(cells.subarray(t, t + 4), heights, p, v, plain ?? this.shades[7]);
      this.knife = knife;
      return;
    }
    const { width, height } = this.canvas, inside = new Int8Array(width * height);
    for (let t = 0; t < triangles.length; t += 3) this.count(inside, p, 3 * triangles[t], 3 * triangles[t + 1], 3 * triangles[t + 2]);
    for (let y = 0, at = 0; y < height; y += 1) {
      for (let x = 0; x < width; x += 1, at += 1) {
        if (inside[at] <= 0) continue;
        const depth = -(knife[0] * (x + 0.5) + knife[1] * (y + 0.5) + knife[3]) / knife[2];
        if (depth <= this.depths[at]) continue;
        this.depths[at] = depth;
        this.pixels[at] = color;
      }
    }
  }

  // The cut through a tetrahedron.
  paintCell(corners, heights, p, v, colors) {
    const points = [];
    for (let i = 0; i < 4; i += 1) {
      for (let j = 0; j < i; j += 1) {
        const a = corners[i], b = corners[j];
        if ((heights[a] > 0) === (heights[b] > 0)) continue;
        const share = heights[a] / (heights[a] - heights[b]);
        points.push([0, 1, 2].map((d) => p[3 * a + d] + share * (p[3 * b + d] - p[3 * a + d])).concat(v[a] + share * (v[b] - v[a])));
      }
    }
    // All triangles of the points: of four they cover the quadrilateral whatever their order.
    for (let i = 2; i < points.length; i += 1) {
      for (let j = 1; j < i; j += 1) this.triangle(...points[0], ...points[j], ...points[i], colors);
    }
    if (points.length === 4) this.triangle(...points[1], ...points[2], ...points[3], colors);
  }

  // Counts a facet at the pixels behind the plane: 1 where it is seen from inside, -1 from outside.
  count(inside, p, i, j, l) {
    const { width } = this.canvas;
    const area = (p[j] - p[i]) * (p[l + 1] - p[i + 1]) - (p[l] - p[i]) * (p[j + 1] - p[i + 1]);
    if (!(Math.abs(area) > 1e-6)) return;
    const hx = ((p[j + 2] - p[i + 2]) * (p[l + 1] - p[i + 1]) - (p[l + 2] - p[i + 2]) * (p[j + 1] - p[i + 1])) / area;
    const hy = ((p[l + 2] - p[i + 2]) * (p[j] - p[i]) - (p[j + 2] - p[i + 2]) * (p[l] - p[i])) / area;
    this.rows(p[i], p[i + 1], p[j], p[j + 1], p[l], p[l + 1], (y, first, last) => {
      for (let x = first; x <= last; x += 1) {
        const depth = p[i + 2] + hx * (x + 0.5 - p[i]) + hy * (y - p[i + 1]);
        if (this.beyond(x + 0.5, y, depth) <= 0) inside[(y - 0.5) * width + x] += area > 0 ? 1 : -1;
      }
    });
  }

  // Surfaces of rigid obstacles in space, where they face the viewer.
  spaceWalls(look) {
    const [right, up, toward] = this.axes(), { width, height } = this.canvas, { zoom, center } = this;
    const x0 = width / 2 + this.shift[0] * zoom, y0 = height / 2 + this.shift[1] * zoom;
    const wall = parseInt(look.theme.wall.slice(1), 16);
    const colors = new Uint32Array(256), dot = (a, p) => a[0] * p[0] + a[1] * p[1] + a[2] * p[2];
    for (const [number, by, spin] of look.obstacles) {
      const turned = rotation(spin);
      const { points, triangles } = this.data.walls[number];
      const places = points.map((point) => {
        const there = turned(point), p = [0, 1, 2].map((d) => there[d] + by[d] - center[d]);
        return [x0 + zoom * dot(right, p), y0 - zoom * dot(up, p), zoom * dot(toward, p)];
      });
      for (const corners of triangles) {
        const [a, b, c] = corners.map((k) => places[k]);
        const u = [0, 1, 2].map((d) => b[d] - a[d]), w = [0, 1, 2].map((d) => c[d] - a[d]);
        const n = [u[1] * w[2] - u[2] * w[1], u[2] * w[0] - u[0] * w[2], u[0] * w[1] - u[1] * w[0]];
        if (n[2] >= 0) continue;
        const lit = (-0.21 * -n[0] + 0.4 * n[1] + 0.89 * -n[2]) / Math.hypot(...n);
        const light = 0.72 + 0.28 * clamp(lit, 0, 1), part = (shift) => Math.round(light * ((wall >> shift) & 255));
        colors.fill(((255 << 24) | (part(0) << 16) | (part(8) << 8) | part(16)) >>> 0);
        this.triangle(a[0], a[1], a[2], 0, b[0], b[1], b[2], 0, c[0], c[1], c[2], 0, colors);
      }
    }
  }

  // A line in space, hidden where a body is before it.
  hiddenLine(p, i, j, color) {
    const { width, height } = this.canvas;
    const steps = Math.ceil(Math.max(Math.abs(p[j] - p[i]), Math.abs(p[j + 1] - p[i + 1])));
    if (!(steps < 1e5)) return;
    for (let s = 0; s <= steps; s += 1) {
      const share = steps ? s / steps : 0;
      const x = Math.floor(p[i] + share * (p[j] - p[i])), y = Math.floor(p[i + 1] + share * (p[j + 1] - p[i + 1]));
      if (x < 0 || y < 0 || x >= width || y >= height) continue;
      const at = y * width + x, depth = p[i + 2] + share * (p[j + 2] - p[i + 2]);
      if (this.knife && this.beyond(x + 0.5, y + 0.5, depth) > this.fineness) continue;
      if (depth + 2.5 * this.fineness >= this.depths[at]) this.pixels[at] = color;
    }
  }

  // Draws the still that the film shows; `look`: field, range, factor, hasMesh, hasArrows, isUndeformed, colors of the theme.
  draw(look) {
    this.size();
    const { context, canvas } = this;
    this.project(look.factor);
    const [low, high] = look.range, factor = high > low ? 255.99 / (high - low) : 0;
    this.bodies.forEach((_, k) => {
      const values = this.film.field(look.field, k, this.values[k]);
      if (look.hasKinds) return;
      for (let i = 0; i < values.length; i += 1) values[i] = factor ? (values[i] - low) * factor : 0;
    });
    this.pixels.fill(look.theme.back);
    if (this.depths) this.depths.fill(-Infinity);
    this.knife = this.plane();
    const plain = look.hasKinds ? new Uint32Array(256).fill(look.theme.plain) : null;
    this.bodies.forEach((_, k) => this.paintBody(k, plain));
    if (this.knife) this.bodies.forEach((_, k) => this.paintCut(k, plain, look.theme.plain));
    if (this.isSpace) this.spaceWalls(look);
    if (this.isSpace) this.spaceLines(look);
    context.putImageData(this.image, 0, 0);
    if (!this.isSpace) {
      this.walls(look);
      this.planeLines(look);
    }
    if (look.isUndeformed) this.undeformed(look);
    if (look.hasArrows) this.arrows(look);
  }

  roomForMesh(k) {
    const { edges } = this.bodies[k], p = this.places[k];
    let sum = 0, count = 0;
    const stride = Math.max(Math.floor(edges.length / 1000), 1) * 2;
    for (let e = 0; e < edges.length; e += stride) {
      const i = 3 * edges[e], j = 3 * edges[e + 1];
      sum += Math.hypot(p[i] - p[j], p[i + 1] - p[j + 1]);
      count += 1;
    }
    return count > 0 && sum / count > 5 * this.fineness;
  }

  spaceLines(look) {
    this.bodies.forEach(({ edges, outline }, k) => {
      const p = this.places[k];
      if (look.hasMesh && this.roomForMesh(k)) for (let e = 0; e < edges.length; e += 2) this.hiddenLine(p, 3 * edges[e], 3 * edges[e + 1], look.theme.faint);
      for (let e = 0; e < outline.length; e += 2) this.hiddenLine(p, 3 * outline[e], 3 * outline[e + 1], look.theme.dark);
    });
  }

  path(pairs, p) {
    const { context } = this, { width, height } = this.canvas;
    context.beginPath();
    for (let e = 0; e < pairs.length; e += 2) {
      const i = 3 * pairs[e], j = 3 * pairs[e + 1];
      if ((p[i] < 0 && p[j] < 0) || (p[i] > width && p[j] > width) || (p[i + 1] < 0 && p[j + 1] < 0) || (p[i + 1] > height && p[j + 1] > height)) continue;
      context.moveTo(p[i], p[i + 1]);
      context.lineTo(p[j], p[j + 1]);
    }
    context.stroke();
  }

  planeLines(look) {
    const { context, fineness } = this;
    this.bodies.forEach(({ edges, outline }, k) => {
      const p = this.places[k];
      context.setLineDash([]);
      if (look.hasMesh && this.roomForMesh(k)) {
        context.strokeStyle = "rgba(0, 0, 0, 0.28)";
        context.lineWidth = 0.6 * fineness;
        this.path(edges, p);
      }
      context.strokeStyle = look.theme.ink;
      context.lineWidth = 1.2 * fineness;
      this.path(outline, p);
      if (look.hasKinds) this.kinds(look, outline, p, this.values[k]);
    });
  }

  // The outline in the colors of the kinds that its nodes are, each up to the middle of the pieces to its neighbors.
  kinds(look, outline, p, values) {
    const { context, fineness } = this;
    look.theme.kinds.forEach((color, kind) => {
      context.strokeStyle = color;
      context.lineWidth = 4 * fineness;
      context.beginPath();
      for (let e = 0; e < outline.length; e += 1) {
        if (values[outline[e]] !== kind + 1) continue;
        const i = 3 * outline[e], j = 3 * outline[e ^ 1];
        context.moveTo(p[i], p[i + 1]);
        context.lineTo(0.5 * (p[i] + p[j]), 0.5 * (p[i + 1] + p[j + 1]));
      }
      context.stroke();
    });
  }

  undeformed(look) {
    const { context, fineness } = this;
    context.strokeStyle = look.theme.ink;
    context.lineWidth = fineness;
    context.setLineDash([5 * fineness, 4 * fineness]);
    this.bodies.forEach(({ points, outline, nodes }) => {
      const p = new Float32Array(3 * nodes);
      for (const i of new Set(outline)) p.set(this.place([points[3 * i], points[3 * i + 1], points[3 * i + 2]]), 3 * i);
      this.path(outline, p);
    });
    context.setLineDash([]);
  }

  // Rigid obstacles of the plane where they are at this moment.
  walls(look) {
    const { context, fineness, data } = this;
    for (const [number, [dx, dy], spin] of look.obstacles) {
      const turned = rotation(spin);
      const { border, back, closed } = data.walls[number];
      const moved = (point) => {
        const [x, y] = turned([point[0], point[1], 0]);
        return this.place([x + dx, y + dy]);
      };
      const count = border.length - (closed ? 0 : 1);
      context.fillStyle = look.theme.wall;
      for (let k = 0; k < count; k += 1) {
        const next = (k + 1) % border.length;
        context.beginPath();
        [border[k], border[next], back[next], back[k]].forEach((point) => context.lineTo(...moved(point)));
        context.fill();
      }
      context.strokeStyle = look.theme.ink;
      context.lineWidth = 1.6 * fineness;
      context.beginPath();
      border.forEach((point) => context.lineTo(...moved(point)));
      if (closed) context.closePath();
      context.stroke();
    }
  }

  // Contact pressure on the secondary nodes: arrows that end where it presses.
  arrows(look) {
    const { context, fineness } = this, D = this.data.dimension, longest = 0.12 * this.bounds.extent * this.zoom, taken = new Set();
    const head = 8 * fineness, apart = 9 * fineness;
    if (!(this.data.pressing > 0) || this.isSpace) return;
    const lines = [];
    this.film.now.forEach(({ touching, pressing }, k) => {
      touching.forEach((node, i) => {
        const x = this.places[k][3 * node], y = this.places[k][3 * node + 1], vx = pressing[i * D], vy = pressing[i * D + 1];
        const length = Math.hypot(vx, vy) / this.data.pressing * longest;
        const key = `${Math.round(x / apart)} ${Math.round(y / apart)}`;
        if (!(length > fineness) || taken.has(key)) return;
        taken.add(key);
        const size = Math.hypot(vx, vy), ux = vx / size, uy = -vy / size, tip = Math.min(head, 0.5 * length);
        lines.push([x - ux * length, y - uy * length, x, y], [x - ux * tip - uy * 0.4 * tip, y - uy * tip + ux * 0.4 * tip, x, y], [x - ux * tip + uy * 0.4 * tip, y - uy * tip - ux * 0.4 * tip, x, y]);
      });
    });
    for (const [color, width] of [[look.theme.halo, 3.4], [look.theme.arrow, 1.6]]) {
      context.strokeStyle = color;
      context.lineWidth = width * fineness;
      context.beginPath();
      for (const [x0, y0, x1, y1] of lines) {
        context.moveTo(x0, y0);
        context.lineTo(x1, y1);
      }
      context.stroke();
    }
  }

  // The node next to a pixel of the page, within a few pixels.
  nearest(x, y) {
    let best = null, distance = (12 * this.fineness) ** 2, depth = -Infinity;
    this.bodies.forEach(({ nodes }, k) => {
      const p = this.places[k];
      for (let i = 0; i < nodes; i += 1) {
        if (this.knife && this.beyond(p[3 * i], p[3 * i + 1], p[3 * i + 2]) > 0) continue;
        const d = (p[3 * i] - x * this.fineness) ** 2 + (p[3 * i + 1] - y * this.fineness) ** 2;
        if (d < distance - 4 || (d < distance + 4 && p[3 * i + 2] > depth)) {
          distance = d;
          depth = p[3 * i + 2];
          best = { body: k, node: i };
        }
      }
    });
    return best;
  }

  // Zooms by a factor about a place in pixels of the page.
  zoomBy(factor, x = this.canvas.clientWidth / 2, y = this.canvas.clientHeight / 2) {
    const before = this.zoom, magnify = clamp(this.magnify * factor, 0.05, 5000), after = before * magnify / this.magnify;
    const px = x * this.fineness - this.canvas.width / 2, py = y * this.fineness - this.canvas.height / 2;
    this.shift[0] += px / after - px / before;
    this.shift[1] += py / after - py / before;
    this.magnify = magnify;
  }

  moveBy(dx, dy) {
    this.shift[0] += dx * this.fineness / this.zoom;
    this.shift[1] += dy * this.fineness / this.zoom;
  }
}
