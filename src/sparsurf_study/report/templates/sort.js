for (const table of document.querySelectorAll("table.sortable")) {
  const body = table.tBodies[0], value = (row, column) => row.cells[column].dataset.key ?? row.cells[column].textContent;
  let sorted = -1, sign = 1;
  [...table.tHead.rows[0].cells].forEach((heading, column) => {
    const button = document.createElement("button");
    button.type = "button";
    button.append(...heading.childNodes);
    heading.append(button);
    button.addEventListener("click", () => {
      sign = sorted === column ? -sign : 1;
      sorted = column;
      for (const other of table.tHead.rows[0].cells) other.removeAttribute("aria-sort");
      heading.setAttribute("aria-sort", sign > 0 ? "descending" : "ascending");
      const rows = [...body.rows], numeric = rows.every(row => Number.isFinite(+value(row, column)));
      rows.sort((a, b) => {
        const [first, second] = [value(a, column), value(b, column)];
        return sign * (numeric ? second - first : first.localeCompare(second));
      });
      body.append(...rows);
    });
  });
  table.parentElement.previousElementSibling.querySelector("input").addEventListener("input", event => {
    const words = event.target.value.toLowerCase();
    for (const row of body.rows) row.hidden = ![...row.cells].some(cell => cell.textContent.toLowerCase().includes(words));
  });
}

// The contents of the page: its headings, without those of the cards.
for (const contents of document.querySelectorAll("#contents")) {
  const headings = [...document.querySelectorAll("h2")].filter((heading) => !heading.closest(".card") && heading.offsetParent);
  headings.forEach((heading, k) => {
    heading.id ||= `part-${k}`;
    contents.lastElementChild.append(Object.assign(document.createElement("a"), { href: `#${heading.id}`, textContent: heading.textContent }));
  });
  contents.hidden = headings.length < 2;
}
