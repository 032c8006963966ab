// The page of several runs: their pictures side by side, their curves in one set of axes, what differs in their input.

// Largest ratio of the sizes of models that are drawn at one scale.
const ALIKE = 4;

// One run with its picture.
class Side {
  constructor(data, columns, bodies) {
    Object.assign(this, { data, columns, bodies, label: data.label });
    this.time = columns.get("time");
    this.film = new Film(data, bodies);
    data.fields.push({ name: "body", words: "body", low: -0.5, high: bodies.length - 0.5, kinds: [] });
    this.canvas = element("canvas", { tabIndex: 0, role: "img", "aria-label": `The bodies of ${data.label}`, "aria-describedby": "keys" });
    this.clock = element("span", { className: "quiet" });
    const badge = element("span", { className: `badge ${data.well ? "well" : "ill"}`, textContent: data.outcome ?? "not ended" });
    $("views").append(element("figure", { className: "view" }, element("figcaption", {}, element("span", { textContent: data.label }), " ", badge), this.canvas, this.clock));
    this.scene = new Scene(this.canvas, data, bodies, this.film);
    this.still = 0;
  }

  // Place of the entry of ascending times next to a time.
  static next(times, count, time) {
    let best = 0;
    for (let k = 1; k < count; k += 1) if (Math.abs(times(k) - time) <= Math.abs(times(best) - time)) best = k;
    return best;
  }

  go(time) {
    const { stills } = this.data;
    this.still = Side.next((k) => stills[k].time, stills.length, time);
    this.row = Side.next((k) => this.time[k], this.time.length, time);
    const end = this.time[this.time.length - 1];
    const told = (moment) => inUnit(brief(moment), this.data, "columns", "time");
    this.clock.textContent = !stills.length ? "no pictures were kept" : time > end * (1 + 1e-9) ? `ended at t = ${told(end)}` : `t = ${told(stills[this.still].time)}`;
  }

  field(name) { return this.data.fields.find((field) => field.name === name); }

  // Low and high end of what the bodies cover in all stills.
  bounds() {
    const { film, scene, data } = this, stride = Math.max(Math.floor(data.stills.length / 24), 1);
    const low = [Infinity, Infinity, Infinity], high = [-Infinity, -Infinity, -Infinity];
    for (let k = 0; k < data.stills.length; k += stride) {
      if (!film.show(k)) continue;
      this.bodies.forEach(({ points, nodes }, b) => {
        for (let d = 0; d < data.dimension; d += 1) {
          for (let i = 0; i < nodes; i += 1) {
            const x = points[3 * i + d] + film.now[b].values[d][i];
            [low[d], high[d]] = [Math.min(low[d], x), Math.max(high[d], x)];
          }
        }
      });
    }
    scene.widen(low, high);
    return scene.bounds;
  }
}

class Comparison {
  constructor(data, sides) {
    Object.assign(this, { data, sides, isAsked: false, isPlaying: false });
    const times = new Set();
    sides.forEach(({ data: { stills } }) => stills.forEach(({ time }) => times.add(time)));
    this.times = [...times].sort((a, b) => a - b);
    this.at = 0;
    this.describe();
    this.plot();
    this.compare();
    this.listen();
    this.goTo(0);
  }

  describe() {
    const { sides } = this, [first] = sides;
    // Fields that all runs have; rigid bodies have no stress.
    const common = first.data.fields.filter(({ name }) => sides.every((side) => side.field(name)));
    $("field").append(...common.map((field) => element("option", { value: field.name, textContent: titled(field, first.data) })));
    if (sides.every(({ bodies, data }) => data.bodies.every(({ rigid }) => rigid) && bodies.length)) $("field").value = "body";
    $("ramp").style.background = rampOf(first.data.colors);
    const isSpace = sides.some(({ data }) => data.dimension === 3);
    for (const id of ["turning", "turning-keys"]) $(id).hidden = !isSpace;
    $("moment").max = String(Math.max(this.times.length - 1, 0));
    $("made").textContent = `Made by Conserva ${this.data.version}.`;
    const versions = new Set(sides.map(({ data }) => data.version));
    const names = [...new Set(sides.flatMap(({ data }) => data.summary.map(([name]) => name)))];
    const rows = names.map((name) => [name, ...sides.map(({ data }) => data.summary.find((row) => row[0] === name)?.[1] ?? "–")]);
    $("summary").append(tableOf({ title: "Summary", head: ["what", ...sides.map(({ label }) => label)], rows }));
    if (versions.size > 1) $("summary").append(element("p", { className: "quiet", textContent: "These runs were made by different versions of the program." }));
  }

  plot() {
    const { sides } = this, go = (time) => this.goTo(Side.next((k) => this.times[k], this.times.length, time), time);
    const names = [...new Set(sides.flatMap(({ data }) => data.columns))].filter((name) => !["step", "time"].includes(name));
    const curves = (name) => sides.filter(({ columns }) => columns.has(name)).map((side) => ({ label: side.label, values: side.columns.get(name), time: side.time, side }));
    const contacts = [...new Set(sides.flatMap(({ data }) => data.contacts))];
    const wanted = [
      ["kinetic"], ["strain"], ["potential"], ["total"], ["energy_defect", { isLogarithmic: true }],
      ...contacts.map((name) => [`${name}.normal_force`]), ["max_penetration"], ["newton_iterations", { isStepped: true }],
    ];
    const isShown = ([name]) => curves(name).some(({ values }) => !isZero(values));
    this.plots = wanted.filter(isShown).map(([name, options]) => new Plot({ title: words(name), curves: curves(name), ...options }, sides[0].time, go));
    const choice = element("select", { "aria-label": "Column" }, ...names.map((name) => element("option", { textContent: name })));
    choice.value = names.includes("dt") ? "dt" : names[0];
    const box = element("div", {}), place = this.plots.length;
    const make = () => {
      this.plots[place] = new Plot({ title: "A column of your choice", curves: curves(choice.value) }, sides[0].time, go);
      this.plots[place].figure.append(element("label", {}, "Column ", choice));
      box.replaceChildren(this.plots[place].figure);
    };
    choice.addEventListener("change", () => { make(); this.update(); choice.focus(); });
    make();
    $("figures").append(...this.plots.slice(0, place).map(({ figure }) => figure), box);
  }

  // Tables beside one another, and what differs in the input.
  compare() {
    const { sides } = this, labels = sides.map(({ label }) => label), found = [];
    const parameters = [...new Set(sides.flatMap(({ data }) => Object.keys(data.parameters)))];
    const values = parameters.map((name) => [name, ...sides.map(({ data }) => (name in data.parameters ? String(data.parameters[name]) : "–"))]);
    const differ = values.filter(([, ...all]) => new Set(all).size > 1);
    if (differ.length) found.push(element("h3", { textContent: "Parameters" }), tableOf({ title: "Parameters that differ", head: ["parameter", ...labels], rows: differ }));
    const titles = [...new Set(sides.flatMap(({ data }) => data.tables.map(({ title }) => title)))], input = titles.filter((title) => !title.startsWith("Results") && !title.startsWith("Checks"));
    const merged = new Map(titles.map((title) => [title, mergedTable(title, sides)]));
    for (const title of input) {
      const { head, rows } = merged.get(title), own = rows.filter(([run]) => run !== "all");
      if (own.length) found.push(element("h3", { textContent: title }), tableOf({ title: `${title}: differences`, head, rows: own }));
    }
    const names = [...new Set(sides.flatMap(({ data }) => data.scripts.map(({ name }) => name)))];
    const text = ({ data }, name) => data.scripts.find((script) => script.name === name)?.text;
    for (const name of names) {
      const owners = sides.filter((side) => text(side, name) !== undefined), [base, ...others] = owners;
      if (owners.length < sides.length) found.push(element("p", { textContent: `Only a script of ${owners.map(({ label }) => label).join(", ")}: ${name}` }));
      for (const side of others) {
        if (text(side, name) === text(base, name)) continue;
        found.push(element("h3", { textContent: `${name}: ${base.label} and ${side.label}` }), differenceOf(text(base, name), text(side, name)));
      }
    }
    $("difference-list").append(...(found.length ? found : [element("p", { textContent: "None: parameters, models and scripts are equal." })]));
    const all = parameters.length ? [element("h3", { textContent: "Parameters" }), tableOf({ title: "Parameters", head: ["parameter", ...labels], rows: values })] : [];
    for (const title of titles) all.push(element("h3", { textContent: title }), tableOf({ title, ...merged.get(title) }));
    $("tables").append(...all);
    const warnings = sides.flatMap(({ label, data }) => (data.warnings.length ? [element("h3", { textContent: label }), ...data.warnings.map((warning) => reachable(element("pre", { role: "group", "aria-label": `Warning of ${label}`, textContent: warning.trimEnd() })))] : []));
    $("warning-list").append(...(warnings.length ? warnings : [element("p", { textContent: "None." })]));
    const sources = new Map();
    sides.forEach(({ label, data }) => data.scripts.forEach((script) => {
      const key = `${script.name}\n${script.text}`;
      sources.set(key, { ...script, labels: [...(sources.get(key)?.labels ?? []), label] });
    }));
    for (const { name, text: content, labels: runs } of sources.values()) {
      $("sources").append(element("h3", { textContent: `${name}: ${runs.join(", ")}` }), reachable(element("pre", { role: "group", "aria-label": `${name} of ${runs.join(", ")}`, textContent: content })));
    }
    this.pictures();
  }

  // Pictures of one name side by side.
  pictures() {
    const { sides } = this, paths = [...new Set(sides.flatMap(({ data }) => data.pictures.map(({ path }) => path)))];
    $("drawn").hidden = !paths.length;
    for (const path of paths) {
      const figures = sides.flatMap(({ data, label }) => data.pictures.map((picture, number) => [picture, number]).filter(([picture]) => picture.path === path).map(([picture, number]) => {
        const figure = pictureOf(picture, number, data.prefix);
        figure.querySelector("figcaption").textContent = label;
        return figure;
      }));
      $("drawn-list").append(element("h3", { textContent: path }), element("div", { className: "views" }, ...figures));
    }
  }

  goTo(at, time = this.times[clamp(at, 0, this.times.length - 1)] ?? 0) {
    this.at = clamp(at, 0, Math.max(this.times.length - 1, 0));
    this.now = time;
    this.update();
  }

  update() {
    this.sides.forEach((side) => side.go(this.now));
    $("moment").value = String(this.at);
    $("clock").textContent = `t = ${inUnit(brief(this.now), this.sides[0].data, "columns", "time")}`;
    $("moment").setAttribute("aria-valuetext", $("clock").textContent);
    this.plots.forEach((plot) => plot.mark(this.now, plot.curves.map(({ side }) => side.row)));
    this.redraw();
  }

  redraw() {
    drawSoon(this);
  }

  draw() {
    const name = $("field").value, theme = themeNow(), fields = this.sides.map((side) => side.field(name));
    const ranges = this.sides.map(({ film }, k) => film.range(fields[k])), low = Math.min(...ranges.map(([least]) => least)), high = Math.max(...ranges.map(([, most]) => most)), isEach = $("range").value === "run";
    const { kinds } = fields[0];
    $("scale-title").textContent = titled(fields[0], this.sides[0].data);
    const marks = kinds.length ? [`■ ${kinds[0]}`, "", `■ ${kinds[1]}`] : name === "body" ? ["first", "", "last"] : isEach ? ["least", "", "greatest"] : [low, 0.5 * (low + high), high].map((value) => brief(value));
    ["scale-low", "scale-middle", "scale-high"].forEach((id, k) => {
      $(id).textContent = marks[k];
      $(id).style.color = kinds.length ? theme.kinds[k >> 1] : "";
    });
    $("ramp").hidden = kinds.length > 0;
    const typed = $("factor").value.trim() === "" ? NaN : Number($("factor").value);
    this.sides.forEach((side, k) => {
      if (!side.data.stills.length || !side.film.show(side.still)) return;
      const range = isEach || name === "body" ? ranges[k] : [low, high];
      const look = {
        field: name, range, factor: Number.isFinite(typed) ? typed : 1, hasMesh: $("mesh").checked, hasArrows: false, hasKinds: kinds.length > 0,
        isUndeformed: false, theme, obstacles: side.data.stills[side.still].obstacles,
      };
      side.scene.draw(look);
      if ($("marks").checked) drawMarks(side.scene, look);
      if (isEach) side.clock.title = `${brief(range[0])} to ${brief(range[1])}`;
    });
  }

  play(isPlaying) {
    if (this.times.length < 2) return;
    this.isPlaying = isPlaying;
    $("play").textContent = isPlaying ? "Pause" : "Play";
    $("play").setAttribute("aria-pressed", String(isPlaying));
    if (!isPlaying) return;
    const { times } = this, begin = times[0], whole = times[times.length - 1] - begin;
    if (this.at === times.length - 1) this.goTo(0);
    let share = (this.now - begin) / whole, before = null;
    const tick = (now) => {
      if (!this.isPlaying) return;
      share += before === null ? 0 : Math.min(now - before, 250) / 10000;
      before = now;
      if (share > 1) share = 0;
      const at = Side.next((k) => times[k], times.length, begin + share * whole);
      if (at !== this.at) this.goTo(at);
      requestAnimationFrame(tick);
    };
    requestAnimationFrame(tick);
  }

  listen() {
    const scenes = this.sides.map(({ scene }) => scene), redraw = () => this.redraw();
    const whole = () => {
      scenes.forEach((scene) => scene.fit());
      this.redraw();
    };
    const jump = (at) => () => {
      this.play(false);
      this.goTo(at());
    };
    const keys = { " ": () => this.play(!this.isPlaying), "Home": jump(() => 0), "End": jump(() => this.times.length - 1), "ArrowLeft": jump(() => this.at - 1), "ArrowRight": jump(() => this.at + 1) };
    this.sides.forEach(({ canvas }) => {
      steer(canvas, scenes, { moved: redraw, whole, keys });
      new ResizeObserver(redraw).observe(canvas);
    });
    $("fit").addEventListener("click", whole);
    $("play").addEventListener("click", () => this.play(!this.isPlaying));
    $("moment").addEventListener("input", () => {
      this.play(false);
      this.goTo(Number($("moment").value));
    });
    for (const id of ["field", "range", "mesh", "marks"]) $(id).addEventListener("change", redraw);
    $("factor").addEventListener("input", redraw);
    listenToTheme(redraw);
  }

  // Unpacks the stills; models of about the same size are drawn at one scale.
  async load() {
    for (const side of this.sides) await side.film.load(redrawn(this));
    const bounds = this.sides.map((side) => side.bounds()), extents = bounds.map(({ low, high }) => Math.max(...high.map((x, d) => x - low[d])));
    const isAlike = new Set(this.sides.map(({ data }) => data.dimension)).size === 1 && Math.max(...extents) <= ALIKE * Math.min(...extents);
    if (isAlike) for (const { scene } of this.sides) bounds.forEach(({ low, high }) => scene.widen(low, high));
    else $("scale-note").textContent = "The models differ much in size or dimension: each picture has a scale of its own.";
    this.sides.forEach(({ scene }) => scene.fit());
    this.redraw();
    document.documentElement.dataset.ready = "true";
  }
}

const redrawn = (page) => () => page.redraw();

// A table of all runs: rows that are equal in all of them once, others by run.
const mergedTable = (title, sides) => {
  const tables = sides.map(({ data }) => data.tables.find((table) => table.title === title)), head = tables.find((table) => table)?.head ?? [];
  const widths = tables.flatMap((table) => table?.rows.map((row) => row.length) ?? []), width = Math.max(...widths, 1);
  const texts = tables.map((table) => (table?.rows ?? []).map((row) => row.join("\n")));
  const keys = [...new Set(tables.flatMap((table) => table?.rows.map(([key]) => key) ?? []))], rows = [];
  for (const key of keys) {
    const own = tables.map((table) => table?.rows.filter((row) => row[0] === key) ?? []), written = own.map((lines) => JSON.stringify(lines));
    if (new Set(written).size === 1) rows.push(...own[0].map((row) => ["all", ...row]));
    else own.forEach((lines, k) => rows.push(...(lines.length ? lines.map((row) => [sides[k].label, ...row]) : [[sides[k].label, key, ...new Array(width - 1).fill("–")]])));
  }
  const names = head.length ? head : ["what", ...Array.from({ length: width - 1 }, (_, k) => (k ? `value ${k + 1}` : "value"))];
  return { head: ["run", ...names], rows: texts.length ? rows : [] };
};

// Lines that differ between two texts, with those next to them: the longest common sequence of the lines between their equal ends.
const differenceOf = (before, after) => {
  const a = before.split("\n"), b = after.split("\n"), near = 2;
  let first = 0, last = 0;
  while (first < Math.min(a.length, b.length) && a[first] === b[first]) first += 1;
  while (last < Math.min(a.length, b.length) - first && a[a.length - 1 - last] === b[b.length - 1 - last]) last += 1;
  const m = a.length - first - last, n = b.length - first - last, all = [];
  a.slice(0, first).forEach((line) => all.push([" ", line]));
  if (m * n <= 4e6) {
    const best = Array.from({ length: m + 1 }, () => new Uint32Array(n + 1));
    for (let i = m - 1; i >= 0; i -= 1) for (let j = n - 1; j >= 0; j -= 1) best[i][j] = a[first + i] === b[first + j] ? best[i + 1][j + 1] + 1 : Math.max(best[i + 1][j], best[i][j + 1]);
    for (let i = 0, j = 0; i < m || j < n;) {
      if (i < m && j < n && a[first + i] === b[first + j]) {
        all.push([" ", a[first + i]]);
        [i, j] = [i + 1, j + 1];
      } else if (j >= n || (i < m && best[i + 1][j] >= best[i][j + 1])) {
        all.push(["−", a[first + i]]);
        i += 1;
      } else {
        all.push(["+", b[first + j]]);
        j += 1;
      }
    }
  } else {
    a.slice(first, a.length - last).forEach((line) => all.push(["−", line]));
    b.slice(first, b.length - last).forEach((line) => all.push(["+", line]));
  }
  a.slice(a.length - last).forEach((line) => all.push([" ", line]));
  const isNear = all.map((_, k) => all.slice(Math.max(k - near, 0), k + near + 1).some(([sign]) => sign !== " "));
  const lines = [];
  all.forEach(([sign, line], k) => {
    if (!isNear[k]) {
      if (k === 0 || isNear[k - 1]) lines.push(element("span", { className: "gone", textContent: "…\n" }));
    } else lines.push(element("span", { className: sign === "+" ? "added" : sign === "−" ? "removed" : "", textContent: `${sign} ${line}\n` }));
  });
  return reachable(element("pre", { role: "group", "aria-label": "Lines that differ" }, ...lines));
};

const begin = async () => {
  const data = JSON.parse($("data").textContent);
  if (typeof DecompressionStream === "undefined") throw new Error("this browser is too old: it cannot unpack the data (it needs DecompressionStream, of 2023)");
  const sides = [];
  for (const run of data.runs) sides.push(new Side(run, await readHistory(run), await readBodies(run)));
  const page = new Comparison(data, sides);
  // For those who look into the page with the tools of the browser.
  window.conserva = page;
  await page.load();
};

begin().catch((error) => {
  $("trouble").hidden = false;
  $("trouble").textContent = `The page cannot be shown: ${error.message}`;
  console.error(error);
});
})();
