"""How long a report takes to open and to redraw: `python -m benchmarks.pages report/index.html`."""

from __future__ import annotations

import shutil
import sys
from pathlib import Path

from playwright.sync_api import sync_playwright

ZOOMS = ((0.1, 0.2), (0.349, 0.350), (0.0, 1.0), (-1.0, 10.0))  # [s]
# Until the frame after the redraw is on the screen.
REDRAW = """([from, to]) => new Promise(done => {
  const begin = performance.now();
  document.getElementById("signals").zoom(from, to);
  requestAnimationFrame(() => requestAnimationFrame(() => done(performance.now() - begin)));
})"""
OPENED = "performance.timing.domContentLoadedEventEnd - performance.timing.navigationStart"


def measure_page(file: Path) -> None:
    """Print both [ms], in headless Chromium."""
    with sync_playwright() as playwright:
        path = shutil.which("chromium")
        browser = playwright.chromium.launch(executable_path=path, args=["--no-sandbox"])
        page = browser.new_page(viewport={"width": 1280, "height": 900})
        page.goto(file.resolve().as_uri())
        print(f"interactive after {page.evaluate(OPENED):.0f} ms")
        for zoom in ZOOMS:
            print(f"zoom to {zoom[0]:g} .. {zoom[1]:g} s: {page.evaluate(REDRAW, zoom):.0f} ms")
        browser.close()


if __name__ == "__main__":
    measure_page(Path(sys.argv[1]))
