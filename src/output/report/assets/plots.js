// Plots of the history, with a line at the animation's time.

const WIDTH = 560, HEIGHT = 210, RIGHT = 10, TOP = 10, BOTTOM = 26;
// Width of a letter of the numbers at the axes, which are 11 pixels high, at most.
const LETTER = 7;
const DASHES = ["", "7 3", "2 3", "9 3 2 3", "12 4", "4 2 1 2"];

class Plot {
  // `curves`: label and values, and the times where they are others than `time`; `isLogarithmic`: sizes on a logarithmic axis; `isStepped`: values of steps; `go`: goes to a row.
  constructor({ title, curves, isLogarithmic = false, isStepped = false, over = "time" }, time, go) {
    this.time = time;
    this.curves = curves;
    this.isLogarithmic = isLogarithmic;
    this.isStepped = isStepped;
    this.svg = svg("svg", { viewBox: `0 0 ${WIDTH} ${HEIGHT}`, role: "img" });
    this.legend = element("ul", { className: "legend" });
    this.figure = element("figure", {}, element("figcaption", { textContent: title }), this.svg, this.legend);
    this.title = title;
    this.over = over;
    this.draw();
    const pick = (event) => {
      const frame = this.svg.getBoundingClientRect();
      const x = (event.clientX - frame.left) / frame.width * WIDTH;
      go(this.t0 + clamp((x - this.left) / (WIDTH - this.left - RIGHT), 0, 1) * (this.t1 - this.t0));
    };
    this.svg.addEventListener("pointerdown", (event) => {
      this.svg.setPointerCapture(event.pointerId);
      pick(event);
    });
    this.svg.addEventListener("pointermove", (event) => { if (event.buttons & 1) pick(event); });
  }

  // Shows other values of the same quantities.
  renew(curves, time) {
    [this.curves, this.time] = [curves, time];
    this.draw();
  }

  x(time) { return this.t1 > this.t0 ? this.left + (time - this.t0) / (this.t1 - this.t0) * (WIDTH - this.left - RIGHT) : this.left; }

  timeOf({ time }) { return time ?? this.time; }

  y(value) {
    const scaled = this.isLogarithmic ? Math.log10(Math.max(Math.abs(value), this.floor)) : value;
    return HEIGHT - BOTTOM - (scaled - this.low) / (this.high - this.low) * (HEIGHT - TOP - BOTTOM);
  }

  range() {
    let low = Infinity, high = -Infinity;
    for (const { values } of this.curves) {
      for (let value of values) {
        if (!Number.isFinite(value)) continue;
        if (this.isLogarithmic) {
          if (value === 0) continue;
          value = Math.log10(Math.abs(value));
        }
        if (value < low) low = value;
        if (value > high) high = value;
      }
    }
    if (this.isLogarithmic) {
      if (!(low <= high)) [low, high] = [-17, -16];
      // What is smaller than round-off needs no room.
      low = Math.max(Math.floor(low), Math.ceil(high) - 16);
      high = Math.max(Math.ceil(high), low + 1);
      this.floor = 10 ** low;
    } else {
      if (!(low <= high)) [low, high] = [0, 1];
      const room = high > low ? 0.05 * (high - low) : Math.max(Math.abs(high), 1e-300) * 0.5 || 1;
      const touchesZero = low >= 0 && low < 0.3 * high;
      low = touchesZero ? 0 : low - room;
      high += room;
    }
    [this.low, this.high] = [low, high];
  }

  draw() {
    const times = this.curves.map((curve) => this.timeOf(curve));
    this.t0 = Math.min(...times.map((time) => time[0]));
    this.t1 = Math.max(...times.map((time) => time[time.length - 1]));
    this.range();
    this.svg.replaceChildren();
    this.legend.replaceChildren();
    const ends = this.curves.map(({ label, values }) => {
      let [low, high] = [Infinity, -Infinity];
      for (const value of values) if (Number.isFinite(value)) [low, high] = [Math.min(low, value), Math.max(high, value)];
      return low <= high ? `${label} from ${brief(low)} to ${brief(high)}` : `${label} without values`;
    });
    this.svg.setAttribute("aria-label", `${this.title} over ${this.over}: ${ends.join("; ")}`);
    const marks = [];
    if (this.isLogarithmic) {
      const stride = Math.max(Math.ceil((this.high - this.low) / 5), 1);
      for (let power = this.low; power <= this.high; power += stride) marks.push([power, `1e${power}`.replace("-", "−")]);
    } else {
      const values = ticks(this.low, this.high, 4);
      tickTexts(values).forEach((text, k) => marks.push([values[k], text]));
    }
    this.left = Math.max(...marks.map(([, text]) => LETTER * text.length), 28) + 10;
    const text = (x, y, content, anchor) => this.svg.append(svg("text", { x, y, "text-anchor": anchor }, content));
    for (const [value, content] of marks) {
      const y = HEIGHT - BOTTOM - (value - this.low) / (this.high - this.low) * (HEIGHT - TOP - BOTTOM);
      this.svg.append(svg("line", { class: "grid", x1: this.left, x2: WIDTH - RIGHT, y1: y, y2: y }));
      text(this.left - 6, y + 4, content, "end");
    }
    const values = ticks(this.t0, this.t1, 6);
    tickTexts(values).forEach((content, k) => {
      const half = 0.5 * LETTER * content.length;
      text(clamp(this.x(values[k]), half, WIDTH - half), HEIGHT - 8, content, "middle");
    });
    this.dots = this.curves.map((curve, k) => {
      const { label } = curve, color = `var(--c${k % 6})`, dash = DASHES[k % DASHES.length];
      this.svg.append(svg("path", { class: "curve", d: this.curve(curve), stroke: color, style: `stroke:${color}`, "stroke-dasharray": dash }));
      const sample = svg("svg", { viewBox: "0 0 30 8" }, svg("line", { x1: 0, x2: 30, y1: 4, y2: 4, style: `stroke:${color};stroke-width:2`, "stroke-dasharray": dash }));
      const value = element("b", {});
      this.legend.append(element("li", {}, sample, ` ${label} `, value));
      return { dot: svg("circle", { class: "dot", r: 3.5, style: `fill:${color}` }), value };
    });
    this.cursor = svg("line", { class: "cursor", y1: TOP, y2: HEIGHT - BOTTOM });
    this.svg.append(this.cursor, ...this.dots.map(({ dot }) => dot));
  }

  // A path through all values; where there are several for a pixel, through the first, least, greatest and last of them.
  curve(curve) {
    const { values } = curve, time = this.timeOf(curve);
    const parts = [];
    let isOn = false, lastY = 0;
    const put = (i) => {
      if (!Number.isFinite(values[i])) {
        isOn = false;
        return;
      }
      const x = this.x(time[i]).toFixed(1), y = this.y(values[i]).toFixed(1);
      if (isOn && this.isStepped) parts.push(`H${x}V${y}`);
      else parts.push(`${isOn ? "L" : "M"}${x} ${y}`);
      isOn = true;
      lastY = y;
    };
    const dense = values.length > 3 * WIDTH;
    for (let i = 0; i < values.length;) {
      let j = i + 1, least = i, greatest = i;
      if (dense) {
        const pixel = Math.floor(this.x(time[i]) * 1.5);
        for (; j < values.length && Math.floor(this.x(time[j]) * 1.5) === pixel; j += 1) {
          if (values[j] < values[least]) least = j;
          if (values[j] > values[greatest]) greatest = j;
        }
      }
      for (const k of [...new Set([i, Math.min(least, greatest), Math.max(least, greatest), j - 1])]) put(k);
      i = j;
    }
    return parts.join("");
  }

  show(row) { this.mark(this.time[row], this.curves.map(() => row)); }

  // Marks a time, and shows the value of each curve in its row of the history.
  mark(time, rows) {
    const x = this.x(time);
    this.cursor.setAttribute("x1", x);
    this.cursor.setAttribute("x2", x);
    this.dots.forEach(({ dot, value }, k) => {
      const number = this.curves[k].values[rows[k]];
      value.textContent = brief(number);
      dot.setAttribute("cx", this.x(this.timeOf(this.curves[k])[rows[k]]));
      dot.setAttribute("cy", Number.isFinite(number) ? clamp(this.y(number), TOP, HEIGHT - BOTTOM) : -10);
    });
  }
}

const isZero = (values) => values.every((value) => !(Math.abs(value) > 0));

// The plots of a run.
const plotsOf = (data, columns) => {
  const curve = (name, label = words(name)) => ({ label: `${label}${unitOf(data, "columns", name)}`, values: columns.get(name) });
  const some = (names) => names.filter((name) => columns.has(name) && !isZero(columns.get(name))).map((name) => curve(name));
  const plots = [
    { title: "Energies", curves: [...some(["kinetic", "strain", "potential"]), curve("total")] },
    { title: "Momenta", curves: some(["momentum_x", "momentum_y", "momentum_z", "angular_momentum"]) },
    { title: "Ledger defects (sizes)", isLogarithmic: true, curves: ["energy_defect", "momentum_defect", "angular_momentum_defect"].map((name) => curve(name)) },
    { title: "Contact forces", curves: data.contacts.map((name) => curve(`${name}.normal_force`, name)) },
    { title: "Newton iterations and halvings", isStepped: true, curves: [curve("newton_iterations"), curve("halvings")] },
    { title: "Work and dissipation in each step", curves: some(["load_work", "contact_work", "friction_work", "dissipation"]) },
    { title: "Deepest penetration", curves: some(["max_penetration"]) },
  ];
  return plots.filter(({ curves }) => curves.length > 0);
};
