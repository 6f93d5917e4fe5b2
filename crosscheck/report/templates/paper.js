// On a narrow screen the contents are folded at first.
(function () {
  var contents = document.querySelector(".contents");
  if (contents && window.innerWidth < 1150) { contents.open = false; }
})();
