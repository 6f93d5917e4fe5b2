"""Drafts for other ways of installing say what the project says. None is built here."""

import json
import re
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


def test_the_action_pins_what_it_installs_and_keeps_its_page_whatever_the_trial_says():
    steps = yaml.safe_load((ROOT / "action.yml").read_text(encoding="utf-8"))["runs"]["steps"]
    scripts = " ".join(step.get("run", "") for step in steps).split()
    assert {*SYSTEM_LIBRARIES.values(), "--require-hashes"} <= set(scripts)
    *_, annotations, upload = steps
    assert annotations["if"] == upload["if"] == "${{ !cancelled() }}"
    assert upload["with"]["path"] == "${{ inputs.out }}"


def test_the_archive_and_the_paper_say_what_the_project_says():
    """No author is made up, and each reference of the paper is in its list, with a DOI."""
    archive = json.loads((ROOT / ".zenodo.json").read_text(encoding="utf-8"))
    assert archive["license"] == PROJECT["project"]["license"]
    assert archive["keywords"] == PROJECT["project"]["keywords"]
    text = (ROOT / "packaging" / "joss" / "paper.md").read_text(encoding="utf-8")
    listed = (ROOT / "packaging" / "joss" / "paper.bib").read_text(encoding="utf-8")
    entries = dict(re.findall(r"^@\w+\{(\w+),(.*?)^\}", listed, re.S | re.M))
    assert set(re.findall(r"\[@(\w+)\]", text)) == set(entries)
    assert all("doi " in entry for entry in entries.values())
    head = yaml.safe_load(text.split("---")[1])
    assert archive["creators"] == head["authors"] == head["affiliations"] == []


def test_what_tests_read_is_in_the_source_distribution():
    included = PROJECT["tool"]["hatch"]["build"]["targets"]["sdist"]["only-include"]
    assert {".ci", ".devcontainer", "action.yml", "packaging", "docs", "examples"} <= set(included)
