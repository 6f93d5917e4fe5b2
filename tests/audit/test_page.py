"""The page and its command; what is published of a full run says one thing: nothing is run."""

import json
import re
from collections import Counter
from html import unescape
from pathlib import Path

import numpy as np
import pytest

from crosscheck.audit.claims.catalogue import CLAIMS
from crosscheck.audit.errata.errata_texts import load_notes
from crosscheck.audit.errata.finder import find_errata
from crosscheck.audit.experiments.study import Study
from crosscheck.audit.page import report
from crosscheck.audit.page.chapter import AUTHORS, TITLE, AuditChapter
from crosscheck.audit.page.report import (
    format_records,
    record_study,
    render_page,
    run_paper_command,
)
from crosscheck.models.errors import InputError
from crosscheck.provenance import ROOT
from tests.loops import require_items
from tests.views.shown_numbers import QUANTITY, Token


@pytest.fixture
def cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    return tmp_path


@pytest.mark.parametrize("number", [3, 21, -1])
def test_unknown_figures_are_refused_before_anything_is_written(number, cache):
    with pytest.raises(InputError, match="must be 4 to 20"):
        run_paper_command([4, number], cache / "out", 1)
    assert not (cache / "out").exists()


def test_a_seed_that_cannot_be_one_is_refused_before_anything_is_written(crosscheck, cache):
    answer = crosscheck("paper", "--first-seed", "-1", "--out", cache / "out")
    assert (answer.code, answer.err.count("\n")) == (2, 1)
    assert "must be 0 or more" in answer.err
    assert not (cache / "out").exists()


@pytest.mark.slow
def test_figures_alone_are_of_the_starts_that_are_asked_for(cache, monkeypatch):
    scales = []

    def keep(study, figures, out, scale):
        scales.append(scale)
        return []

    monkeypatch.setattr(report, "write_figures", keep)
    run_paper_command([4], cache / "out", 1, 5)
    assert [scale.first_seed for scale in scales] == [5]


def test_one_figure_alone_makes_a_self_contained_page(cache):
    """Its script and its style are in it; nothing is asked of any other place."""
    run_paper_command([4], cache / "out", 1, 5)
    html = (cache / "out" / "paper.html").read_text(encoding="utf-8")
    assert 'id="figure-4"' in html
    assert "<svg" in html
    assert re.search(r"\bsrc=|<link\b|@import|url\(http|\bfetch\(", html) is None


def test_the_contents_name_every_chapter_in_order(tmp_path):
    made = [AuditChapter(name, name.upper(), f"<p>{name}</p>", outcome="So.") for name in "abc"]
    html = render_page(made, record_study(Study(tmp_path)))
    contents, _, rest = html.partition("</nav>")
    assert re.findall(r'href="#(\w+)"', contents) == ["a", "b", "c", "provenance"]
    assert re.findall(r'<h2 id="(\w+)"', rest) == ["a", "b", "c", "provenance"]
    assert rest.count('<p class="outcome">So.</p>') == 3


def test_page_and_records_name_the_paper_and_what_was_read_of_it(tmp_path):
    """In their first lines, the sheet's too, and nothing that is not known of it is made up."""
    html = render_page([], record_study(Study(tmp_path))).partition("<main>")[2]
    first_lines = unescape(html).strip()[:1200]
    assert json.loads(format_records([], Study(tmp_path)))["paper"]["citation"] in first_lines
    for known in (AUTHORS, TITLE, "Robotica", "volume, pages, DOI: not known"):
        assert known in first_lines
    assert "figures were not seen" in first_lines


def test_records_are_identical_but_for_the_provenance(tmp_path):
    made = [AuditChapter("x", "X", "<p>x</p>", [{"id": "x/1", "value": np.float64(1.5)}])]
    first, second = (json.loads(format_records(made, Study(tmp_path))) for _ in range(2))
    assert first["chapters"] == second["chapters"] == {"x": [{"id": "x/1", "value": 1.5}]}
    assert "X" in render_page(made, record_study(Study(tmp_path)))


FOLDER = ROOT / "docs" / "case-study"
ARGUMENT, RESULTS = (
    (FOLDER / f"{name}.md").read_text(encoding="utf-8") for name in ("argument", "results")
)
QUOTED = re.compile(r"^`(verdict/[\w-]+)`: \*\*(.+?)\*\*", flags=re.M)
ROWS = [  # of each claim: its verdicts as modelled and as the gears are, said once where equal
    (name, *(said.split("; ") * 2)[:2])
    for name, said in re.findall(r"^- ([\w.]+-\d\d): .* \*\*(.*)\*\*$", RESULTS, flags=re.M)
]
FINDINGS = dict(re.findall(r"^### (\d)\. .*\n\n.*?<b>(.*)$", RESULTS, flags=re.M))
COMPUTED = re.compile(r"^\| `(verdict/[\w-]+)` \| .* \| (.+?) \|$", flags=re.M)


def test_every_verdict_is_quoted_once_and_has_not_turned():
    computed = COMPUTED.findall(RESULTS)
    assert sorted(QUOTED.findall(ARGUMENT)) == sorted(computed)
    assert len(computed) > 10


def name_verdict(said: str) -> str:
    """The verdict of a row by the name that the counts have."""
    word = re.sub(r" [\d/]+$", "", said)
    within = " where defined" if said.startswith("holds") and said.count("/") == 3 else ""
    return {"fails": "does not hold"}.get(word, word + within)


def test_the_counts_of_the_results_are_those_of_their_rows():
    """Each was written by one run, or edited since: a claim that is retired takes its row along."""
    assert sorted(row[0] for row in ROWS) == sorted(claim.id for claim in CLAIMS)
    counts = re.findall(r"^\| ([a-z ]+) \| (\d+) \| (\d+) \|$", RESULTS, flags=re.M)
    for column in (1, 2):
        tally = {row[0]: int(row[column]) for row in counts if row[column] != "0"}
        assert tally == Counter(name_verdict(row[column]) for row in ROWS)
    close = re.search(r"^(\d+) of (\d+) verdicts that runs decide [^:]*: (.*)\.$", RESULTS, re.M)
    assert int(close[1]) == len(close[3].split(", "))
    assert int(close[2]) == sum(not claim.static for claim in CLAIMS)


# A finding's answer, and what claims say of the same thing: as modelled, and as the gears are.
SAID_TWICE = [
    ("1", "No", "2.4-02", "fails", "fails"),  # M follows from the energies
    ("2", "Yes", "2.3-02", "fails", "fails"),  # omega_e t is the phase
    ("3", "No", "Abstract-02", "depends", "fails"),  # the tooth error's severe fluctuation
    ("3", "No", "5-04", "depends", "fails"),
    ("4", "No baseline", "3.1-01", "fails", "fails"),  # 0.02 rad
    ("4", "No baseline", "3.1-04", "fails", "fails"),  # 30 mm
    ("5", "With the printed drive alone", "4.1-05", "depends", "depends"),  # it accumulates
    ("5", "With the printed drive alone", "4.1-07", "fails", "fails"),  # by itself
]


@pytest.mark.parametrize("said", SAID_TWICE, ids=lambda said: f"{said[0]}, {said[2]}")
def test_a_finding_and_a_claim_on_one_thing_turn_together(said):
    number, answer, claim, *verdicts = said
    (row,) = (row for row in ROWS if row[0] == claim)
    assert FINDINGS[number].startswith(f"{answer}")
    assert [verdict.partition(" ")[0] for verdict in row[1:]] == verdicts


def test_no_claim_holds_that_the_sheet_denies(labelled):
    """Neither of what the program finds nor of what is found by reading."""
    verdicts = {row[0]: row[1:] for row in ROWS}
    sheet = [*find_errata(labelled), *load_notes().entries]
    for entry in require_items(entry for entry in sheet if entry.denies):
        for claim in entry.denies:
            assert not [said for said in verdicts[claim] if said.startswith("holds")], entry.id
    places = re.findall(r"^\| (Eqs?\. .*?) \| ", RESULTS, flags=re.M)
    assert sorted(places) == sorted(e.where for e in sheet if e.kind == "equation")


COST, ROBOTS = "docs/how-to/cost-of-shortcuts.md", "docs/case-study/robots.md"
README, PAPER, MADE = "README.md", "docs/case-study/paper.md", "docs/case-study/results.md"
DECISIONS, CHECKED = "docs/project/decisions.md", "docs/explanation/verification.md"
# Quantities that stand in several places: what is around the number in each.
SAID_OFTEN = {
    "M": {README: "no: M off by {}", PAPER: "by up to {}", MADE: "mass matrix is off by {}"},
    "acceleration": {README: "accelerations by up to {}", MADE: "acceleration by up to {}"},
    "mesh force": {README: "mesh force by up to {}", MADE: "rad and {} in 3 s"},
    "starts": {PAPER: "from up to {} starts", MADE: "of {} starts", CHECKED: "from {} perturbed"},
    "verdicts by runs": {DECISIONS: "Of {} statements", MADE: r"\d+ of {} verdicts"},
    "error of links": {
        COST: "flange_roll are wrong by up to {}",
        ROBOTS: r"`links`: torque error.* N m, {}, `flange",
    },
    "error of armature": {
        COST: "flange_roll is wrong by up to {}",
        ROBOTS: r"`armature`: torque error.* N m, {}, `flange",
    },
    "tip by links": {
        COST: "their largest values, and after 1 s of feed-forward the end effector is {} off",
        ROBOTS: r"torques of `links`.*\| {}, 0",
    },
    "tip by armature": {
        COST: "its largest value, and after 1 s of feed-forward the end effector is {} off",
        ROBOTS: r"torques of `armature`.*\| {}, 9",
    },
}


@pytest.mark.parametrize("quantity", SAID_OFTEN)
def test_a_quantity_has_one_value_on_all_pages(quantity):
    """Rounded to the digits of each place."""
    numbers = []
    for page, around in SAID_OFTEN[quantity].items():
        text = (ROOT / page).read_text(encoding="utf-8")
        found = re.search(around.replace("{}", QUANTITY), text)
        assert found, (page, around)
        numbers.append(Token.of(found))
    most = max(numbers, key=lambda each: len(each.text.strip("0.")))
    assert [each for each in numbers if not each.shows(most.value)] == []


def test_the_readme_has_the_number_of_errata():
    assert "| nine, each" in (ROOT / "README.md").read_text(encoding="utf-8")
    assert len(re.findall(r"^\| Eqs?\. ", RESULTS, flags=re.M)) == 9
