// Following a run: asks the server that gave the page for what is new, and puts it into the page.

// Time between two questions in milliseconds; while nobody answers, and how often that may be.
const EVERY = 600, SLOWLY = 3000, PATIENCE = 4;

class Follower {
  constructor(page, live) {
    Object.assign(this, { page, live, change: live.change, failures: 0, isNewest: true, others: "" });
    this.reader = crypto.getRandomValues(new Uint32Array(1))[0];
    this.stillRows = live.stillRows;
    this.box = element("input", { type: "checkbox", id: "newest", checked: true });
    $("keys").before(element("label", { className: "check" }, this.box, " Follow the run"));
    this.box.addEventListener("change", () => { if (this.box.checked) this.goToNewest(); });
    this.note = element("p", { id: "following", className: "quiet", role: "status" });
    this.runs = element("p", { id: "simulations", className: "quiet", hidden: true });
    document.querySelector("header").after(element("div", { className: "live" }, this.note, this.runs));
    // Who goes elsewhere stays there, until the newest picture is asked for again.
    const go = page.goToStill.bind(page), goRow = page.goToRow.bind(page);
    const watched = (action) => (...parameters) => {
      action(...parameters);
      if (!this.isBusy) this.box.checked = page.still === page.data.stills.length - 1 && !page.isPlaying;
    };
    [page.goToStill, page.goToRow] = [watched(go), watched(goRow)];
    page.isFollowing = true;
    this.tell(live.state);
    this.goToNewest();
    document.documentElement.dataset.following = "true";
    this.later(EVERY);
  }

  later(time) { setTimeout(() => this.ask(), time); }

  // Goes elsewhere without the reader having asked for it.
  quietly(action) {
    this.isBusy = true;
    action();
    this.isBusy = false;
  }

  goToNewest() {
    const { page } = this;
    if (page.isPlaying) page.play(false);
    this.quietly(() => page.goToStill(page.data.stills.length - 1));
  }

  async ask() {
    let answer = null;
    try {
      const question = new URLSearchParams({ since: this.change, simulation: this.live.simulation, reader: this.reader });
      const response = await fetch(`data?${question}`, { cache: "no-store", signal: AbortSignal.timeout(10000) });
      if (!response.ok) throw new Error(`it answers ${response.status}`);
      answer = await response.json();
    } catch (error) {
      this.failures += 1;
      if (this.failures >= PATIENCE) this.lose();
      this.later(this.failures >= PATIENCE ? SLOWLY : EVERY);
      return;
    }
    this.failures = 0;
    $("trouble").hidden = true;
    if (answer.anew) {
      location.reload();
      return;
    }
    await this.take(answer);
    this.tell(answer.state);
    if (!answer.state.over) this.later(EVERY);
  }

  // Nobody answers any more.
  lose() {
    $("outcome").textContent = "not running";
    $("outcome").className = "badge ill";
    const { folder } = this.live.state;
    this.note.textContent = "";
    $("trouble").textContent = `The run does not answer any more: it has ended, or was stopped. What it wrote is in ${folder}; report.html there is this page at its end. If it was cut off, conserva resume ${folder} goes on with it.`;
    $("trouble").hidden = false;
    document.documentElement.dataset.following = "lost";
  }

  // Puts an answer into the page.
  async take(answer) {
    const { page } = this, { data } = page;
    this.change = answer.change;
    if (answer.warnings) {
      data.warnings = answer.warnings;
      page.warn();
    }
    if (answer.problem) {
      Object.assign(data, answer.problem);
      page.explain();
    }
    const { rows, stills } = answer;
    const hasRows = rows && (rows.left || rows.numbers.length > 0);
    if (!hasRows && !stills) return;
    const values = hasRows ? new Float64Array((await unpack(rows.values)).buffer) : null;
    const bytes = stills ? await unpack(stills.bytes) : null;
    const time = page.time[page.row], wasNewest = this.box.checked && !page.isPlaying;
    if (hasRows) this.takeRows(rows, values);
    const first = stills ? this.takeStills(stills, bytes) : data.stills.length;
    // Stills name their row by its place among those that the page has.
    data.stills.forEach((still, k) => { still.row = this.placeOf(this.stillRows[k]); });
    page.time = page.columns.get("time");
    page.state();
    page.plot();
    page.ownPlot.renew();
    if (stills) page.nodes.renew();
    page.ledger.renew();
    this.quietly(() => {
      page.widen(Math.min(first, Math.max(data.stills.length - 1, 0)));
      if (wasNewest) page.goToStill(data.stills.length - 1);
      else page.goToRow(page.rowAt(time));
    });
  }

  takeRows({ left, numbers, rows, count }, values) {
    const { page, live } = this, { data } = page;
    const stays = left ? new Set(left) : null;
    const kept = live.rowNumbers.map((number, k) => (!stays || stays.has(number) ? k : -1)).filter((k) => k >= 0);
    data.columns.forEach((name, k) => {
      const column = page.columns.get(name), grown = new Float64Array(kept.length + numbers.length);
      if (stays) kept.forEach((from, to) => { grown[to] = column[from]; });
      else grown.set(column);
      grown.set(values.subarray(k * numbers.length, (k + 1) * numbers.length), kept.length);
      page.columns.set(name, grown);
    });
    live.rowNumbers = [...kept.map((k) => live.rowNumbers[k]), ...numbers];
    this.rowCounts = [...kept.map((k) => this.countOf(k)), ...rows];
    data.rows = live.rowNumbers.length;
    data.row_count = count;
  }

  // Number of a row of the page among all rows.
  countOf(place) { return this.rowCounts ? this.rowCounts[place] : this.live.rows[place]; }

  // Place of a row among those that the page has, or of the one before it.
  placeOf(row) {
    const counts = this.rowCounts ?? this.live.rows;
    let low = 0, high = counts.length - 1;
    while (low < high) {
      const middle = (low + high + 1) >> 1;
      if (counts[middle] <= row) low = middle;
      else high = middle - 1;
    }
    return low;
  }

  // The first still that is new.
  takeStills({ left, numbers, list, fields, pressing }, bytes) {
    const { page, live } = this, { data, film } = page;
    const stays = left ? new Set(left) : null;
    const kept = live.stillNumbers.map((number, k) => (!stays || stays.has(number) ? k : -1)).filter((k) => k >= 0);
    const of = (array) => kept.map((k) => array[k]);
    live.stillNumbers = [...of(live.stillNumbers), ...numbers];
    this.stillRows = [...of(this.stillRows), ...list.map(({ row }) => row)];
    film.places = of(film.places);
    film.at = -1;
    data.stills = [...of(data.stills), ...list];
    film.put(kept.length, list.length, bytes);
    data.fields.forEach((field, k) => Object.assign(field, fields[k]));
    data.pressing = pressing;
    return kept.length;
  }

  // What the run does, or how it ended.
  tell(state) {
    const { page, live } = this, outcome = $("outcome"), now = brief(page.time[page.time.length - 1], 6);
    live.state = state;
    const until = state.until === null ? "" : ` of ${brief(state.until, 6)}`;
    const does = state.doing ? `, ${state.doing}` : "";
    outcome.textContent = state.outcome ?? `running, t = ${now}${until}${does}`;
    outcome.className = `badge ${state.outcome === null ? "" : state.well ? "well" : "ill"}`;
    const note = state.over
      ? `The run has ended. The page that stays is report.html in ${state.folder}.`
      : "This page follows the run; what is new appears by itself.";
    if (this.note.textContent !== note) this.note.textContent = note;
    const others = [state.over, ...state.simulations].join("\n");
    if (others !== this.others) {
      this.others = others;
      this.runs.hidden = state.simulations.length < 2;
      const link = (name, k) => k === live.simulation
        ? element("b", { textContent: name, "aria-current": "page" })
        : state.over ? name : element("a", { href: `?simulation=${k}`, textContent: name });
      this.runs.replaceChildren("Simulations: ", ...state.simulations.flatMap((name, k) => [link(name, k), " "]));
    }
    if (state.over) {
      this.box.parentElement.hidden = true;
      document.documentElement.dataset.following = "over";
    }
  }
}

const follow = (page, live) => { window.conserva.follower = new Follower(page, live); };

