"""Yours and right of a term: what differs is marked, and the right line is the term itself."""

import pytest

from crosscheck.report.trials.typesetting import RIGHT, WRONG, render_pairs, render_pieces
from crosscheck.testing import Equations
from crosscheck.trial.changes.arms.typeset_errors import Piece, typeset_error
from crosscheck.trial.input.loading import load_equations
from crosscheck.trial.input.source_lines import find_source
from crosscheck.trial.judge.entries import Term, TermError
from tests.tool.supplied import model_file

LATEX = r"2\,m_{payload}\,L_{1}\,L_{2}\,\cos(\theta_{2})"
TERM = Term("2 m_payload L1 L2", "cos", "theta_2", latex=LATEX)
SQUARE = Term("m_2 d2^2", latex=r"m_{2}\,d_{2}^{2}")


def show(pieces: tuple[Piece, ...]) -> str:
    """The line with what is marked in brackets."""
    return "".join(f"[{each.latex}]" if each.is_marked else each.latex for each in pieces)


@pytest.mark.parametrize(
    ("error", "yours", "right"),
    [
        (TermError("dropped", TERM), "[0]", f"[{LATEX}]"),
        (TermError("extra", TERM), f"[{LATEX}]", "[0]"),
        (TermError("sign", TERM), f"[-]{LATEX}", f"[+]{LATEX}"),
        (TermError("sign", Term("-L1", latex="-L_{1}")), "[+]L_{1}", "[-]L_{1}"),
        (TermError("sign", Term("", latex="a + b")), "[-](a + b)", "[+](a + b)"),
        (TermError("factor", TERM, by=0.5), rf"[\frac{{1}}{{2}}]\,({LATEX})", LATEX),
        (TermError("factor", TERM, by=-2.0), rf"[-2]\,({LATEX})", LATEX),
        (TermError("factor", TERM, "1/sqrt(N1)"), rf"[1/\sqrt{{N_{{1}}}}]\,({LATEX})", LATEX),
        (
            TermError("swapped", TERM, "d2", "L2"),
            LATEX.replace("L_{2}", "[d_{2}]"),
            LATEX.replace("L_{2}", "[L_{2}]"),
        ),
        (
            TermError("swapped", SQUARE, "L2", "d2"),
            r"m_{2}\,[L_{2}]^{2}",
            r"m_{2}\,[d_{2}]^{2}",
        ),
        (
            TermError("swapped", SQUARE, "L2 d2", "d2^2"),
            r"m_{2}\,[(L_{2}\,d_{2})]",
            r"m_{2}\,[d_{2}^{2}]",
        ),
        (
            TermError("angle", TERM, "cos(theta_1 + theta_2)", "cos(theta_2)"),
            LATEX.replace(r"\cos(\theta_{2})", r"[\cos(\theta_{1} + \theta_{2})]"),
            LATEX.replace(r"\cos(\theta_{2})", r"[\cos(\theta_{2})]"),
        ),
        (TermError("swapped", SQUARE, "T_1", ""), r"m_{2}\,d_{2}^{2}[\,T_{1}]", SQUARE.latex),
    ],
    ids=lambda case: case.kind if isinstance(case, TermError) else "",
)
def test_what_differs_is_marked(error, yours, right):
    typeset = typeset_error(error)
    assert typeset is not None
    assert (show(typeset.yours), show(typeset.right)) == (yours, right)
    for pieces in typeset:
        marked = sum(piece.is_marked for piece in pieces)
        assert render_pieces(pieces, "#b3261e").count("#b3261e") == marked
    (pair,) = render_pairs([error])
    coloured = [text.count(colour) for text, colour in zip(pair, (WRONG, RIGHT), strict=True)]
    assert coloured == [sum(piece.is_marked for piece in pieces) for pieces in typeset]


def test_what_is_not_in_the_term_is_not_typeset():
    assert typeset_error(TermError("swapped", TERM, "d3", "L3")) is None
    assert typeset_error(TermError("sign", Term("L1"))) is None


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
