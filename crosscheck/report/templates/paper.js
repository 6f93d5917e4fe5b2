// Claims by verdict: a button shows those of one verdict, in sections that open for them.
(function () {
  var contents = document.querySelector(".contents");
  if (contents && window.innerWidth < 1150) { contents.open = false; }

  function unfold(inside) {
    for (var at = inside; at; at = at.parentElement) { if (at.tagName === "DETAILS") { at.open = true; } }
  }

  function show(filter, verdict) {
    document.querySelectorAll("." + filter.dataset.filter + "[data-verdict]").forEach(function (claim) {
      claim.hidden = verdict !== "" && claim.dataset.verdict !== verdict;
      if (verdict !== "" && !claim.hidden) { unfold(claim.parentElement); }
    });
    filter.querySelectorAll("button").forEach(function (button) {
      button.setAttribute("aria-pressed", String(button.dataset.show === verdict));
    });
  }

  document.querySelectorAll("[data-filter]").forEach(function (filter) {
    filter.querySelectorAll("button").forEach(function (button) {
      button.addEventListener("click", function () { show(filter, button.dataset.show); });
    });
    show(filter, "");
  });

  function arrive() {  // a link into what is folded or filtered away leads there all the same
    var target = document.getElementById(decodeURIComponent(location.hash.slice(1)));
    if (!target || !target.closest("main")) { return; }
    document.querySelectorAll("[data-filter]").forEach(function (filter) {
      if (target.hidden) { show(filter, ""); }
    });
    unfold(target);
    target.scrollIntoView();
  }
  window.addEventListener("hashchange", arrive);
  arrive();
})();
