"""Drafts for other ways of installing say what the project says. None is built here."""

import json
import tomllib

import yaml

import crosscheck
from crosscheck.provenance import ROOT
from tools.preflight import SYSTEM_LIBRARIES

PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
DOCKERFILE = ROOT / ".devcontainer" / "Dockerfile"


def test_the_container_has_what_the_set_up_asks_for():
    lines = DOCKERFILE.read_text(encoding="utf-8")
    for package in ("git", "make", *SYSTEM_LIBRARIES.values()):
        assert f" {package} " in lines.replace("\n", " "), package
    container = json.loads((DOCKERFILE.parent / "devcontainer.json").read_text(encoding="utf-8"))
    assert container["build"]["dockerfile"] == DOCKERFILE.name
    assert container["postCreateCommand"] == "make run"


def test_the_pixi_draft_installs_the_source_distribution_of_this_version():
    draft = tomllib.loads((ROOT / "packaging" / "pixi.toml").read_text(encoding="utf-8"))
    path = draft["pypi-dependencies"][PROJECT["project"]["name"]]["path"]
    assert path == f"../dist/geararm_crosscheck-{crosscheck.__version__}.tar.gz"
    assert draft["dependencies"]["python"].startswith(PROJECT["project"]["requires-python"])


def test_the_action_installs_the_same_libraries():
    steps = yaml.safe_load((ROOT / "action.yml").read_text(encoding="utf-8"))["runs"]["steps"]
    scripts = " ".join(step.get("run", "") for step in steps)
    assert [each for each in SYSTEM_LIBRARIES.values() if each not in scripts.split()] == []


def test_what_tests_read_is_in_the_source_distribution():
    included = PROJECT["tool"]["hatch"]["build"]["targets"]["sdist"]["only-include"]
    assert {".ci", ".devcontainer", "action.yml", "packaging", "docs", "examples"} <= set(included)
