# Everything sets itself up in .venv; only Python 3.11 or later and a C compiler are needed.
PYTHON ?= python3
BIN := .venv/bin
# What calls every compiled function, and readers that are fed damaged files: about three minutes under the sanitizers.
COMPILED := tests/native tests/geometry tests/capture tests/fuzz/test_captures.py tests/fuzz/test_properties.py tests/matching \
	tests/tracking/test_block_cholesky.py tests/tracking/test_detail.py tests/tracking/test_system.py \
	tests/synthesis/test_advect.py tests/synthesis/test_atlas.py tests/synthesis/test_flow.py tests/synthesis/test_texels.py \
	tests/playback/test_render.py
SOURCES := pyproject.toml setup.py $(wildcard native/*.c native/*.h)

.PHONY: demo test tools lint sanitize fuzz clean

demo: .venv/ready  ## Build a motion graph of the package's own capture and open-able results in demo/
	$(BIN)/umg demo demo

test: .venv/ready-test  ## All tests; ends with what was skipped and why
	$(BIN)/python -m pytest $(TESTS)

tools: .tools/ready  ## Programs of others that tests open exports with: ffprobe, the Khronos glTF validator, Chromium

lint: .venv/ready-lint
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy

sanitize: .venv/ready-test  ## The tests of the compiled part under the address and undefined-behaviour sanitizers
	$(BIN)/python -m pip install --quiet 'setuptools>=77'
	rm -rf build/sanitize && mkdir -p build/sanitize
	cp -r pyproject.toml setup.py README.md LICENSE native unstructured_mg tests build/sanitize/
	rm -f build/sanitize/unstructured_mg/*.so
	cd build/sanitize && UMG_SANITIZE=1 ../../$(BIN)/python setup.py -q build_ext --inplace
	cd build/sanitize && LD_PRELOAD="$$($(CC) -print-file-name=libasan.so) $$($(CC) -print-file-name=libubsan.so)" \
		ASAN_OPTIONS=detect_leaks=0 PYTHONPATH=. ../../$(BIN)/python -m pytest -s -p no:cacheprovider $(or $(TESTS),$(COMPILED))

fuzz: .venv/ready-test  ## 10^5 damaged files and work folders; half an hour
	UMG_FUZZ_CASES=4000 $(BIN)/python -m pytest tests/fuzz

clean:
	rm -rf .venv .tools build demo unstructured_mg/*.so *.egg-info

.venv/python:
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || \
		{ echo "unstructured_mg needs Python 3.11 or later: make PYTHON=/path/to/python3.11"; exit 1; }
	$(PYTHON) -m venv .venv
	touch $@

.venv/ready: .venv/python $(SOURCES)
	$(BIN)/python -m pip install --quiet --editable .
	touch $@

.venv/ready-test: .venv/python $(SOURCES)
	$(BIN)/python -m pip install --quiet --editable '.[test]'
	touch $@ .venv/ready

.venv/ready-lint: .venv/ready
	$(BIN)/python -m pip install --quiet --editable '.[lint]'
	touch $@

.tools/ready:
	mkdir -p .tools
	command -v ffprobe >/dev/null || { apt-get update -q && apt-get install -y -q --no-install-recommends ffmpeg; }
	command -v npm >/dev/null || { apt-get update -q && apt-get install -y -q --no-install-recommends nodejs npm; }
	command -v chromium >/dev/null || { apt-get update -q && apt-get install -y -q --no-install-recommends chromium; }
	npm install --silent --no-audit --no-fund --prefix .tools gltf-validator@2.0.0-dev.3.10
	touch $@
