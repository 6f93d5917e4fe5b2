"""The function that answers a part is found in its file."""

from crosscheck.testing import Equations
from crosscheck.trial.input.loading import load_equations
from crosscheck.trial.input.source_lines import find_source
from tests.tool.supplied import model_file


def test_a_part_is_found_in_its_file(tmp_path, labelled):
    file = model_file(tmp_path)
    equations = load_equations(f"{file}:two_link", labelled, None)
    source = find_source(equations, "mass_matrix")
    assert source is not None
    assert source.file == "mine.py"
    text = file.read_text().splitlines()
    assert [line.strip() for line in source.lines] == [
        line.strip() for line in text[source.first - 1 : source.first + 2]
    ]
    assert source.lines[0] == "def mass_matrix(q):"
    assert find_source(Equations(mass_matrix=abs), "mass_matrix") is None
    assert find_source(Equations(mass_matrix=abs), "force") is None
