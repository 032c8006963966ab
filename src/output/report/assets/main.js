// The page: puts the parts together, plays, and listens.

// Largest number of bodies with a color in the key.
const NAMED_BODIES = 24;

// The colors of the bodies, where they color the picture.
function bodyKey(list, { bodies, colors }) {
  const swatch = (k) => {
    const [r, g, b] = colors[Math.min(255, Math.floor((256 * (k + 0.5)) / bodies.length))];
    const box = element("span", { className: "swatch" });
    box.style.background = `rgb(${r}, ${g}, ${b})`;
    return box;
  };
  list.replaceChildren(...bodies.slice(0, NAMED_BODIES).map(({ name }, k) => element("li", {}, swatch(k), ` ${name}`)));
  if (bodies.length > NAMED_BODIES) list.append(element("li", { textContent: `and ${bodies.length - NAMED_BODIES} more` }));
}

class Page {
  constructor(data, columns, bodies) {
    Object.assign(this, { data, columns, bodies });
    this.time = columns.get("time");
    this.film = new Film(data, bodies);
    this.scene = new Scene($("canvas"), data, bodies, this.film);
    this.still = 0;
    this.row = data.stills.length ? data.stills[0].row : 0;
    this.isPlaying = false;
    this.isMoved = false;
    this.isAsked = false;
    this.redraws = 0;
    this.slowest = 0;
    this.describe();
    this.listen();
    this.go = (time) => this.goToRow(this.rowAt(time));
    this.own = this.chosen();
    this.nodes = new NodeCurves(this, (time) => this.isTimed() ? this.go(time) : this.goToStill(Math.round(time)));
    this.plot();
    this.ledger = new Ledger($("rows"), data, columns, (row) => this.goToRow(row));
    this.goToRow(this.row);
  }

  // What does not change with time.
  describe() {
    const { data } = this;
    data.fields.push({ name: "body", words: "body", low: -0.5, high: data.bodies.length - 0.5, kinds: [] });
    const outcome = $("outcome");
    outcome.textContent = data.outcome ?? `so far, t = ${brief(this.time[this.time.length - 1], 6)}`;
    outcome.className = `badge ${data.outcome === null ? "" : data.well ? "well" : "ill"}`;
    $("field").append(...data.fields.map(({ name, words: text }) => element("option", { value: name, textContent: text })));
    $("ramp").style.background = rampOf(data.colors);
    for (const id of ["turning", "turning-keys", "cutting"]) $(id).hidden = data.dimension === 2;
    $("made").textContent = `Made by Conserva ${data.version}.`;
    $("summary").hidden = !data.summary.length;
    $("summary-lines").append(...data.summary.flatMap(([name, text]) => [element("dt", { textContent: name }), element("dd", { textContent: text })]));
    // Rigid bodies have no stress.
    if (data.bodies.every(({ rigid }) => rigid)) $("field").value = "body";
    this.state();
    this.warn();
    this.explain();
    bodyKey($("body-key"), data);
    markKey($("marks-key"), data.marks);
    $("marks-label").hidden = !data.marks.length;
  }

  // The field that is shown.
  fieldNow() { return this.data.fields.find(({ name }) => name === $("field").value) ?? this.data.fields[0]; }

  // Whether stills differ by their times; equilibria at one time do not.
  isTimed() {
    const { stills } = this.data;
    return stills.length > 1 && stills[stills.length - 1].time > stills[0].time;
  }

  // What follows from the history and the stills as they are.
  state() {
    const { data } = this;
    $("moment").max = String(Math.max(data.stills.length - 1, 0));
    $("arrows-label").hidden = data.dimension === 3 || !(data.pressing > 0);
    $("ledger-note").textContent = data.rows === data.row_count
      ? `All ${data.rows} rows of history.csv with all their digits; a click goes to the row's time.`
      : `${data.rows} of the ${data.row_count} rows of history.csv, with all their digits: those of the animation, and of every stretch the last one and the peaks of defect, iterations, halvings and contact force. A click goes to the row's time.`;
    const shown = data.columns.filter((name) => !isZero(this.columns.get(name)) || ["step", "time", "energy_defect"].includes(name));
    if (this.readings && shown.length === this.readings.length) return;
    $("readout").replaceChildren();
    this.readings = shown.map((name) => {
      const value = element("dd", { "data-column": name });
      $("readout").append(element("div", {}, element("dt", { textContent: `${words(name)}${unitOf(data, "columns", name)}` }), value));
      return [value, name];
    });
  }

  warn() {
    const { data } = this;
    const warnings = data.warnings.map((text) => reachable(element("pre", { role: "group", "aria-label": "Warning", textContent: text.trimEnd() })));
    $("warning-list").replaceChildren(...(warnings.length ? warnings : [element("p", { textContent: "None." })]));
    $("to-warnings").textContent = warnings.length ? `Warnings (${warnings.length})` : "Warnings";
  }

  // The problem and the script, and what it printed and drew.
  explain() {
    const { data } = this;
    showPrinted(data);
    showPictures(data);
    $("tables").replaceChildren(...data.tables.flatMap((table) => [element("h3", { textContent: table.title }), tableOf(table)]));
    const parameters = Object.entries(data.parameters).map(([name, value]) => [name, String(value)]);
    $("parameters").replaceChildren(...(parameters.length ? [tableOf({ title: "Parameters", head: ["parameter", "value"], rows: parameters })] : []));
    $("sources").replaceChildren(...data.scripts.flatMap(({ name, text }) => [element("h3", { textContent: name }), reachable(element("pre", { role: "group", "aria-label": name, textContent: text }))]));
  }

  // The plots; those that are there already go on where they show the same quantities.
  plot() {
    const plots = plotsOf(this.data, this.columns);
    const names = ({ title, curves }) => [title, ...curves.map(({ label }) => label)].join("\n");
    if (this.plots && plots.map(names).join("\n\n") === this.plots.map(names).join("\n\n")) {
      this.plots.forEach((plot, k) => plot.renew(plots[k].curves, this.time));
    } else {
      this.plots = plots.map((plot) => new Plot(plot, this.time, this.go));
      $("figures").replaceChildren(...this.plots.map(({ figure }) => figure), this.own);
    }
  }

  // A plot of a column that the reader chooses.
  chosen() {
    const names = this.data.columns.filter((name) => !["step", "time"].includes(name));
    const choice = element("select", { "aria-label": "Column" }, ...names.map((name) => element("option", { textContent: name })));
    choice.value = this.data.contacts.length ? `${this.data.contacts[0]}.max_pressure` : "dt";
    const box = element("div", {});
    let plot = null;
    const curves = () => [{ label: `${choice.value}${unitOf(this.data, "columns", choice.value)}`, values: this.columns.get(choice.value) }];
    const make = () => {
      plot = new Plot({ title: "A column of your choice", curves: curves() }, this.time, this.go);
      plot.figure.append(element("label", {}, "Column ", choice));
      box.replaceChildren(plot.figure);
      plot.show(this.row);
    };
    choice.addEventListener("change", () => { make(); choice.focus(); });
    make();
    this.ownPlot = { show: (row) => plot.show(row), renew: () => plot.renew(curves(), this.time) };
    return box;
  }

  rowAt(time) {
    let low = 0, high = this.time.length - 1;
    while (low < high) {
      const middle = (low + high) >> 1;
      if (this.time[middle] < time) low = middle + 1;
      else high = middle;
    }
    return low > 0 && time - this.time[low - 1] < this.time[low] - time ? low - 1 : low;
  }

  // The still next to a row.
  stillAt(row) {
    const { stills } = this.data;
    let best = 0;
    stills.forEach((still, k) => { if (Math.abs(this.time[still.row] - this.time[row]) < Math.abs(this.time[stills[best].row] - this.time[row]) || (still.row === row)) best = k; });
    return best;
  }

  goToRow(row) {
    this.row = clamp(row, 0, this.data.rows - 1);
    this.still = this.stillAt(this.row);
    this.update();
  }

  goToStill(still) {
    this.still = clamp(still, 0, this.data.stills.length - 1);
    this.row = this.data.stills[this.still]?.row ?? 0;
    this.update();
  }

  update() {
    const { row } = this;
    for (const [value, name] of this.readings) {
      const number = this.columns.get(name)[row];
      value.textContent = brief(number);
      value.title = exact(number);
    }
    $("moment").value = String(this.still);
    $("clock").textContent = `t = ${inUnit(brief(this.time[row], 6), this.data, "columns", "time")}, step ${exact(this.columns.get("step")[row])}`;
    $("moment").setAttribute("aria-valuetext", $("clock").textContent);
    this.plots?.forEach((plot) => plot.show(row));
    this.ownPlot?.show(row);
    this.ledger?.show(row);
    this.nodes?.show();
    this.redraw();
  }

  redraw() {
    drawSoon(this);
  }

  range(field) {
    if ($("range").value === "own") {
      const [low, high] = [Number($("low").value.replace("−", "-")), Number($("high").value.replace("−", "-"))];
      if (Number.isFinite(low) && high > low) return [low, high];
    }
    if ($("range").value === "still") {
      let [low, high] = [Infinity, -Infinity];
      this.bodies.forEach((_, k) => {
        for (const value of this.film.field(field.name, k, this.scene.values[k])) {
          if (value < low) low = value;
          if (value > high) high = value;
        }
      });
      return [low, high];
    }
    return this.film.range(field);
  }

  draw() {
    if (!this.data.stills.length || !this.film.show(this.still)) return;
    const begun = performance.now();
    const field = this.fieldNow();
    const range = this.range(field);
    $("scale-title").textContent = titled(field, this.data);
    // Kinds of which there are none are not worth a choice.
    this.data.fields.forEach(({ kinds, high }, k) => { $("field").options[k].hidden = kinds.length > 0 && !(high > 0); });
    const { kinds } = field, theme = themeNow();
    const isBody = field.name === "body";
    const marks = isBody ? ["", "", ""] : kinds.length ? [`■ ${kinds[0]}`, "", `■ ${kinds[1]}`] : [range[0], 0.5 * (range[0] + range[1]), range[1]].map((value) => brief(value));
    ["scale-low", "scale-middle", "scale-high"].forEach((id, k) => {
      $(id).textContent = marks[k];
      $(id).style.color = kinds.length ? theme.kinds[k >> 1] : "";
    });
    $("ramp").hidden = kinds.length > 0 || isBody;
    $("body-key").hidden = !isBody;
    const hasArrows = $("arrows").checked && !$("arrows-label").hidden;
    $("arrow-key").textContent = hasArrows ? `→ contact pressure, longest of the run ${inUnit(brief(this.data.pressing), this.data, "fields", "contact_pressure")}` : "";
    const typed = $("factor").value.trim() === "" ? NaN : Number($("factor").value);
    const look = {
      field: field.name, range, factor: Number.isFinite(typed) ? typed : 1, hasMesh: $("mesh").checked, hasArrows,
      hasKinds: kinds.length > 0, isUndeformed: $("undeformed").checked, theme, obstacles: this.data.stills[this.still].obstacles,
    };
    this.scene.draw(look);
    if ($("marks").checked) drawMarks(this.scene, look);
    this.nodes.draw(look);
    this.redraws += 1;
    this.lastRedraw = performance.now() - begun;
    this.slowest = Math.max(this.slowest, this.lastRedraw);
  }

  play(isPlaying) {
    if (this.data.stills.length < 2) return;
    this.isPlaying = isPlaying;
    $("play").textContent = isPlaying ? "Pause" : "Play";
    $("play").setAttribute("aria-pressed", String(isPlaying));
    if (!isPlaying) return;
    const { stills } = this.data, last = stills.length - 1;
    if (this.still === last) this.goToStill(0);
    // The whole run takes ten seconds at the speed 1; equilibria at one time count as stills at equal distances.
    const isTimed = this.isTimed();
    const at = (k) => isTimed ? (stills[k].time - stills[0].time) / (stills[last].time - stills[0].time) : k / last;
    let position = at(this.still), before = null;
    const tick = (now) => {
      if (!this.isPlaying) return;
      position += before === null ? 0 : Math.min(now - before, 250) / 10000 * Number($("speed").value);
      before = now;
      let k = this.still;
      // Somebody has gone elsewhere.
      if (Math.abs(at(k) - position) > 0.2 && this.wasPlayed !== k) position = at(k);
      if (position > 1) {
        if (!$("repeat").checked) {
          this.goToStill(last);
          this.play(false);
          return;
        }
        position = 0;
        k = 0;
      }
      while (k < last && at(k + 1) <= position) k += 1;
      if (k !== this.still) this.goToStill(k);
      this.wasPlayed = k;
      requestAnimationFrame(tick);
    };
    requestAnimationFrame(tick);
  }

  listen() {
    const canvas = $("canvas"), { scene } = this;
    $("play").addEventListener("click", () => this.play(!this.isPlaying));
    $("moment").addEventListener("input", () => {
      this.play(false);
      this.goToStill(Number($("moment").value));
    });
    for (const id of ["field", "range", "mesh", "arrows", "undeformed", "marks"]) $(id).addEventListener("change", () => this.redraw());
    $("field").addEventListener("change", () => this.nodes.renew());
    for (const id of ["factor", "low", "high"]) $(id).addEventListener("input", () => this.redraw());
    $("range").addEventListener("change", () => {
      const isOwn = $("range").value === "own";
      if (isOwn && !$("low").value) [$("low").value, $("high").value] = [$("scale-low").textContent.replace("−", "-"), $("scale-high").textContent.replace("−", "-")];
      $("own-range").hidden = !isOwn;
    });
    listenToTheme(() => this.redraw());
    const whole = () => {
      this.isMoved = false;
      scene.fit();
      this.redraw();
    };
    const cut = (axis, by = 0) => {
      $("cut").value = axis;
      $("cut-at").value = String(Number($("cut-at").value) + by);
      $("cut-at").disabled = axis === "";
      scene.cut = axis === "" ? null : { axis: Number(axis), share: Number($("cut-at").value) / 1000 };
      $("cut-note").hidden = axis === "" || this.bodies.every(({ cells }) => cells.length > 0);
      this.redraw();
    };
    for (const id of ["cut", "cut-at"]) $(id).addEventListener("input", () => cut($("cut").value));
    const across = (axis) => () => cut($("cut").value === axis ? "" : axis);
    const jump = (still) => () => {
      this.play(false);
      this.goToStill(still());
    };
    const { zoom } = steer(canvas, [scene], {
      moved: () => {
        this.isMoved = true;
        this.redraw();
      },
      whole,
      keys: {
        " ": () => this.play(!this.isPlaying),
        "Home": jump(() => 0), "End": jump(() => this.data.stills.length - 1),
        "ArrowLeft": jump(() => this.still - 1), "ArrowRight": jump(() => this.still + 1),
        ...(scene.isSpace ? { x: across("0"), y: across("1"), z: across("2"), "[": () => cut($("cut").value, -25), "]": () => cut($("cut").value, 25) } : {}),
      },
      hover: (event) => this.tell(event),
      leave: () => { $("tip").hidden = true; },
      click: (event) => {
        const found = this.film.at >= 0 ? scene.nearest(event.offsetX, event.offsetY) : null;
        if (found) this.nodes.add(found.body, found.node);
      },
    });
    $("in").addEventListener("click", () => zoom(1.3));
    $("out").addEventListener("click", () => zoom(1 / 1.3));
    $("fit").addEventListener("click", whole);
    new ResizeObserver(() => { this.redraw(); this.ledger?.fill(); }).observe(canvas);
  }

  // What is under the pointer.
  tell(event) {
    const tip = $("tip"), found = this.film.at >= 0 ? this.scene.nearest(event.offsetX, event.offsetY) : null;
    tip.hidden = !found;
    if (!found) return;
    const field = this.fieldNow(), value = this.film.valueAt(field.name, this.film.at, found.body, found.node), told = field.kinds.length ? field.kinds[value - 1] ?? "no" : brief(value);
    const name = nodeName(this.bodies[found.body], found.node);
    tip.textContent = field.name === "body" ? name : `${name}: ${field.words} ${inUnit(told, this.data, "fields", field.name)}`;
    tip.style.left = `${Math.min(event.offsetX + 14, Math.max($("canvas").clientWidth - tip.offsetWidth - 4, 0))}px`;
    tip.style.top = `${$("canvas").offsetTop + event.offsetY + 14}px`;
  }

  // Unpacks the stills; the first picture is shown as soon as it is there, and the view fits all of them in the end.
  async load() {
    await this.film.load(() => this.redraw());
    this.widen(0);
    this.nodes.renew();
    document.documentElement.dataset.ready = "true";
  }

  // Makes room for the bodies in the stills from one on.
  widen(first) {
    const count = this.data.stills.length, stride = Math.max(Math.floor((count - first) / 24), 1);
    const low = [Infinity, Infinity, Infinity], high = [-Infinity, -Infinity, -Infinity];
    for (let k = first; k < count; k = k === count - 1 ? count : Math.min(k + stride, count - 1)) {
      this.film.show(k);
      this.bodies.forEach(({ points, nodes }, b) => {
        const { values } = this.film.now[b];
        for (let d = 0; d < this.data.dimension; d += 1) {
          for (let i = 0; i < nodes; i += 1) {
            const x = points[3 * i + d] + values[d][i];
            if (x < low[d]) low[d] = x;
            if (x > high[d]) high[d] = x;
          }
        }
      });
    }
    this.scene.widen(low, high);
    if (!this.isMoved) this.scene.fit();
    this.redraw();
  }
}

const begin = async () => {
  const data = JSON.parse($("data").textContent);
  if (typeof DecompressionStream === "undefined") throw new Error("this browser is too old: it cannot unpack the data (it needs DecompressionStream, of 2023)");
  const [columns, bodies] = [await readHistory(data), await readBodies(data)];
  const page = new Page(data, columns, bodies);
  // For those who look into the page with the tools of the browser.
  page.placeOf = (place) => placeOf(page.scene, place, 1);
  window.conserva = page;
  await page.load();
  if (data.live) follow(page, data.live);
};

begin().catch((error) => {
  $("trouble").hidden = false;
  $("trouble").textContent = `The report cannot be shown: ${error.message}`;
  console.error(error);
});
})();
