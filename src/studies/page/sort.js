"use strict";
// A click on a column's name sorts the table by it, numbers by their values.
for (const table of document.querySelectorAll("table.sorted")) {
    const heads = [...table.tHead.rows[0].cells];
    heads.forEach((head, column) => head.firstElementChild.addEventListener("click", () => {
        const sign = head.getAttribute("aria-sort") === "ascending" ? -1 : 1;
        heads.forEach((other) => other.removeAttribute("aria-sort"));
        head.setAttribute("aria-sort", sign > 0 ? "ascending" : "descending");
        const key = (row) => row.cells[column].textContent;
        const compare = (a, b) => {
            const [x, y] = [key(a), key(b)];
            const [p, q] = [parseFloat(x), parseFloat(y)];
            const both = !Number.isNaN(p) && !Number.isNaN(q);
            return sign * (both ? p - q : x.localeCompare(y));
        };
        table.tBodies[0].append(...[...table.tBodies[0].rows].sort(compare));
    }));
}
