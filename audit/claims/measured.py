"""What the experiments measure: every number once, with what it means and where it looks.

Accelerations are the detailed arm's less those of the rigid arm at level `coupled`; mesh quantities
are those of the shoulder's sun-planet pair, first planet. The words are in ``measured.toml``, the
measures in ``experiments.pd`` (``transient`` and ``whole``), ``experiments.torque``
(``measure_constant_torque``, ``measure_back_and_forth``) and ``statics``.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

from pydantic import TypeAdapter

from crosscheck.audit.experiments.experiments import BACK, BACK_EVEN
from crosscheck.audit.experiments.torque import ERROR_WINDOWS_S
from crosscheck.audit.judging.quantities import Measures, Number
from crosscheck.audit.measures.events import AT_ONCE_S
from crosscheck.audit.statics.statics import BASE_MASSES, BENDS
from crosscheck.audit.statics.teeth import CONTACT_RATIOS, COUNTED, SIGMAS
from crosscheck.models.files import read_toml
from crosscheck.registry import RIGID_LEVELS

# Parts of a run that several numbers look at.
WINDOWS = {
    "first": "0 to 0.25 s",
    "second": "0.1 s from the side change",
    "third": "0.5 to 1.2 s",
    "peak": "Hann window over 0.1 s around the third's peak",
    "three": "the first three fluctuations",
    "flight": "the side change",
    "at_once": f"{AT_ONCE_S:g} s from the side change",
    "whole": "whole run",
    "late": "after 0.1 s",
    "back": "1.3 to 2.4 s",
    "later": "from 0.25 s",
}
# By table of the file: what its names and words stand for, case by case.
CASES: dict[str, Sequence[Mapping[str, object]]] = {
    "pd": [{}],
    "constant_torque": [{}],
    "swings": [{"ends": n, "begin": b, "end": e} for n, (b, e) in ERROR_WINDOWS_S.items()],
    "static": [{}],
    "conversions": [{"how": how} for how in COUNTED],
    "bends": [{"angle": angle} for angle in BENDS],
    "sharpnesses": [{"sigma": sigma} for sigma in SIGMAS],
    "bases": [{"mass": mass} for mass in BASE_MASSES],
    "spectra": [{"joint": "", "name": "shoulder"}, {"joint": "_elbow", "name": "elbow"}],
    "positions": [{"joint": 1, "name": "shoulder"}, {"joint": 2, "name": "elbow"}],
    "levels": [{"level": level} for level in RIGID_LEVELS],
    "series": [{"ratio": ratio} for ratio in CONTACT_RATIOS],
}
# By what statements.toml calls them, the same of claims; the first value of each names the choice.
CLAIM_CASES: dict[str, Sequence[Mapping[str, object]]] = CASES | {
    "drives": [
        {"choice": f"{words}, {seconds} s", "drive": series.kind, "seconds": seconds}
        for words, series in {"sin(20π√t)": BACK, "sin(20πt)": BACK_EVEN}.items()
        for seconds in ("1", "2")
    ],
    "two planets": [
        {"choice": "equal stiffness of all meshes together", "two_planets": "two planets"},
        {"choice": "equal stiffness of each mesh", "two_planets": "two planets as they are"},
    ],
    "joints": [{"choice": "the shoulder", "joint": 1}, {"choice": "the elbow", "joint": 2}],
}
_TABLES = TypeAdapter(dict[str, dict[str, Number]]).validate_python(
    read_toml(Path(__file__).with_suffix(".toml"))
)
MEASURED: dict[str, Number] = {
    name.format(**case): Number(*(text.format(**WINDOWS, **case) for text in number))
    for table, cases in CASES.items()
    for case in cases
    for name, number in _TABLES[table].items()
}
MEASURES = Measures(MEASURED)
