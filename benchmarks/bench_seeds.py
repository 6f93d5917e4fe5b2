"""Do other starts turn verdicts? Every claim from several sets of seeded starts.

    python benchmarks/bench_seeds.py [--sets 3] [--jobs 2]

Prints the claims whose verdict differs between sets, what each set says, and the share of all: over
all models of the gears, and in each of the two columns. The runs are kept as those of
`crosscheck paper` are, so the first set is its own.
"""

from __future__ import annotations

import argparse
from collections.abc import Mapping, Sequence
from dataclasses import replace

from crosscheck.audit.claims.chapter import COLUMNS
from crosscheck.audit.claims.study_plan import AuditContext
from crosscheck.audit.experiments.samples import FULL
from crosscheck.audit.experiments.study import Study
from crosscheck.audit.judging.rule import VerdictKind
from crosscheck.models.directories import cache_folder
from crosscheck.runner.progress import show_progress

SEED_STEP = 1000  # between the first seeds of two sets


def collect_verdicts(material: AuditContext) -> dict[str, dict[str, VerdictKind]]:
    """By claim id: over all models, and where runs decide by column."""
    judged = material.judged_claims
    outcomes_by_column = {
        "all models": {name: judgement.verdict.kind for name, judgement in judged.items()}
    }
    for model, column in COLUMNS.items():
        run_claims = {
            name: judgement for name, judgement in judged.items() if not judgement.claim.static
        }
        outcomes_by_column[column] = {
            name: judgement.by_model[model].kind for name, judgement in run_claims.items()
        }
    return outcomes_by_column


def describe_differences(sets: Sequence[Mapping[str, VerdictKind]]) -> str:
    """What differs."""
    lines, moved = [], 0
    for name in sets[0]:
        outcomes = [verdicts[name] for verdicts in sets]
        if len(set(outcomes)) == 1:
            continue
        moved += 1
        through = "" if VerdictKind.BISTABLE in outcomes else "  NOT by way of bistable"
        lines.append(f"{name}: {' | '.join(outcomes)}{through}")
    share = moved / len(sets[0])
    return "\n".join([*lines, f"{moved} of {len(sets[0])} claims ({100 * share:.1f} %)"])


def compare_seeds() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--sets", type=int, default=3)
    parser.add_argument("--jobs", type=int, default=2)
    given = parser.parse_args()
    with show_progress("running seeds") as progress:
        study = Study(cache_folder(), given.jobs, progress)
        sets = [
            collect_verdicts(AuditContext(study, replace(FULL, first_seed=1 + SEED_STEP * number)))
            for number in range(given.sets)
        ]
    for column in sets[0]:
        print(f"{column}:\n{describe_differences([verdicts[column] for verdicts in sets])}")


if __name__ == "__main__":
    compare_seeds()
