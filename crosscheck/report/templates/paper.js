// Claims by verdict: a box for every verdict on the page; unticked ones are not shown.
(function () {
  var rows = Array.from(document.querySelectorAll("tr.claim[data-verdict]"));
  var contents = document.querySelector(".contents");
  if (contents && window.innerWidth < 1150) { contents.open = false; }
  function show(target) {  // a link into folded claims opens them
    for (var at = target; at; at = at.parentElement) { if (at.tagName === "DETAILS") { at.open = true; } }
  }
  function arrive() {
    var target = location.hash && document.getElementById(decodeURIComponent(location.hash.slice(1)));
    if (target && target.closest("main")) { target.hidden = false; show(target); target.scrollIntoView(); }
  }
  window.addEventListener("hashchange", arrive);
  if (!rows.length) { arrive(); return; }
  var counts = new Map();
  rows.forEach(function (row) { counts.set(row.dataset.verdict, (counts.get(row.dataset.verdict) || 0) + 1); });
  var bar = document.createElement("p");
  bar.className = "filter";
  bar.append("Show: ");
  function apply() {
    var on = new Set(Array.from(bar.querySelectorAll("input:checked")).map(function (box) { return box.value; }));
    rows.forEach(function (row) { row.hidden = !on.has(row.dataset.verdict); });
    if (on.size < counts.size) { rows.forEach(function (row) { if (!row.hidden) { show(row.parentElement); } }); }
  }
  counts.forEach(function (count, verdict) {
    var label = document.createElement("label"), box = document.createElement("input");
    box.type = "checkbox"; box.checked = true; box.value = verdict; box.onchange = apply;
    label.append(box, " " + verdict + " (" + count + ")");
    bar.append(label);
  });
  var claims = document.getElementById("claims");
  (claims ? claims.parentElement : document.querySelector("main")).insertBefore(bar, claims ? claims.nextSibling : null);
  arrive();
})();
