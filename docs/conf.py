"""How Sphinx builds the site: `make docs`."""

from pathlib import Path

from docutils import nodes
from docutils.utils.math.latex2mathml import tex2mathml

import crosscheck
from tools.live import write_live_pages
from tools.site import write_pages

project = "geararm-crosscheck"
author = "The geararm-crosscheck developers"
release = version = crosscheck.__version__
extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.napoleon", "sphinxcontrib.bibtex"]
myst_enable_extensions = ["dollarmath", "amsmath"]
myst_heading_anchors = 3
myst_fence_as_directive = ["math"]  # as GitHub sets formulas
suppress_warnings = ["myst.header"]  # changelog and contributing begin with their own title
bibtex_bibfiles = ["references.bib"]
autodoc_typehints = "description"
exclude_patterns = ["ci", "generated/cards", "generated/files"]
html_extra_path = ["generated/files"]  # what cards and pages of the gallery link to
html_static_path = ["site.css"]
html_css_files = ["site.css"]
highlight_language = "none"  # a block says what it is
html_theme = "furo"
html_title = "geararm-crosscheck"
html_copy_source = False
html_show_copyright = False
html_math_renderer = "mathml"  # the browser's own: MathJax would come from a network

write_pages(Path(__file__).parent / "generated")
write_live_pages(Path(__file__).parent / "generated")


def mathml(text, as_block=False):
    """A formula; its accents clear of their letters in fonts that are not made for formulas."""
    return tex2mathml(text, as_block=as_block).replace(' accent="true"', "")


def inline_formula(writer, node):
    """Write a formula in a line."""
    writer.body.append(mathml(node.astext()))
    raise nodes.SkipNode


def formula(writer, node):
    """Write a formula that stands alone; it scrolls by itself where it is too wide."""
    shown = mathml(node.astext(), as_block=True)
    writer.body.append(f'<div style="overflow-x: auto" tabindex="0">{shown}</div>')
    raise nodes.SkipNode


def setup(app):
    """Register the renderer of formulas."""
    app.add_html_math_renderer("mathml", (inline_formula, None), (formula, None))
