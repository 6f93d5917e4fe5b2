# make run        set up and run the cross-check; writes report/index.html and report/agreement.json
# make test       set up and run the test suite
# make test-fast  the first case of every test, none that is slow: before every commit
# make test-system  what the suite leaves out: whole commands killed, starved, installed, in odd surroundings
# make fuzz       the suite's campaigns at length, DRAWS=1000 of each, and other examples of its properties
# make octave     answers from GNU Octave (needs octave-cli), which the suite skips without
# make coverage   the suite, measured: docs/project/coverage.md
# make lint       style, types and import contracts
# make bench      measure speed side by side: benchmarks/results.json, results.png
# make paper      the paper's figures and claims: paper-report/paper.html
# make article    the article on the last make paper, for the journal's template: article/content.tex
# make docs       the docs as a site, warnings are errors: build/docs/index.html
# make lock       compile the dependencies of pyproject.toml into the hashed lock files (needs uv)
# make clean      remove everything the targets above made
PYTHON ?= python3
PY := .venv/bin/python
PIP := $(PY) -m pip --disable-pip-version-check
INSTALL := $(PIP) install --quiet --require-hashes --no-deps --only-binary :all:
EDITABLE := $(PIP) install --quiet --no-deps --no-build-isolation --no-index -e .

TEST := $(PY) -m pytest -rs -n auto --dist loadscope --no-loadscope-reorder
DRAWS ?= 1000

# Python keeps what it compiles: without, each process of the suite compiles all of it anew.
unexport PYTHONDONTWRITEBYTECODE

.PHONY: run test test-fast test-system fuzz octave coverage lint bench paper article docs lock clean
.DELETE_ON_ERROR:

run: .venv/run.stamp
	$(PY) -m crosscheck run --out report

test: .venv/dev.stamp
	$(TEST)

test-fast: .venv/dev.stamp
	$(TEST) --first-cases

test-system: .venv/dev.stamp
	$(TEST) -m system

fuzz: .venv/dev.stamp
	CROSSCHECK_DRAWS=$(DRAWS) $(TEST) -m "campaign or hypothesis" --timeout 0

octave: .venv/dev.stamp
	octave-cli --version
	$(PY) -m pytest -m "system or not system" tests/trial/other_tools/test_octave.py

coverage: .venv/dev.stamp
	$(PY) -m coverage erase
	$(PY) -m coverage run -m pytest -n auto --dist loadscope --no-loadscope-reorder
	$(PY) -m coverage combine --quiet
	mkdir -p build
	$(PY) -m coverage json --quiet -o build/coverage.json
	$(PY) -m tools.coverage build/coverage.json

lint: .venv/dev.stamp
	$(PY) -m ruff check .
	$(PY) -m ruff format --check .
	$(PY) -m mypy
	.venv/bin/lint-imports

bench: .venv/dev.stamp
	$(PY) -m benchmarks.suite

paper: .venv/run.stamp
	$(PY) -m crosscheck paper --out paper-report

article: .venv/dev.stamp
	$(PY) -m tools.write_article paper-report article

docs: .venv/dev.stamp
	$(PY) -m sphinx -W --keep-going -q -b html docs build/docs

lock:
	uv pip compile pyproject.toml --extra build --universal --python-version 3.11 --generate-hashes --no-emit-index-url --no-header -q -o run.lock
	uv pip compile pyproject.toml --extra dev --universal --python-version 3.11 --generate-hashes --no-emit-index-url --no-header -q -o dev.lock

.venv/venv.stamp: tools/preflight.py
	$(PYTHON) tools/preflight.py
	test -x $(PY) || $(PYTHON) -m venv .venv
	touch $@

.venv/run.stamp: .venv/venv.stamp run.lock pyproject.toml
	$(INSTALL) -r run.lock
	$(EDITABLE)
	touch $@

.venv/dev.stamp: .venv/run.stamp dev.lock
	$(INSTALL) -r dev.lock
	touch $@

clean:
	rm -rf .venv .coverage* report paper-report article docs/generated benchmarks/results.png build dist .pytest_cache .mypy_cache .ruff_cache .import_linter_cache .hypothesis
	find models analytic crosscheck tests benchmarks tools examples -name __pycache__ -type d -prune -exec rm -rf {} + 2>/dev/null || true
