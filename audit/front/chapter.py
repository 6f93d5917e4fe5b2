"""The page's beginning: six findings, what they mean, and how to repair the model."""

from __future__ import annotations

from collections import Counter

from crosscheck.audit.claims.words import COLUMNS
from crosscheck.audit.errata.engine import PrintedBeside
from crosscheck.audit.experiments.cells import INTEGRAL, LABELLED, LAWS, PRINTED
from crosscheck.audit.front.findings import MODELS, baseline_finding, third_finding
from crosscheck.audit.front.views import clock_svg, third_svg
from crosscheck.audit.hypotheses.accumulation import largest, shaken, verdict
from crosscheck.audit.hypotheses.evidence.linear_limits import cured_at_the_sun, survey
from crosscheck.audit.hypotheses.evidence.shaking import DRIVES
from crosscheck.audit.hypotheses.ladder import climbed, picture
from crosscheck.audit.hypotheses.words import LEVELS
from crosscheck.audit.measures.thresholds import SEVERE
from crosscheck.audit.page.chapter import AuditChapter, rendered
from crosscheck.audit.page.material import Material
from crosscheck.audit.page.said import StatedNumber
from crosscheck.audit.page.text import html, text
from crosscheck.audit.page.words import LAW_MEANINGS, LAW_NAMES
from crosscheck.audit.phase.clock import RUN_WINDOW_S, RUN_ZETA, clocks

ID, TITLE = "findings", "What came out"


def chapter(material: Material) -> AuditChapter:
    """The findings."""
    study, scale = material.study, material.scale
    (printed,) = study.answers([PrintedBeside(LABELLED, scale.longest_s)], "printed equations")
    clock, third = clocks(study, scale), third_finding(material)
    ladder = climbed(material)
    baselines = baseline_finding(ladder, material)
    accumulated = shaken(material)
    by_drive = {drive: [one for one in accumulated if one.drive == drive] for drive in DRIVES}
    limits = survey(scale.quick)
    zetas = [one.zeta for one in limits if one.is_papers]
    said = {
        "printed": printed,
        "clocks": clock,
        "by_law": {one.law: one for one in clock.laws},
        "third": third,
        "baselines": baselines,
        "level": LEVELS[baselines.nearest.level] if baselines.nearest else "",
        "accumulation": {drive: verdict(found) for drive, found in by_drive.items()},
        "largest_rad": {drive: largest(found[0]) for drive, found in by_drive.items()},
        "unstable_below": (min(zetas), max(zetas)),
        "cured": cured_at_the_sun(limits),
        "PRINTED": PRINTED,
        "INTEGRAL": INTEGRAL,
        "severe": SEVERE,
    }
    asked = [one for one in material.judged.values() if not one.claim.static]
    verdicts = {
        name: Counter(str(one.by_model[model].kind) for one in asked)
        for model, name in COLUMNS.items()
    }
    page = text(
        "front/findings",
        **said,
        clock_svg=html(clock_svg(clock)),
        window_s=RUN_WINDOW_S,
        run_zeta=RUN_ZETA,
        third_svg=html(third_svg(third)),
        baselines_svg=html(picture(ladder)),
        names=LAW_NAMES,
        meanings=LAW_MEANINGS,
        laws=LAWS,
        models=MODELS,
        verdicts=verdicts,
    )
    records = [printed.to_dict(), *rendered([*third.strips])]
    numbers = [
        StatedNumber(TITLE, f"{name} left by {one.level}", one.arm, abs(deviation.total))
        for one in baselines.left
        for name, deviation in one.found.items()
    ]
    outcome = text("front/outcome", **said)
    return AuditChapter(ID, TITLE, page, records, outcome, third.said(), numbers)
