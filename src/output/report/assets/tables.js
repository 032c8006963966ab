// Tables: what the problem consists of, and the ledger, of which only the rows in sight are made.

const tableOf = ({ head, rows }) => {
  const table = element("table", {});
  if (head.length) table.append(element("thead", {}, element("tr", {}, ...head.map((name) => element("th", { textContent: name, scope: "col" })))));
  const line = (cells) => element("tr", {}, ...cells.map((text, k) => element(k === 0 ? "th" : "td", k === 0 ? { textContent: text, scope: "row" } : { textContent: text })));
  table.append(element("tbody", {}, ...rows.map(line)));
  return element("div", { className: "wide" }, table);
};

const ROW = 22;

class Ledger {
  constructor(box, data, columns, go) {
    Object.assign(this, { box, data, columns, go, now: -1, first: -1, last: -1 });
    const names = data.columns.map((name) => element("th", { textContent: `${name}${unitOf(data, "columns", name)}`, scope: "col" }));
    this.names = names;
    this.body = element("tbody", {});
    this.table = element("table", {}, element("thead", {}, element("tr", { "aria-rowindex": "1" }, ...names)), this.body);
    box.append(this.table);
    box.addEventListener("scroll", () => this.fill());
    this.body.addEventListener("click", (event) => {
      const row = event.target.closest("tr[data-row]");
      if (row) go(Number(row.getAttribute("data-row")));
    });
    this.renew();
  }

  // After the history has changed.
  renew() {
    const { data, columns } = this;
    // Columns keep the width that their longest number needs.
    this.names.forEach((cell, k) => {
      const values = columns.get(data.columns[k]);
      let longest = cell.textContent.length;
      for (let i = 0; i < values.length; i += Math.max(Math.floor(values.length / 200), 1)) longest = Math.max(longest, exact(values[i]).length);
      cell.style.minWidth = `${longest + 3}ch`;
    });
    this.table.setAttribute("aria-rowcount", String(data.rows + 1));
    this.first = -1;
    this.fill();
  }

  fill() {
    const { box, data, columns } = this;
    const first = clamp(Math.floor(box.scrollTop / ROW) - 8, 0, Math.max(data.rows - 1, 0));
    const last = Math.min(first + Math.ceil(box.clientHeight / ROW) + 16, data.rows);
    if (first === this.first && last === this.last) return;
    [this.first, this.last] = [first, last];
    const all = data.columns.map((name) => columns.get(name));
    const gap = (rows) => element("tr", { "aria-hidden": "true" }, element("td", { className: "gap", colspan: String(all.length) }));
    const lines = [];
    for (let row = first; row < last; row += 1) {
      lines.push(element("tr", { "data-row": String(row), "aria-rowindex": String(row + 2), className: row === this.now ? "now" : "" },
        ...all.map((values) => element("td", { textContent: exact(values[row]) }))));
    }
    const above = gap(), below = gap();
    above.firstChild.style.height = `${first * ROW}px`;
    below.firstChild.style.height = `${(data.rows - last) * ROW}px`;
    this.body.replaceChildren(above, ...lines, below);
  }

  // Marks a row and brings it into sight.
  show(row) {
    if (row === this.now) return;
    this.body.querySelector("tr.now")?.classList.remove("now");
    this.now = row;
    const top = row * ROW, { scrollTop, clientHeight } = this.box;
    if (top < scrollTop || top > scrollTop + clientHeight - 3 * ROW) this.box.scrollTop = Math.max(top - clientHeight / 2, 0);
    this.fill();
    this.body.querySelector(`tr[data-row="${row}"]`)?.classList.add("now");
  }
}
