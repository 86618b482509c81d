# One word each; `make` alone lists them. Works on Linux and macOS.

PYTHON ?= python3
VENV   := .venv
DIST   := dist
DEMO   := out/demo
BENCH  := out/bench
MATRIX := out/matrix
SUITE := out/suite
SITE   := out/site
FUZZ   := out/fuzz
COVERAGE := out/coverage
SOAK   := out/soak
PLAY   := out/playground
# For each target of `make fuzz`; FUZZ_TARGETS="path laws" takes those alone.
FUZZ_SECONDS ?= 60
FUZZ_TARGETS ?=
# Which parts of the package `make mutants` plants faults in.
MODULES ?= lab/sweep
# Of pytest: one more than there are cores, as tests of nodes and browsers wait; at most 8.
WORKERS ?= $(shell cores=$$(getconf _NPROCESSORS_ONLN); echo $$((cores < 8 ? cores + 1 : 8)))
# Where `make install-c` puts the C interface; DESTDIR before it, for packages.
PREFIX ?= /usr/local
# From there on, where its libraries go: lib/x86_64-linux-gnu for Debian.
LIBDIR ?= lib

PY := $(VENV)/bin/python
# Absolute, because build scripts run in their own crate's folder.
export PYO3_PYTHON := $(CURDIR)/$(PY)
# Spares `cargo clippy` and `cargo build` a libpython to link, which many systems do not ship.
export PYO3_BUILD_EXTENSION_MODULE := 1
export PIP_DISABLE_PIP_VERSION_CHECK := 1
# They could put another popsteer, or another Python, before the installed one, and let each process compile anew.
unexport PYTHONPATH PYTHONHOME PYTHONDONTWRITEBYTECODE
# It chooses how sums are rounded, and with that the last digits of what was recorded.
unexport OPENBLAS_CORETYPE

# What the wheel is made of. Folders count, so that a deleted file is noticed too.
SOURCES := $(wildcard Cargo.toml Cargo.lock pyproject.toml README.md LICENSE) \
           $(shell find rust python -name __pycache__ -prune -o -print 2>/dev/null)
WHEEL   := $(DIST)/.built
MATURIN := $(shell sed -n 's/^requires = \["\(maturin[^"]*\)"\]$$/\1/p' pyproject.toml)

.DEFAULT_GOAL := help
.DELETE_ON_ERROR:
# cargo uses all cores by itself, and no two of pip may be at one environment; TWO are let run where one often waits.
ifndef TOGETHER
.NOTPARALLEL:
endif
TWO := --jobs=2 TOGETHER=yes
# Of `make test`, which runs one row beside another: what comes after what in the second one, and before it a `nice`.
ifdef ROWS
lint-rust: | test-rust
lint-python: | lint-rust
ASIDE := nice -n 5
endif
.PHONY: help setup demo check test test-rust test-python declared parity lint lint-rust lint-python bench matrix suite pages playground site audit fuzz coverage mutants soak wheel sdist install-c uninstall-c clean FORCE

help: ## list these targets
	@awk -F ':.*## ' '/^[a-z-]+:.*## / { printf "  make %-12s %s\n", $$1, $$2 }' $(MAKEFILE_LIST)
	@echo
	@echo "  make PYTHON=python3.12 ... uses that interpreter (default: python3, 3.10 or newer)"

setup: $(VENV)/.dev ## make .venv with popsteer and all that developing it needs

demo: $(VENV)/.lab ## drive the embedded track with the paper's controllers, and draw it
	$(VENV)/bin/popsteer paper --out $(DEMO)
	@echo
	@echo "Figures are in $(CURDIR)/$(DEMO):"
	@find $(DEMO) -name '*.png' -o -name '*.svg' | sort | sed 's/^/  /'

# Wants the environment of `make setup`, and not its wheel: nothing is built in release.
check: $(VENV)/pyvenv.cfg ## after an edit, in a minute: format, clippy, the core's tests, a smoke of Python
	@$(PY) -c 'import pytest, xdist' 2>/dev/null || { echo "make setup first: it installs what the tests need"; exit 2; }
	cargo fmt --all --check
	$(PY) -m ruff check --quiet
	$(PY) -m ruff format --check --quiet
	cargo clippy --workspace --all-targets --features popsteer-bench/criterion --locked --quiet -- -D warnings
	cargo test --package popsteer-core --package popsteer-core-tests --locked --quiet
	sh tests/smoke.sh $(PY)

# Two rows, neither of which waits for the other: wheel, environment and Python's tests, which is the longer one; Rust's tests
# and all lints. pip, the last crate of a wheel, and tests that wait leave a core to the second row; its lints take no more than
# that. A third job is let run so that a lint whose turn it is not yet takes no place.
test: $(VENV)/pyvenv.cfg ## run every check: Rust tests, Python tests, lints, stubs
	@$(MAKE) --jobs=3 TOGETHER=yes ROWS=yes test-python test-rust lint-rust lint-python

# The binding, with all that PyO3 is made of, is compiled by clippy and for the wheel, and tested from Python. The features
# are those that it asks for.
test-rust: $(VENV)/pyvenv.cfg ## run the Rust tests
	cargo test --workspace --exclude popsteer-py --features popsteer-core/serde,popsteer-sim/serde --locked

# What tests build by make and cargo is no part of this make, and says nothing of its jobs. The first line compiles the tests,
# with what pytest adds to each assertion, once for all workers; what it would say the second one says.
test-python: $(VENV)/.dev ## run the Python tests against the installed wheel
	@$(PY) -m pytest --collect-only --quiet >/dev/null 2>&1 || true
	MAKEFLAGS= MFLAGS= $(PY) -m pytest --numprocesses $(WORKERS) --dist worksteal

declared: $(VENV)/pyvenv.cfg ## write what the declarations of parameters make: stub, C header, page
	POPSTEER_WRITE=1 cargo test --locked --package popsteer-c --package popsteer-sim --test header --test declared

parity: $(VENV)/.dev ## compare core and reference in 10,000 examples of each property: hours
	HYPOTHESIS_PROFILE=thorough $(PY) -m pytest tests/parity --numprocesses $(WORKERS) --dist worksteal

lint: $(VENV)/.dev ## check format, lints, types and stubs
	@$(MAKE) $(TWO) lint-rust lint-python

lint-rust: $(VENV)/pyvenv.cfg
	cargo fmt --all --check
	$(ASIDE) cargo clippy --workspace --all-targets --features popsteer-bench/criterion --locked -- -D warnings
	cargo fmt --manifest-path tests/fuzz/Cargo.toml --check

lint-python: $(VENV)/.dev
	$(PY) -m ruff check
	$(PY) -m ruff format --check
	$(ASIDE) $(PY) -m mypy
	$(ASIDE) $(PY) -m mypy.stubtest popsteer._core --allowlist rust/py/stubtest.txt

# One run: what an earlier one left goes first, so that no table mixes the two.
bench: $(VENV)/.lab $(VENV)/.yardsticks ## measure the control step, in Rust and from Python; write the tables
	rm -rf $(BENCH)
	mkdir -p $(BENCH)
	touch $(BENCH)/started
	cargo bench --package popsteer-bench --features criterion --locked
	$(PY) -m benches.latency $(BENCH)
	$(PY) benches/path_scale.py --json $(BENCH)/path_scale.json
	$(PY) benches/instruction_counts.py --json $(BENCH)/instruction_counts.json
	$(PY) -m studies.bench $(BENCH)

matrix: $(VENV)/.dev ## controllers, plants and tracks side by side; write README's table and figure of it
	$(VENV)/bin/popsteer compare --controllers pop,preview-pop,pure-pursuit,stanley,pid,mpc \
		--plants carla-identified,kinematic-bicycle,commonroad-mb-2,mujoco-car \
		--tracks racetrack,double-lane-change,slalom --constant-speed 10 --start-offset 1 --set-run settling_time=5 --step-time --out $(MATRIX)
	$(PY) -m studies.matrix $(MATRIX)
	$(PY) -m studies.pages choose

suite: $(VENV)/.dev ## the suite standard-2 by popsteer's controllers and the opponents; write docs/results.md
	$(VENV)/bin/popsteer suite --out $(SUITE) --controllers \
		"$$($(PY) -c 'from popsteer.lab import opponents; print("preview-pop", *opponents.names(), "stanley", "pure-pursuit", "pop", "pid", sep=",")')"
	$(PY) -m studies.suite $(SUITE)

pages: $(VENV)/.dev ## drive what the tables and figures of docs/ show; rewrite them
	$(PY) -m studies.pages
	$(PY) -m studies.figures
	$(PY) -m studies.front

# The playground is WebAssembly, whose target a toolchain may lack; without it the site has none.
site: $(VENV)/.dev ## build the documentation site into out/site
	@if [ -d "$$(rustc --print target-libdir --target wasm32-unknown-unknown)" ]; then \
		$(MAKE) playground; fi
	$(PY) -m docs.site $(SITE)

audit: $(VENV)/.dev $(VENV)/.audit ## check the dependencies: known vulnerabilities, licences; AUDIT=--online where there is a network
	$(PY) -m docs.site.audit $(AUDIT)

playground: $(VENV)/.lab ## build the playground for browsers; needs the target wasm32-unknown-unknown
	$(PY) docs/playground/build.py $(PLAY)

fuzz: $(VENV)/.fuzz ## fuzz the core and the CSV reader, FUZZ_SECONDS=60 for each target
	$(PY) tests/fuzz/run.py $(FUZZ_TARGETS) --seconds $(FUZZ_SECONDS)

coverage: $(VENV)/.dev ## measure which lines of the core and the simulations the tests reach
	sh tests/coverage.sh $(COVERAGE) $(CURDIR)/$(PY)

mutants: $(VENV)/.dev $(VENV)/.mutants ## plant small faults in the Python half and count those that its tests catch; MODULES="planning lab/sweep"
	$(PY) -m tests.mutation $(MODULES)

soak: $(VENV)/.dev ## step controllers 100,000,000 times and watch their memory
	$(PY) benches/soak.py --json $(SOAK)/soak.json

wheel: $(WHEEL) ## build an installable wheel into dist/
	@ls $(DIST)/popsteer-*.whl

sdist: $(VENV)/.audit ## build the sdist into dist/sdist, and prove it: offline, with vendored crates, in a clean environment
	sh rust/py/dist.sh $(CURDIR)/$(PY) $(DIST)/sdist

install-c: ## install the C and C++ interface, under PREFIX=/usr/local
	cargo build --release --locked --package popsteer-c
	sh rust/c/install.sh "$(DESTDIR)$(PREFIX)" "$(LIBDIR)"

uninstall-c: ## remove it from there
	sh rust/c/install.sh "$(DESTDIR)$(PREFIX)" "$(LIBDIR)" uninstall

clean: ## remove all that these targets made
	rm -rf $(VENV) $(DIST) $(DEMO) $(BENCH) $(MATRIX) $(SITE) $(FUZZ) $(COVERAGE) $(SOAK) $(PLAY) target .hypothesis .mypy_cache .pytest_cache .ruff_cache
	find python tests benches studies ros2 -name __pycache__ -prune -exec rm -rf {} +

# What keeps this machine from building popsteer, in one line; empty if nothing does.
toolchain_fault = $(shell \
	if ! command -v '$(PYTHON)' >/dev/null 2>&1; then \
		echo "$(PYTHON) not found: install Python 3.10 or newer, or name one: make PYTHON=python3.12"; \
	elif ! '$(PYTHON)' -c 'import sys; sys.exit(sys.version_info < (3, 10))' >/dev/null 2>&1; then \
		echo "$(PYTHON) is not Python 3.10 or newer: install one, or name one: make PYTHON=python3.12"; \
	elif ! '$(PYTHON)' -c 'import ensurepip, venv' >/dev/null 2>&1; then \
		echo "$(PYTHON) lacks venv or ensurepip: install them (on Debian python3-venv), or name another: make PYTHON=python3.12"; \
	elif ! command -v cargo >/dev/null 2>&1; then \
		echo "cargo not found: install a Rust toolchain"; \
	elif ! { cargo --version && rustc --version; } >/dev/null 2>&1; then \
		echo "cargo is installed without a Rust toolchain that runs: install one (with rustup: rustup default stable)"; \
	elif [ -n "$(filter setup test lint,$(MAKECMDGOALS))" ] && \
			! { cargo fmt --version && cargo clippy --version; } >/dev/null 2>&1; then \
		echo "cargo fmt or cargo clippy is missing: install them (with rustup: rustup component add rustfmt clippy)"; \
	fi)

# Looked at every time and made anew only when the interpreter or the checkout's place has changed; as long as the
# file stays untouched, nothing that hangs on it is rebuilt.
$(VENV)/pyvenv.cfg: FORCE
	$(eval fault := $(toolchain_fault))$(if $(fault),$(error $(fault)))
	@wanted=$$('$(PYTHON)' -c 'import sys; print(sys.base_prefix, sys.version)' && pwd); \
	base=$$('$(PYTHON)' -c 'import sys; print(sys._base_executable)'); \
	if [ "$$wanted" = "$$(cat $(VENV)/.made-for 2>/dev/null)" ] && $(PY) -c '' 2>/dev/null; then exit 0; fi; \
	set -e; \
	echo "making $(VENV) with $$base"; \
	rm -rf $(VENV); \
	"$$base" -m venv $(VENV); \
	$(PY) -m pip install --quiet --upgrade 'pip>=25.1' '$(MATURIN)'; \
	echo "$$wanted" >$(VENV)/.made-for; \
	touch $@

$(WHEEL): $(VENV)/pyvenv.cfg $(SOURCES)
	rm -f $(DIST)/popsteer-*.whl
	$(VENV)/bin/maturin build --release --interpreter $(PY) --out $(DIST)
	@touch $@

# The first line brings in a wheel whose version has not changed, the second what its extra or group needs. Modules are
# compiled when they are first imported, which few of them are.
$(VENV)/.lab $(VENV)/.yardsticks $(VENV)/.fuzz $(VENV)/.audit $(VENV)/.mutants $(VENV)/.dev: $(WHEEL)
	$(PY) -m pip install --quiet --no-compile --force-reinstall --no-deps $(DIST)/popsteer-*.whl
	$(PY) -m pip install --quiet --no-compile $(if $(filter .lab,$(@F)),"$$(echo $(DIST)/popsteer-*.whl)[lab]",$(DIST)/popsteer-*.whl --group $(patsubst .%,%,$(@F)))
	@touch $@
