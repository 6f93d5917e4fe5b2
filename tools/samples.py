"""Pages that the commands make, as samples of the docs: made anew whenever the site is built."""

from __future__ import annotations

import re
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

from crosscheck.output import write_files
from crosscheck.provenance import ROOT


@dataclass(frozen=True)
class Sample:
    """A page: its name, what it answers, its commands, the file, the exit code of the last."""

    name: str
    title: str
    commands: tuple[str, ...]
    file: str
    exit_code: int = 0


RECORDING = str(ROOT / "examples" / "recordings" / "payload.csv")
SAMPLES = (
    Sample(
        "run",
        "The cross-check: do the paper's equations agree?",
        ("run paper-labelled --quick --out report",),
        "report/index.html",
    ),
    Sample(
        "trial",
        "A trial: which entry of my equations is wrong?",
        (
            "init my-arm.toml --direct",
            "trial my_model.py:pendulum my-arm.toml --quick --out trial",
        ),
        "trial/trial.html",
        1,
    ),
    Sample(
        "view",
        "A run in three dimensions, with its gears",
        (
            "simulate paper-labelled --model exudyn:tree --scenario pd --t-end 0.05 --out run.nc",
            "view run.nc",
        ),
        "run.html",
    ),
    Sample(
        "cost",
        "What does leaving out the motors cost?",
        ("cost puma560 --quick --out cost",),
        "cost/cost.html",
    ),
    Sample(
        "compare",
        "Does my model fit the recording?",
        (f"compare {RECORDING} paper-labelled --out compared",),
        "compared/compare.html",
        1,
    ),
    Sample(
        "errata",
        "The paper's errors, typeset",
        ("errata --out errata",),
        "errata/errata.html",
    ),
    Sample(
        "paper",
        "A figure of the paper, again",
        ("paper --figure 6 --out paper",),
        "paper/paper.html",
    ),
)


def write_sample(sample: Sample, files: Path) -> None:
    """Run its commands and keep its page. Raises ValueError: a command ends otherwise."""
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    (model,) = re.findall(r"```python\n(.*?)```", readme, re.S)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "my_model.py").write_text(model, encoding="utf-8")
        for number, command in enumerate(sample.commands, 1):
            words = [sys.executable, "-m", "crosscheck", *command.split()]
            answer = subprocess.run(words, cwd=folder, capture_output=True, text=True, check=False)
            wanted = sample.exit_code if number == len(sample.commands) else 0
            if answer.returncode != wanted:
                raise ValueError(f"crosscheck {command}: {answer.returncode}\n{answer.stderr}")
        page = (folder / sample.file).read_text(encoding="utf-8")
    write_files({files / f"{sample.name}.html": page})
