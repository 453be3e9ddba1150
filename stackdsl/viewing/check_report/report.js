"use strict";
{
  const [search, only] = ["search", "only"].map((id) => document.getElementById(id));
  const rows = [...document.querySelectorAll("#cases tbody tr")];
  const texts = rows.map((row) => row.textContent.toLowerCase());
  const filter = () => rows.forEach((row, place) => {
    const meant = search.value.toLowerCase().split(/\s+/).every((word) => texts[place].includes(word));
    row.hidden = !meant || (only.checked && row.dataset.passed === "yes");
  });
  search.addEventListener("input", filter);
  only.addEventListener("change", filter);
  document.querySelector(".filter").hidden = false;
}
