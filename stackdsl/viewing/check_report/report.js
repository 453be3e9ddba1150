"use strict";
const all = (place, within = document) => [...within.querySelectorAll(place)];
for (const button of all("[data-copy]")) {
  button.hidden = !navigator.clipboard;
  button.addEventListener("click", () => navigator.clipboard.writeText(button.dataset.copy));
}
if (document.getElementById("cases")) {
  const [search, system, order, reset] = ["search", "system", "order", "reset"].map((id) => document.getElementById(id));
  const chips = all(".chips button");
  const groups = all(".group").map((element, rank) => ({
    element, rank, name: element.dataset.name, time: Number(element.dataset.time),
    rows: all(".row", element).map((row) => ({ row, text: `${row.dataset.words} ${row.textContent}`.toLowerCase() })),
  }));
  const cases = document.getElementById("cases");
  const none = document.querySelector(".none");
  const filter = () => {
    const wanted = new Set(chips.filter((chip) => chip.getAttribute("aria-pressed") === "true").map((chip) => chip.dataset.status));
    const words = search.value.toLowerCase().split(/\s+/);
    let left = 0;
    for (const { element, rows } of groups) {
      let shown = 0;
      for (const { row, text } of rows) {
        row.hidden = !(wanted.has(row.dataset.status) && words.every((word) => text.includes(word))
          && (!system?.value || row.dataset.systems.split(" ").includes(system.value)));
        shown += !row.hidden;
      }
      element.hidden = shown === 0;
      left += shown;
    }
    none.hidden = left > 0;
  };
  const sort = () => {
    const by = { rank: (a, b) => a.rank - b.rank, name: (a, b) => a.name.localeCompare(b.name), time: (a, b) => b.time - a.time };
    [...groups].sort(by[order.value]).forEach(({ element }) => cases.insertBefore(element, none));
  };
  for (const chip of chips) {
    chip.addEventListener("click", () => {
      chip.setAttribute("aria-pressed", String(chip.getAttribute("aria-pressed") !== "true"));
      filter();
    });
  }
  search.addEventListener("input", filter);
  system?.addEventListener("change", filter);
  order.addEventListener("change", sort);
  reset.addEventListener("click", () => {
    chips.forEach((chip) => chip.setAttribute("aria-pressed", "true"));
    search.value = "";
    if (system) system.value = "";
    filter();
  });
  document.querySelector(".tools").hidden = false;
  filter();
}
