// Supports, loads, springs and joints in the picture, and their key.

// Kinds of symbols: color, words, and the symbol of the key in a box of 22 by 12.
const MARKS = {
  support: { color: "held", words: "held", key: "M11 1L16 11L6 11Z", isFilled: true },
  motion: { color: "held", words: "moved", key: "M11 1L16 11L6 11Z" },
  load: { color: "load", words: "load", key: "M1 6L20 6M20 6L14 2M20 6L14 10" },
  pressure: { color: "load", words: "pressure", key: "M1 2L1 10M4 6L20 6M20 6L14 2M20 6L14 10" },
  torque: { color: "load", words: "torque", key: "M15 9A5 5 0 1 1 15 3M15 3L10 3M15 3L15 8" },
  gravity: { color: "load", words: "gravity", key: "M11 0L11 12M11 12L7 7M11 12L15 7" },
  line: { color: "part", words: "force element", key: "M1 6L5 6L7 1L11 11L15 1L17 6L21 6" },
  point: { color: "part", words: "force element", key: "M11 2L15 6L11 10L7 6Z" },
  joint: { color: "joint", words: "joint", key: "M15 6A4 4 0 1 1 7 6A4 4 0 1 1 15 6" },
  link: { color: "joint", words: "link", key: "M4 6L18 6M4 6A2 2 0 1 1 0 6A2 2 0 1 1 4 6M22 6A2 2 0 1 1 18 6A2 2 0 1 1 22 6" },
};
// Largest number of names of a kind in the key.
const NAMED = 6;

// The key: each kind with the names of what is drawn so.
const markKey = (list, marks) => {
  const kinds = Object.keys(MARKS).filter((kind) => marks.some((mark) => mark.kind === kind));
  list.hidden = !kinds.length;
  list.replaceChildren(...kinds.map((kind) => {
    const { key, words: text, color, isFilled } = MARKS[kind];
    const own = marks.filter((mark) => mark.kind === kind), names = own.slice(0, NAMED).map(({ name, words: detail }) => {
      const said = detail && detail !== text ? ` (${detail})` : "";
      return `${name}${said}`;
    }).filter((name) => name);
    const more = own.length > NAMED ? ` and ${own.length - NAMED} more` : "";
    const sample = svg("svg", { viewBox: "0 0 22 12", class: `mark ${color}${isFilled ? " filled" : ""}`, "aria-hidden": "true" }, svg("path", { d: key }));
    return element("li", {}, sample, ` ${text}${names.length ? `: ${names.join(", ")}` : ""}${more}`);
  }));
};

// Where a place is in the still that is shown, with displacements times a factor.
const placeOf = ({ data, film, bodies }, place, factor) => {
  if (place.point) return place.point;
  const { points } = bodies[place.body], { values } = film.now[place.body], out = [0, 0, 0];
  place.nodes.forEach((node, k) => {
    for (let d = 0; d < 3; d += 1) out[d] += place.shares[k] * (points[3 * node + d] + (d < data.dimension ? factor * values[d][node] : 0));
  });
  return out;
};

// Draws the symbols over the picture of a scene.
const drawMarks = (scene, look) => {
  const { context, fineness, data, bodies } = scene, size = 10 * fineness;
  const axes = scene.axes(), lines = { held: [], load: [], part: [], joint: [] }, filled = { held: [] };
  const position = (place) => placeOf(scene, place, look.factor);
  // A direction in the picture: its two components, y down, and the one toward the viewer.
  const flat = (v) => {
    const [x, y, z] = axes.map((a) => a[0] * v[0] + a[1] * v[1] + a[2] * v[2]);
    return [x, -y, z];
  };
  const unit = (v) => {
    const length = Math.hypot(...v);
    return length > 0 ? v.map((x) => x / length) : v;
  };
  // In space symbols of surfaces are drawn where the viewer sees their place.
  const isSeen = (p) => {
    if (!scene.isSpace) return true;
    const q = p.map((x, d) => x - scene.center[d]), depth = scene.zoom * flat(q)[2], [x, y] = scene.place(p).map(Math.floor), { width, height } = scene.canvas;
    return x < 0 || y < 0 || x >= width || y >= height || depth + 6 * fineness >= scene.depths[y * width + x];
  };
  const arrow = (color, [x, y], direction, isFrom = false) => {
    const [dx, dy] = flat(unit(direction)), length = 2.6 * size, shown = Math.hypot(dx, dy);
    if (shown < 0.15) {
      lines[color].push([[x - 0.3 * size, y - 0.3 * size], [x + 0.3 * size, y + 0.3 * size]], [[x - 0.3 * size, y + 0.3 * size], [x + 0.3 * size, y - 0.3 * size]]);
      return;
    }
    const [ux, uy] = [dx / shown, dy / shown], head = 0.7 * size, end = isFrom ? [x + dx * length, y + dy * length] : [x, y], start = isFrom ? [x, y] : [x - dx * length, y - dy * length];
    lines[color].push([start, end], [end, [end[0] - head * ux - 0.45 * head * uy, end[1] - head * uy + 0.45 * head * ux]], [end, [end[0] - head * ux + 0.45 * head * uy, end[1] - head * uy - 0.45 * head * ux]]);
  };
  const ring = (color, [x, y], radius) => lines[color].push(Array.from({ length: 17 }, (_, k) => [x + radius * Math.cos(k * Math.PI / 8), y + radius * Math.sin(k * Math.PI / 8)]));
  const boxes = bodies.map(({ points, nodes }) => {
    const low = [Infinity, Infinity, Infinity], high = [-Infinity, -Infinity, -Infinity];
    for (let i = 0; i < 3 * nodes; i += 1) [low[i % 3], high[i % 3]] = [Math.min(low[i % 3], points[i]), Math.max(high[i % 3], points[i])];
    return low.map((x, d) => [0.5 * (x + high[d]), 0.5 * (high[d] - x)]);
  });
  // Outward from the middle of a body: along an axis from a side of its box.
  const outward = ({ body, nodes }) => {
    const { points } = bodies[body], from = boxes[body].map(([center, half], d) => (half > 0 ? (points[3 * nodes[0] + d] - center) / half : 0));
    const side = from.findLastIndex((x) => Math.abs(x) > 0.99);
    return side < 0 ? unit(from) : from.map((x, d) => (d === side ? Math.sign(x) : 0));
  };
  const draw = {
    // A triangle outside of the node: one where all directions are held, else one for each.
    support: ({ held, kind }, p, place) => {
      const [x, y] = scene.place(p), all = held.slice(0, data.dimension), out = outward(place);
      const directions = all.every((isHeld) => isHeld) ? [out] : all.flatMap((isHeld, d) => (isHeld ? [[0, 1, 2].map((e) => (e === d ? (out[d] > 0 ? 1 : -1) : 0))] : []));
      for (const direction of directions) {
        const [ux, uy] = flat(direction), height = 0.9 * size, half = 0.5 * size, shown = Math.hypot(ux, uy);
        if (shown < 0.15) continue;
        const base = [x + height * ux, y + height * uy], across = [-uy / shown * half, ux / shown * half];
        const triangle = [[x, y], [base[0] + across[0], base[1] + across[1]], [base[0] - across[0], base[1] - across[1]], [x, y]];
        (kind === "support" ? filled.held : lines.held).push(triangle);
      }
    },
    load: ({ along }, p) => arrow("load", scene.place(p), along),
    // Into the body, from the outer side of the facet.
    pressure: (_, p, place) => {
      const corners = place.nodes.map((node) => position({ body: place.body, nodes: [node], shares: [1] }));
      const u = corners[1].map((x, d) => x - corners[0][d]);
      if (corners.length === 2) return arrow("load", scene.place(p), [-u[1], u[0], 0]);
      const w = corners[2].map((x, d) => x - corners[0][d]);
      return arrow("load", scene.place(p), [0, 1, 2].map((d) => -(u[(d + 1) % 3] * w[(d + 2) % 3] - u[(d + 2) % 3] * w[(d + 1) % 3])));
    },
    torque: ({ along }, p) => {
      const [x, y] = scene.place(p), radius = 1.3 * size;
      if (scene.isSpace) {
        arrow("load", [x, y], along, true);
        return;
      }
      const arc = Array.from({ length: 20 }, (_, k) => [x + radius * Math.cos(0.25 * k + 0.5), y - radius * Math.sin(0.25 * k + 0.5)]), [end, before] = [arc[19], arc[17]];
      const [tx, ty] = unit([end[0] - before[0], end[1] - before[1]]), head = 0.7 * size;
      lines.load.push(arc, [end, [end[0] - head * tx - 0.5 * head * ty, end[1] - head * ty + 0.5 * head * tx]], [end, [end[0] - head * tx + 0.5 * head * ty, end[1] - head * ty - 0.5 * head * tx]]);
    },
    // A zigzag between the ends.
    line: ({ places }) => {
      const [a, b] = places.map((place) => scene.place(position(place))), v = [b[0] - a[0], b[1] - a[1]], length = Math.hypot(...v);
      const [ux, uy] = length > 0 ? [v[0] / length, v[1] / length] : [0, 0], width = 0.45 * size, turns = 8;
      // Coils of a fixed length in the middle of the line.
      const half = Math.min(0.3, 2.2 * size / Math.max(length, 1));
      const at = (share, off) => [a[0] + share * v[0] - off * uy, a[1] + share * v[1] + off * ux];
      const zigzag = Array.from({ length: turns }, (_, k) => at(0.5 - half + 2 * half * (k + 0.5) / turns, k % 2 ? -width : width));
      lines.part.push([a, at(0.5 - half, 0), ...zigzag, at(0.5 + half, 0), b]);
      for (const end of [a, b]) ring("part", end, 0.2 * size);
    },
    point: (_, p) => {
      const [x, y] = scene.place(p), h = 0.5 * size;
      lines.part.push([[x, y - h], [x + h, y], [x, y + h], [x - h, y], [x, y - h]]);
    },
    joint: ({ along, words: text }, p) => {
      const [x, y] = scene.place(p), [dx, dy] = flat(unit(along)), far = 1.5 * size, h = 0.45 * size;
      if (text.startsWith("weld")) lines.joint.push([[x - h, y - h], [x + h, y - h], [x + h, y + h], [x - h, y + h], [x - h, y - h]]);
      else ring("joint", [x, y], 0.5 * size);
      if (Math.hypot(dx, dy) > 0.15) lines.joint.push([[x - far * dx, y - far * dy], [x + far * dx, y + far * dy]]);
    },
    link: ({ places }) => {
      const ends = places.map((place) => scene.place(position(place)));
      lines.joint.push(ends);
      for (const end of ends) ring("joint", end, 0.35 * size);
    },
  };
  draw.motion = draw.support;
  for (const mark of data.marks) {
    if (mark.kind === "gravity") arrow("load", [scene.canvas.width - 3.4 * size, 0.9 * size + 2.6 * size * 0.5], mark.along.map((x) => 0.8 * x / Math.hypot(...mark.along)), true);
    else if (mark.places.length === 2 && (mark.kind === "line" || mark.kind === "link")) draw[mark.kind](mark);
    else for (const place of mark.places) {
      const p = position(place);
      if (!["support", "motion", "load", "pressure"].includes(mark.kind) || isSeen(p)) draw[mark.kind](mark, p, place);
    }
  }
  const trace = (all, isFilled) => {
    context.beginPath();
    for (const points of all) points.forEach(([x, y], k) => (k ? context.lineTo(x, y) : context.moveTo(x, y)));
    if (isFilled) context.fill();
    context.stroke();
  };
  context.setLineDash([]);
  context.lineJoin = "round";
  for (const [kind, all] of Object.entries(lines)) {
    for (const [color, width] of [[look.theme.halo, 4], [look.theme.marks[kind], 1.8]]) {
      [context.strokeStyle, context.lineWidth] = [color, width * fineness];
      trace(all, false);
    }
  }
  [context.strokeStyle, context.fillStyle, context.lineWidth] = [look.theme.halo, look.theme.marks.held, 1.2 * fineness];
  trace(filled.held, true);
};
