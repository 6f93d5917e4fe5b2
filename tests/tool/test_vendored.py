"""Scripts of others are the files that their package has: as stated beside them."""

import hashlib
import re

import pytest

from crosscheck.provenance import ROOT

FOLDERS = (ROOT / "crosscheck" / "report" / "vendor", ROOT / "tests" / "browser")
SCRIPTS = [
    path for folder in FOLDERS for path in folder.iterdir() if path.suffix in (".js", ".css")
]


@pytest.mark.parametrize("path", SCRIPTS, ids=lambda path: path.name)
def test_a_script_is_unchanged_and_has_its_licence(path):
    stated = (path.parent / "README.md").read_text(encoding="utf-8")
    assert hashlib.sha256(path.read_bytes()).hexdigest() in stated
    (licence,) = re.findall(rf"{re.escape(path.name)}.*?([\w.]+\.LICENSE)", stated, flags=re.S)[:1]
    assert "Licen" in (path.parent / licence).read_text(encoding="utf-8")
