// Curves of the field shown over time at nodes that the reader chooses, from the stills on the page.

// Largest number of curves, as many as there are colors.
const CURVES = 6;

const nodeName = (body, node) => `${body.name}, node ${body.numbers ? body.numbers[node] : node}`;

class NodeCurves {
  // `go`: goes to a time.
  constructor(page, go) {
    Object.assign(this, { page, go, chosen: [], plot: null });
    const { bodies } = page;
    this.body = element("select", { id: "node-body" }, ...bodies.map(({ name }, k) => element("option", { value: String(k), textContent: name })));
    this.number = element("input", { id: "node-number", size: 7, inputMode: "numeric" });
    this.note = element("span", { className: "quiet", role: "status" });
    const form = element("form", { className: "pair" },
      element("label", {}, "Node ", this.number), element("label", { hidden: bodies.length < 2 }, " of ", this.body), element("button", { textContent: "Curve of the node" }), this.note);
    form.addEventListener("submit", (event) => {
      event.preventDefault();
      this.addNumber(Number(this.body.value), this.number.value);
    });
    this.list = element("div", { className: "pair" });
    this.box = element("div", {});
    $("nodes").append(form, this.list, this.box);
  }

  addNumber(body, text) {
    const { nodes, numbers, name } = this.page.bodies[body], number = text.trim() === "" ? NaN : Number(text);
    const node = numbers ? numbers.indexOf(number) : number;
    if (!(Number.isInteger(node) && node >= 0 && node < nodes)) {
      const last = numbers ? numbers[nodes - 1] : nodes - 1;
      this.note.textContent = numbers && number >= 0 && number <= last ? `Node ${text} of ${name} is not on its surface.` : `${name} has nodes 0 to ${last}.`;
      return;
    }
    this.add(body, node);
  }

  add(body, node) {
    this.note.textContent = "";
    if (this.chosen.some((other) => other.body === body && other.node === node)) return;
    if (this.chosen.length === CURVES) this.chosen.shift();
    this.chosen.push({ body, node });
    [this.body.value, this.number.value] = [String(body), String(this.page.bodies[body].numbers?.[node] ?? node)];
    this.renew();
  }

  remove(index) {
    this.chosen.splice(index, 1);
    this.renew();
    (this.list.querySelectorAll("button")[Math.min(index, this.chosen.length - 1)] ?? this.number).focus();
  }

  // Reads the curves again: another field is shown, or there are other nodes or stills.
  renew() {
    const { page } = this, { film, bodies, data } = page, field = page.fieldNow();
    this.list.replaceChildren(...this.chosen.map(({ body, node }, k) =>
      element("button", { type: "button", textContent: `× ${nodeName(bodies[body], node)}`, "aria-label": `Remove the curve of ${nodeName(bodies[body], node)}`, onclick: () => this.remove(k) })));
    page.redraw();
    this.box.replaceChildren();
    this.plot = null;
    if (!this.chosen.length) return;
    const curves = this.chosen.map(({ body, node }) => ({ label: nodeName(bodies[body], node), values: data.stills.map((_, still) => film.valueAt(field.name, still, body, node)) }));
    const title = `${titled(field, data)} at nodes`;
    const isTimed = page.isTimed(), places = data.stills.map(({ time }, k) => (isTimed ? time : k));
    this.plot = new Plot({ title, curves, isStepped: field.kinds.length > 0, over: isTimed ? "time" : "the stills" }, places, this.go);
    this.box.append(this.plot.figure);
    this.show();
  }

  show() { this.plot?.show(this.page.still); }

  // Rings around the nodes in the picture.
  draw(look) {
    const { scene } = this.page, { context, fineness } = scene;
    this.chosen.forEach(({ body, node }, k) => {
      const p = scene.places[body], x = p[3 * node], y = p[3 * node + 1];
      for (const [color, width] of [[look.theme.halo, 4.5], [getComputedStyle(document.documentElement).getPropertyValue(`--c${k}`), 2.2]]) {
        context.strokeStyle = color;
        context.lineWidth = width * fineness;
        context.beginPath();
        context.arc(x, y, 6 * fineness, 0, 2 * Math.PI);
        context.stroke();
      }
    });
  }
}
