(() => {
  const section = document.getElementById("findings");
  const controls = section.querySelector(".controls");
  const words = document.getElementById("words");
  const boxes = [...controls.querySelectorAll("[type=checkbox]")];
  const groups = [...section.querySelectorAll("details")].map((element) => ({
    element,
    isOpen: element.open,
    rows: [...element.querySelectorAll("tr")].slice(1).map((row) => ({
      row,
      verdict: row.lastElementChild.textContent,
      text: row.textContent.toLowerCase(),
    })),
  }));
  const total = groups.reduce((sum, group) => sum + group.rows.length, 0);
  const apply = () => {
    const asked = words.value.toLowerCase().split(/\s+/).filter(Boolean);
    const verdicts = new Set(boxes.filter((box) => box.checked).map((box) => box.value));
    const isFiltered = asked.length > 0 || verdicts.size < boxes.length;
    let shown = 0;
    for (const { element, isOpen, rows } of groups) {
      let here = 0;
      for (const { row, verdict, text } of rows) {
        row.hidden = !verdicts.has(verdict) || !asked.every((word) => text.includes(word));
        here += !row.hidden;
      }
      element.hidden = here === 0;
      element.open = isFiltered ? asked.length > 0 && shown < 200 && here > 0 : isOpen;
      shown += here;
    }
    document.getElementById("matches").value = `${shown} of ${total} shown`;
  };
  controls.hidden = false;
  controls.addEventListener("input", apply);
  apply();
})();
