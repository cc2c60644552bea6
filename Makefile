# TrueNorth: every command of the project. `make help` lists them.
.DEFAULT_GOAL := help
.PHONY: help run test docs fmus fmus-all native bench bands soak reproduce lint format test-cpp test-python sanitize fuzz guided clean

PYTHON ?= python3
VENV   := .venv
BIN    := $(VENV)/bin
READY  := $(VENV)/.ready
JOBS   ?= 2
# A file of versions for the environment, such as requirements.lock; without one, the newest that pyproject.toml allows.
LOCK   ?=
PIP    := $(BIN)/python -m pip install --quiet --disable-pip-version-check $(if $(LOCK),--constraint $(LOCK))

# There are also macos-x86_64 and macos-aarch64.
PLATFORMS ?= linux64 linux-aarch64 win64
ZIG       := ziglang==0.17.1

# Tools of the environment first (cmake, ninja, clang-tidy), whatever the machine has besides.
export PATH := $(CURDIR)/$(BIN):$(PATH)

CPP_SOURCES  = $(shell git ls-files 'fmu_src/*.cpp' 'tests/cpp/*.cpp' 'tests/fuzz/*.cpp')
CPP_FILES    = $(CPP_SOURCES) $(shell git ls-files 'fmu_src/*.hpp' 'tests/cpp/*.hpp' 'tests/fuzz/*.hpp')

help:  ## List the commands
	@awk -F ':.*## ' '/^[a-z-]+:.*## / { printf "  make %-12s %s\n", $$1, $$2 }' $(MAKEFILE_LIST)

# $(call configure,<preset>,<more variables>): says nothing unless it fails.
define configure
	@mkdir -p build
	@cmake --preset $(1) -DPython_EXECUTABLE=$(CURDIR)/$(BIN)/python $(2) > build/configure.log 2>&1 \
	    || { cat build/configure.log; exit 1; }
endef

run: $(READY)  ## Align the swaying ship, print the verdict and where the report lies
	@echo "== Building its FMUs"
	$(call configure,native)
	@cmake --build --preset native --target TruthPlant_fmu AlignmentFilter_fmu truenorth_runner --parallel $(JOBS)
	@truenorth run swaying_ship --output build/reports/swaying_ship

test: lint test-cpp test-python  ## All set-up, then every check: lint, types, C++, Python, FMUs

$(READY): pyproject.toml
	@echo "== Environment: $(VENV)"
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 10) and "TrueNorth needs Python >= 3.10, found " + sys.version)'
	@test -x $(BIN)/python || $(PYTHON) -m venv $(VENV)
	@$(PIP) 'scikit-build-core>=0.10'
	@$(PIP) --no-build-isolation --config-settings=wheel.cmake=false --editable '.[dev]'
	@touch $@

docs: $(READY)  ## Build the site of the pages, for reading offline, into build/site
	@echo "== Building the site"
	@rm -rf build/site
	@python -m sphinx --quiet --fail-on-warning --keep-going --fresh-env -d build/doctrees -c docs/site . build/site

fmus: $(READY)  ## Build the FMUs into build/fmus
	@echo "== Building the FMUs"
	$(call configure,native)
	@cmake --build --preset native --target fmus --parallel $(JOBS)

fmus-all: $(READY)  ## Build the FMUs for Linux (x86-64, aarch64) and Windows, all in one, into build/fmus-all (long)
	@$(BIN)/python -m pip install --quiet --disable-pip-version-check $(ZIG)
	@mkdir -p build
	@for platform in $(PLATFORMS); do echo "== Building the FMUs for $$platform"; \
	    { cmake --preset $$platform -DPython_EXECUTABLE=$(CURDIR)/$(BIN)/python > build/configure.log 2>&1 \
	        || { cat build/configure.log; false; }; } \
	    && cmake --build --preset $$platform --parallel $(JOBS) || exit 1; done
	@cd build/platforms/$(firstword $(PLATFORMS))/fmus && for fmu in *.fmu fmi3/*.fmu; do \
	    PYTHONPATH=$(CURDIR) python -B $(CURDIR)/modelDescription/package.py join $(CURDIR)/build/fmus-all/$$fmu \
	        $(PLATFORMS:%=$(CURDIR)/build/platforms/%/fmus/$$fmu) || exit 1; done
	@cp -R $(PLATFORMS:%=build/platforms/%/fmus/runner) build/fmus-all

native: fmus  ## Build everything: FMUs, C++ tests and benchmark
	$(call configure,native,-DTRUENORTH_TESTS=ON $(PEERS:%=-DTRUENORTH_PEERS=$(abspath $(PEERS))))
	@cmake --build --preset native --parallel $(JOBS)

lint: $(READY)  ## Formatting, clang-tidy, ruff, mypy
	@echo "== Lint: clang-format"
	@clang-format --dry-run --Werror $(CPP_FILES)
	@echo "== Lint: clang-tidy"
	@rm -rf build/lint
	$(call configure,lint)
	@cmake --build --preset lint > build/configure.log 2>&1 || { cat build/configure.log; exit 1; }
	@find build/lint/fmu_src -name '*.cxx' -not -path '*_table.dir/*' \
	    | xargs -P $(JOBS) -n 1 clang-tidy --quiet --checks=-bugprone-suspicious-include -p build/lint
	@echo "== Lint: ruff, mypy"
	@ruff check --quiet .
	@ruff format --check --quiet .
	@mypy

format: $(READY)  ## Reformat every source file
	@clang-format -i $(CPP_FILES)
	@ruff format .
	@ruff check --fix .

test-cpp: native  ## C++ tests
	@echo "== C++ tests"
	@ctest --preset native --parallel $(JOBS) --quiet \
	    || { ctest --preset native --rerun-failed --output-on-failure; exit 1; }

test-python: fmus  ## Python and FMU tests
	@echo "== Python and FMU tests"
	@python -m pytest -n $(JOBS) --dist worksteal

SANITIZED = $(SEED:%=-DFUZZ_SEED=%) $(CALLS:%=-DFUZZ_CALLS=%) $(STATES:%=-DFUZZ_STATES=%)

sanitize: $(READY)  ## C++ tests under the address, undefined-behaviour and thread sanitizers (long)
	$(call configure,sanitized,$(SANITIZED))
	@cmake --build --preset sanitized --parallel $(JOBS)
	@ctest --preset sanitized --parallel $(JOBS)
	$(call configure,tsan,$(SANITIZED))
	@cmake --build --preset tsan --parallel $(JOBS)
	@ctest --preset tsan

# What is told on the command line comes first: make fuzz CALLS=1000000 STATES=100000 SEED=7
fuzz: CALLS ?= 500000
fuzz: STATES ?= 20000
fuzz: SEED ?= 1
fuzz: $(READY)  ## Random calls and damaged states under the sanitizers (minutes; CALLS, STATES, SEED)
	$(call configure,sanitized,$(SANITIZED))
	@cmake --build --preset sanitized --target fuzz --parallel $(JOBS)
	@ctest --preset sanitized --label-regex fuzz --verbose --parallel $(JOBS)

# CLANG=clang++-14 where it is not called clang++.
CLANG ?= clang++
guided: SECONDS ?= 60
guided: $(READY)  ## The same, guided by libFuzzer to what they have not reached yet (SECONDS each; clang)
	$(call configure,guided,-DCMAKE_CXX_COMPILER=$(CLANG) -DFUZZ_SECONDS=$(SECONDS) $(SEED:%=-DFUZZ_SEED=%))
	@cmake --build --preset guided --parallel $(JOBS)
	@ctest --preset guided --parallel $(JOBS)

bench: native  ## Time per filter step, per FMI call, of the loop, and of a whole run (PEERS=folder: beside other libraries)
	@build/native/tests/cpp/bench_filter
	@$(if $(PEERS),build/native/tests/cpp/bench_peers)
	@build/native/tests/cpp/fmi/bench_fmi
	@python tests/cpp/benchmark/runner.py build/native/tests/cpp/fmi/libplain_loop.so
	@python -m sim_scenarios.benchmark

bands: fmus  ## Monte-Carlo check of the accuracy bands (ten minutes; SEEDS=10 for fewer runs)
	@truenorth bands $(if $(SEEDS),-n $(SEEDS)) --output build/reports/bands

soak: fmus  ## 24 h of every model with every corrector, simulated (hours; SEEDS=1 for a single run of each)
	@truenorth campaign soak $(if $(SEEDS),-n $(SEEDS)) --output build/reports/soak

reproduce: fmus  ## Build the FMUs twice from nothing, and hold them against each other byte by byte (long)
	@python -m pytest -q -m slow tests/fmus/test_determinism.py

clean:  ## Remove everything generated, the environment excepted
	@rm -rf build
