// Tables: what the problem consists of, and the ledger, of which only the rows in sight are made.

// A box that the keyboard reaches where it is scrolled.
const reachable = (box) => {
  new ResizeObserver(() => {
    if (box.scrollWidth > box.clientWidth || box.scrollHeight > box.clientHeight) box.tabIndex = 0;
    else box.removeAttribute("tabindex");
  }).observe(box);
  return box;
};

const tableOf = ({ head, rows, title: name = "Table" }) => {
  const table = element("table", {});
  if (head.length) table.append(element("thead", {}, element("tr", {}, ...head.map((name) => element("th", { textContent: name, scope: "col" })))));
  const line = (cells) => element("tr", {}, ...cells.map((text, k) => element(k === 0 ? "th" : "td", k === 0 ? { textContent: text, scope: "row" } : { textContent: text })));
  table.append(element("tbody", {}, ...rows.map(line)));
  return reachable(element("div", { className: "wide", role: "group", "aria-label": name }, table));
};

// The lines that the script printed.
const showPrinted = ({ printed }) => {
  $("printed").hidden = !printed.length;
  $("printed-lines").textContent = printed.join("\n");
};

const TYPES = { svg: "image/svg+xml", png: "image/png", gif: "image/gif" };

// A picture of the script; one that is not in the page is named.
const pictureOf = (picture, number, prefix = "") => {
  const caption = element("figcaption", { textContent: picture.path });
  if (!picture.shown) return element("figure", {}, caption, element("p", { className: "quiet", textContent: "This file is too large for the page, or was not kept." }));
  const image = element("img", { alt: picture.path, className: "drawn" });
  const id = `${prefix}picture-${number}`;
  picture.bytes ??= inflate(id);
  picture.bytes.then((bytes) => {
    let text = "";
    for (let at = 0; at < bytes.length; at += 32768) text += String.fromCharCode(...bytes.subarray(at, at + 32768));
    image.src = `data:${TYPES[picture.kind] ?? "image/png"};base64,${btoa(text)}`;
  });
  return element("figure", {}, caption, image);
};

const showPictures = ({ pictures }) => {
  $("pictures").hidden = !pictures.length;
  $("picture-list").replaceChildren(...pictures.map((picture, number) => pictureOf(picture, number)));
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
