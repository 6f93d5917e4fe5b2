"""The gallery of the docs: its list, and its cells. `make docs` runs every entry."""

import pytest

from tools.gallery import read_entries, run_entry
from tools.notebook import Cell, format_notebook, format_page, read_cells, run_cells

SCRIPT = """# %% [markdown]
# # Title
#
# Text.

# %%
print(1 + 1)
"two"
"""


def test_every_entry_has_its_file_and_its_slip_once():
    entries = read_entries()
    assert 9 <= len(entries) <= 15
    assert len({entry.name for entry in entries}) == len(entries)
    for entry in entries:
        source = entry.file.read_text(encoding="utf-8")
        assert source.count(entry.right) == 1 if entry.arm else read_cells(source)


def test_cells_are_read_run_and_written():
    cells = run_cells(read_cells(SCRIPT))
    assert cells == [
        Cell("# Title\n\nText."),
        Cell('print(1 + 1)\n"two"', True, outputs=(("text/plain", "2\n"), ("text/plain", "'two'"))),
    ]
    assert "```text\n2\n```" in format_page(cells)
    assert [cell["cell_type"] for cell in format_notebook(cells)["cells"]] == ["markdown", "code"]


def test_a_robots_card_names_the_mistake_that_its_trial_finds():
    (entry,) = (each for each in read_entries() if each.name == "zero_of_the_elbow")
    example = run_entry(entry)
    assert "90 degrees" in example.finding
    assert "<svg" in example.picture


def test_a_cell_that_raises_stops_the_build():
    with pytest.raises(ZeroDivisionError):
        run_cells([Cell("1 / 0", True)])


def test_a_slip_that_is_none_stops_the_build():
    (entry,) = (each for each in read_entries() if each.name == "coriolis_matrix")
    harmless = "-s * (v[1] + v[0])"
    with pytest.raises(ValueError, match="its mistake is not seen"):
        run_entry(type(entry)(entry.file, entry.arm, entry.mistake, entry.right, harmless))
