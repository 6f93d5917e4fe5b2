"""Everything that is published, made for real from runs of a few milliseconds.

Nothing that the paper speaks of happens in them: what is left is to say so, everywhere.
"""

import re
from collections import Counter
from html import unescape
from pathlib import Path

import pytest
import yaml
from syrupy.assertion import SnapshotAssertion

from crosscheck.audit.claims import study_plan
from crosscheck.audit.claims.catalogue import CLAIMS
from crosscheck.audit.experiments.study import Study
from crosscheck.audit.figures.chapter import NUMBERS
from crosscheck.audit.figures.run_figures import RIGID_STYLES
from crosscheck.audit.findings.linear_limits import LINK
from crosscheck.audit.measures.undefined import UNDEFINED
from crosscheck.audit.page import report
from crosscheck.models.errors import InputError
from tests.audit.markup import SVG, axis_problems, page_problems
from tests.audit.published import BRIEF, FEW, Published, list_unrecorded
from tests.brief import perform_here
from tests.loops import require_items
from tools import case_study, write_article

pytestmark = pytest.mark.slow
TEX = ("printed_tex", "derived_tex")
AS_MODELLED = "omega_t/eq13/lumped/printed"  # clock, ring rate, planets, and the paper's equations


@pytest.fixture(scope="module")
def published(tmp_path_factory: pytest.TempPathFactory, kept: Path) -> Published:
    """The whole page; every test that looks at it is in this module, so that it is made once."""
    study, out = Study(kept), tmp_path_factory.mktemp("published")
    with pytest.MonkeyPatch.context() as patch:
        perform_here(patch)
        patch.setattr(study_plan, "FULL", FEW)
        made = report.write_paper(study, out, BRIEF)
    return Published(study, out, {chapter.id: chapter for chapter in made})


def test_every_chapter_says_something(published):
    assert len(published.chapters) == len(report.CHAPTERS)
    for chapter in published.chapters.values():
        assert chapter.title
        assert chapter.outcome.endswith(".")
        ids = [record["id"] for record in chapter.records]
        assert len(set(ids)) == len(ids) > 0


def test_the_page_is_well_formed(published):
    assert page_problems(published.html) == []


def test_every_axis_says_what_it_shows_in_which_unit(published):
    assert len(SVG.findall(published.html)) > len(NUMBERS)
    assert axis_problems(published.html) == []


def test_every_drawing_has_its_words(published, snapshot: SnapshotAssertion):
    """Titles, axes and legends of every drawing, in the order in which they are drawn."""
    texts = [re.findall(r"<!-- (.*?) -->", drawing) for drawing in SVG.findall(published.html)]
    words = [[text for text in each if re.search("[A-Za-z]{2}", text)] for each in texts]
    lines = [
        " | ".join(dict.fromkeys(text for text in each if "math" not in text)) for each in words
    ]
    assert "\n".join(filter(None, lines)) == snapshot


@pytest.mark.parametrize("number", NUMBERS)
def test_every_figure_has_its_parameters_below(published, number):
    head = f'<h3 id="figure-{number}">'
    _, _, after = published.chapters["figures"].html.partition(head)
    caption = after.split("<figcaption>")[1].split("</figcaption>")[0]
    assert any(unit in caption for unit in ("µm", "N/m"))


def test_figure_14_draws_every_rigid_arm(published):
    head, _, figure = published.chapters["figures"].html.partition('<h3 id="figure-14">')
    drawn = set(re.findall(r"<!-- rigid, (\w+) -->", figure.partition("<h3")[0]))
    assert drawn == set(RIGID_STYLES)
    assert "<!-- rigid, coupled -->" not in head


def test_a_limit_is_said_from_the_least_to_the_largest_of_its_records(published):
    limits = [
        record["unstable_below_zeta"]
        for name, record in published.records("findings").items()
        if name.startswith("finding/limit/") and name.endswith(f"/{LINK}")
    ]
    html = published.chapters["findings"].html
    (said,) = re.findall(r"Not below ζ = ([\d.]+) to ([\d.]+)", html)
    assert said == (f"{min(limits):.4f}", f"{max(limits):.4f}")


def test_the_records_are_strict_json_and_those_of_the_chapters(published):
    chapters = published.json["chapters"]
    assert list(chapters) == list(published.chapters)
    assert [r["id"] for r in chapters["figures"]] == [f"figure-{number}" for number in NUMBERS]
    assert len(chapters["claims"]) == len(CLAIMS)
    named = {name for sentence in published.json["sentences"] for name in sentence["claims"]}
    assert named == {claim["id"] for claim in chapters["claims"]}
    simulated = [claim for claim in chapters["claims"] if not claim["static"]]
    settings = [setting["id"] for claim in simulated for setting in claim["settings"]]
    gears = {"omega_t/eq13/free", "omega_t/corrected/free", "angle/corrected/free"}
    assert {each.partition("/paper-")[0] for each in settings} == {*gears, AS_MODELLED}
    assert all(gears - {"angle/corrected/free"} <= set(claim["models"]) for claim in simulated)
    variants = {name for claim in simulated for name in claim["variants"]}
    laws = ("omega_t/eq13", "omega_t/corrected", "angle/corrected")
    assert variants == {*(f"{law}/lumped" for law in laws), "angle/corrected/conservative/free"}


def test_every_quantity_of_a_chapter_is_in_its_records(published):
    """Findings also have effects of errata."""
    beside = {"findings": published.chapters["errata"].records}
    for name, chapter in require_items(published.chapters.items()):
        records = [*chapter.records, *beside.get(name, ())]
        assert list(list_unrecorded(chapter.html, records)) == []


def test_the_page_is_short(published):
    """What a reader of the page has before them: words outside of drawings."""
    assert {path.name for path in published.out.iterdir()} == set(report.FILES)
    body = SVG.sub("", published.html.partition("<main>")[2].partition("<script>")[0])
    assert len(re.sub(r"<[^>]*>", " ", body).split()) <= 12_000
    assert len(published.html.encode()) <= 3_000_000


def test_the_docs_page_has_every_finding_erratum_and_claim(published):
    page = case_study.build_page(published.out)
    claims = published.json["chapters"]["claims"]
    rows = re.findall(r"^(?:\| |- )([\w.]+-\d\d)(?: \||:) ", page, flags=re.M)
    assert sorted(rows) == sorted(claim["id"] for claim in claims)
    assert re.findall(r"^### (\d)\. ", page, flags=re.M) == list("123456")
    assert "<a " not in page
    assert "| Eq. 21, M_33 |" in page
    verdicts = [r for r in published.json["chapters"]["findings"] if "verdict" in r]
    assert verdicts
    assert all(f"| {r['question']} | {r['verdict']} |" in page for r in verdicts)
    assert all(f" *{claim['reading']}*" in page for claim in claims if claim["reading"])
    simulated = [claim for claim in claims if not claim["static"]]
    near = [claim["id"] for claim in simulated if claim["turns_within_a_quarter"]]
    assert f"{len(near)} of {len(simulated)} verdicts that runs decide turn within 25 %" in page


@pytest.fixture
def argument(published, monkeypatch, tmp_path) -> Path:
    """The argument, quoting what this run answers."""
    records = published.records("findings")
    text = write_article.ARGUMENT.read_text(encoding="utf-8")
    file = tmp_path / "argument.md"
    quote = r"`(verdict/[\w-]+)`: \*\*.*?\*\*"
    answered = re.sub(quote, lambda m: f"`{m[1]}`: **{records[m[1]]['verdict']}**", text)
    file.write_text(answered, encoding="utf-8")
    monkeypatch.setattr(write_article, "ARGUMENT", file)
    return file


def _list_numbers(text: str) -> set[str]:
    return set(re.findall(r"\d+(?:\.\d+)?(?:e[-+]\d+)?", text))


def _is_recorded(number: str, records: list[float]) -> bool:
    """Whether a record, or its percentage, is this number to the digits that it has."""
    mantissa, _, exponent = number.partition("e")
    half = 0.5000001 * 10.0 ** (int(exponent or 0) - len(mantissa.partition(".")[2]))
    close = half if "." in number else 0.0
    return any(abs(by * each - float(number)) <= close for each in records for by in (1, 100))


def test_every_number_of_the_article_is_the_runs_or_the_arguments(published, argument, tmp_path):
    write_article.write_article(published.out, tmp_path / "article")
    written = (tmp_path / "article" / "content.tex").read_text(encoding="utf-8")
    plain = re.sub(r"(?m)^%.*|\\supercite\{.*?\}|p\{.*?\\linewidth\}|figures/\S+", "", written)
    whole = _list_numbers((published.out / "claims.json").read_text(encoding="utf-8"))
    findings = " ".join(body for _, body in case_study.split_findings(published.html))
    quoted = _list_numbers(SVG.sub("", findings) + argument.read_text(encoding="utf-8"))
    other = _list_numbers(plain) - quoted - whole
    recorded, claims = [float(each) for each in whole], published.json["chapters"]["claims"]
    recorded += [len(claims), sum(not claim["static"] for claim in claims)]
    for column in case_study.COLUMNS:
        kinds = [claim["models"].get(column, claim)["verdict"] for claim in claims]
        recorded += Counter(kinds).values()
    assert [each for each in sorted(other) if not _is_recorded(each, recorded)] == []
    assert len(other) > 0


def test_nothing_in_the_articles_own_text_is_a_number():
    folder = Path(write_article.__file__).with_name("article")
    text = (folder / "content.tex").read_text(encoding="utf-8")
    assert re.search(r"\d", re.sub(r"\\supercite\{.*?\}", "", text)) is None


def test_the_article_is_whole_and_discloses_what_was_not_seen(published, argument, tmp_path):
    out = tmp_path / "article"
    write_article.write_article(published.out, out)
    written = (out / "content.tex").read_text(encoding="utf-8")
    assert "Its figures were not seen" in written
    assert "authors of the original were not asked" in written
    for opening, closing in ("{}", (r"\begin{", r"\end{")):
        assert written.count(opening) - written.count(rf"\{opening}") == written.count(closing)
    assert written.count("$") % 2 == 0
    assert written.isascii()
    drawn = set(re.findall(r"figures/([\w-]+)\.pdf", written))
    assert drawn == {file.stem for file in (out / "figures").iterdir()}
    assert len(drawn) == 3
    cited = set(re.findall(r"\\supercite\{(.*?)\}", written))
    assert cited <= set(re.findall(r"@\w+\{(.*?),", (out / "bibliography.bib").read_text("utf-8")))
    metadata = yaml.safe_load((out / "metadata.yaml").read_text(encoding="utf-8"))
    assert metadata["replication"][0]["cite"] == published.json["paper"]["citation"]
    assert {"authors", "affiliations", "keywords", "code", "data", "review"} <= set(metadata)


def test_an_argument_that_quotes_another_answer_is_refused(published, argument, tmp_path):
    text = argument.read_text(encoding="utf-8")
    argument.write_text(text.replace("**undefined**", "**no**", 1), encoding="utf-8")
    with pytest.raises(InputError, match="the run says undefined"):
        write_article.write_article(published.out, tmp_path / "article")
    assert not (tmp_path / "article").exists()


def test_the_errata_sheet_has_every_entry_and_draws_every_formula(published):
    sheet = (published.out / "errata.html").read_text(encoding="utf-8")
    assert page_problems(sheet) == []
    records = published.chapters["errata"].records
    text = unescape(sheet)
    for record in require_items(records):
        said = record.get("derived") or record.get("here") or record["first_says"]
        assert record.get("derived_tex") or str(said) in text
    formulas = [record[side] for record in records for side in TEX if record.get(side)]
    assert sheet.count("<svg") == len(formulas) > 0


@pytest.mark.parametrize("name", ["presence-visible", "accumulation-time"])
def test_what_needs_a_longer_run_is_undefined(published, name):
    assert published.records("findings")[f"verdict/{name}"]["verdict"] == UNDEFINED


def test_claims_about_later_events_are_undefined_and_say_so(published):
    records = published.records("claims")
    asked = [c.id for c in CLAIMS if {q.id for q in c.choices.values()} == {"pd: third"}]
    assert asked
    for record in (records[name] for name in asked):
        assert record["verdict"] == UNDEFINED
        assert {(one["state"], one["yes"]) for one in record["settings"]} == {(UNDEFINED, None)}
        assert all(one["undefined"] == one["starts"] == 2 for one in record["settings"])
    static = [records[claim.id] for claim in CLAIMS if claim.static]
    assert {one["undefined"] for record in static for one in record["settings"]} == {0}
