# Everything happens in one virtual environment, .venv, made and filled as far as a target needs it. It is of PYTHON, or
# else of the first Python of the machine that is new enough.
PYTHON ?=
JOBS ?= $(shell nproc 2>/dev/null || echo 2)

VENV := .venv
BIN := $(VENV)/bin
# $(call pip,TITLE,ARGUMENTS): pip install behind a line of progress
pip = $(BIN)/python make/progress.py "$(1)" $(BIN)/python -m pip --disable-pip-version-check install $(2)
# $(call install,TITLE,TABLE): the requirements of a table of pyproject.toml; no pipe, which would hide a failure
define install
	@$(BIN)/python -c 'import tomllib; print(*tomllib.load(open("pyproject.toml", "rb"))$(2), sep="\n")' > $(VENV)/wanted.txt
	@$(call pip,$(1),--no-compile -r $(VENV)/wanted.txt)
endef

# $(call extra,NAME): the requirements of an extra of pyproject.toml
extra = "$$($(BIN)/python -c 'import tomllib; print(*tomllib.load(open("pyproject.toml", "rb"))["project"]["optional-dependencies"]["$(1)"])')"

# Warnings of our compilers are errors; those of Zig's are shown.
WERROR = $(if $(shell grep -s ziglang $(BIN)/c++),OFF,ON)

# all that the wheel is made of
SOURCES := $(shell find src core/include core/src bindings robots missions data firmware/mavlink firmware/app/vehicle/parameters.hpp CMakeLists.txt pyproject.toml \
  -type f -not -name '*.pyc' -not -name '*.so')

MACHINE_PATH := $(PATH)
export PATH := $(abspath $(BIN)):$(PATH)
export CMAKE_BUILD_PARALLEL_LEVEL ?= $(JOBS)
.NOTPARALLEL:

.PHONY: help
help: ## this list
	@grep -hE '^[a-z-]+:.*## ' Makefile | sed -E 's/^([a-z-]+):.*## /  make \1\t/' | expand -t 26

# --- the environment: what is installed is remembered by a stamp; messages go to stderr, results alone to stdout

# The check of the machine runs each time; it changes the stamp only if it had to make the environment.
$(VENV)/.python: FORCE
	@PATH="$(MACHINE_PATH)" sh make/environment.sh $(VENV) "$(PYTHON)"
.PHONY: FORCE

# The rebuild on import runs `cmake` from PATH: the .pth file lets this Python find its own one, activated or not.
# With LOCK=requirements.lock all packages come first, of the versions and hashes there; what follows finds them installed.
LOCK ?=
$(VENV)/.tools: $(VENV)/.python pyproject.toml $(LOCK)
	$(if $(LOCK),@$(call pip,packages of $(LOCK),--no-compile --require-hashes -r $(LOCK)))
	$(call install,build tools,["build-system"]["requires"])
	@! grep -qs ziglang $(BIN)/c++ || $(call pip,compiler of Zig,--no-compile $(call extra,fmu))
	@echo 'import os, sys; os.environ["PATH"] = os.path.join(sys.prefix, "bin") + os.pathsep + os.environ.get("PATH", "")' \
	  > "$$($(BIN)/python -c 'import sysconfig; print(sysconfig.get_path("purelib"))')/_tools_on_path.pth"
	@touch $@

# hypertuna is installed either as a wheel, to use it: compiled to bytecode, nothing checked on import; or editable, to
# work on it: rebuilt on import. Each removes the stamp of the other, and both share one build folder.
$(VENV)/.wheel: $(VENV)/.tools $(SOURCES)
	@rm -f $(VENV)/.installed
	@$(call pip,hypertuna,--verbose --no-build-isolation --config-settings=build-dir='build/{wheel_tag}' \
	  --config-settings=cmake.define.HYPERTUNA_LOCAL=ON .)
	@touch $@

$(VENV)/.installed: $(VENV)/.tools
	@rm -f $(VENV)/.wheel
	@$(call pip,hypertuna (editable),--verbose --no-compile --no-build-isolation --editable .)
	@touch $@

$(VENV)/.installed-%: $(VENV)/.tools | $(VENV)/.installed
	$(call install,packages of the extra '$*',["project"]["optional-dependencies"]["$*"])
	@touch $@

# For the checker of its environments. PyTorch from PyPI brings 5 GB; Debian's, of the same Python, takes 0.6.
$(VENV)/.installed-sb3: $(VENV)/.installed-test
	@$(call pip,Stable-Baselines3,--no-compile --no-deps $(call extra,sb3))
	@ln -sfn /usr/lib/python3/dist-packages/torch "$$($(BIN)/python -c 'import sysconfig; print(sysconfig.get_path("purelib"))')/torch"
	@$(BIN)/python -c 'import stable_baselines3' || { echo 'Stable-Baselines3 needs PyTorch: `apt-get install python3-torch`' >&2; exit 1; }
	@touch $@

.PRECIOUS: $(VENV)/.installed-%

# --- what to run

.PHONY: dev demo test mutants test-cpp test-studio hosts fuzz-image mujoco-plugin test-sanitized test-hosts-sanitized test-firmware-sanitized test-python test-slow test-processors test-fe test-firmware bench bench-json firmware firmware-teensy lock system-deps lint format stub
.PHONY: docs clean
dev: $(VENV)/.installed $(VENV)/.installed-test $(VENV)/.installed-lint ## environment for work on the project

demo: $(VENV)/.wheel ## install hypertuna and write a page with what it computes: demo/index.html
	@$(BIN)/hypertuna paper -o demo
	@echo; echo 'Go on with:'
	@echo '  . $(VENV)/bin/activate'
	@echo '  hypertuna swim --robot hypertuna --gait unoptimised-max'
	@echo '  hypertuna studio'
	@echo '  hypertuna robot new myfish.toml --links 3 --length 0.3 --mass 0.85'

# .ci/run leaves these C++ tests out: it runs them with the sanitizers meanwhile
CPP_TESTS ?= test-cpp
test: $(CPP_TESTS) hosts mujoco-plugin fmu test-python ## tests of C++ and Python but the slow ones: about 20 minutes on two cores

# $(call run-cpp-tests,FOLDER,OPTIONS): build and run core/tests, or only TEST
define run-cpp-tests
	@cmake -S . -B $(1) -G Ninja -DHYPERTUNA_BUILD_TESTS=ON -DHYPERTUNA_WERROR=$(WERROR) $(2) > /dev/null
	@cmake --build $(1) $(if $(TEST),--target $(TEST))
	@ctest --test-dir $(1) --output-on-failure --no-tests=error -j $(JOBS) $(if $(TEST),-R '^$(TEST)$$')
endef

test-cpp: $(VENV)/.tools ## C++ tests alone, or one: make test-cpp TEST=name
	$(call run-cpp-tests,build/cpp)

hosts: $(VENV)/.tools ## C interface of hosts/hypertuna.h as a library: build/hosts/libhypertuna.so
	@cmake -S . -B build/hosts -G Ninja -DHYPERTUNA_BUILD_HOSTS=ON -DHYPERTUNA_WERROR=$(WERROR) > /dev/null
	@cmake --build build/hosts --target hypertuna >&2

fuzz-image: hosts ## program that feeds damaged images to the C interface, with sanitizers: build/hosts/fuzz_image
	@cmake --build build/hosts >&2

mujoco-plugin: $(VENV)/.installed-test ## water for MuJoCo as an engine plugin: build/mujoco/libhypertuna_mujoco.so
	@cmake -S . -B build/mujoco -G Ninja -DHYPERTUNA_WERROR=$(WERROR) -DHYPERTUNA_MUJOCO="$$($(BIN)/python -c \
	  'import importlib.util as u; print(u.find_spec("mujoco").submodule_search_locations[0])')" > /dev/null
	@cmake --build build/mujoco >&2

# The same interface for browsers. Neither paths nor times go into it: built anew anywhere it has the same bytes.
WASM := -target wasm32-wasi -mexec-model=reactor -msimd128
EXPORTS = malloc free $(sort $(shell sed -n 's/^HT_API [a-z_ *]*[ *]\(ht_[a-z_]*\)[^a-z_].*/\1/p' hosts/hypertuna.h))
ZIG = ZIG_GLOBAL_CACHE_DIR=$(abspath build/zig) ZIG_LOCAL_CACHE_DIR=$(abspath build/zig) $(BIN)/python -m ziglang c++ $(WASM)

# Binaries of FMUs, one of each version of the standard a platform: build/fmu/PLATFORM/fmi2.so and the like.
# Others: aarch64-linux, x86_64-windows, x86_64-darwin, aarch64-darwin.
FMU_PLATFORMS ?= $(shell uname -m)-linux
fmu-target = $(subst darwin,macos,$(1:%-linux=%-linux-gnu.2.17)$(if $(filter %-windows,$(1)),-gnu))
fmu-suffix = $(if $(filter %-windows,$(1)),.dll,$(if $(filter %-darwin,$(1)),.dylib,.so))
FMU_ZIG = ZIG_GLOBAL_CACHE_DIR=$(abspath build/zig) ZIG_LOCAL_CACHE_DIR=$(abspath build/zig) $(BIN)/python -m ziglang c++

.PHONY: fmu
fmu: $(foreach p,$(FMU_PLATFORMS),$(foreach v,2 3,build/fmu/$(p)/fmi$(v)$(call fmu-suffix,$(p)))) ## binaries of FMUs by ziglang, in build/fmu: of this machine, or of FMU_PLATFORMS

# $(call fmu-rules,PLATFORM)
define fmu-rules
build/fmu/$(1)/objects/%.o: LEVEL = s
build/fmu/$(1)/objects/device_short.o: LEVEL = 3
build/fmu/$(1)/objects/%.o: hosts/%.cpp $(VENV)/.installed-fmu $(shell find core/include hosts -type f)
	@mkdir -p $$(@D)
	@$(FMU_ZIG) -target $(call fmu-target,$(1)) -std=c++20 -O$$(LEVEL) -g0 -DNDEBUG -DHYPERTUNA_SMALL -DHT_API= -fno-exceptions -fno-rtti \
	  -ffp-contract=off -fvisibility=hidden -fvisibility-inlines-hidden -ffunction-sections -fdata-sections -fPIC -Icore/include -c -o $$@ $$<
build/fmu/$(1)/fmi%$(call fmu-suffix,$(1)): $(patsubst %,build/fmu/$(1)/objects/%.o,device device_short device_long fmi%)
	@$(FMU_ZIG) -target $(call fmu-target,$(1)) -shared -s -Wl,--gc-sections $(if $(filter %-linux,$(1)),-Wl$(comma)--version-script=hosts/fmu.map) $$^ -o $$@
endef
comma := ,
.SECONDARY:
$(foreach p,$(FMU_PLATFORMS),$(eval $(call fmu-rules,$(p))))

.PHONY: studio-core
studio-core: build/studio/core.wasm ## C interface of hosts/hypertuna.h for browsers: build/studio/core.wasm

build/studio/core.wasm: $(patsubst %,build/studio/%.o,host twin_short twin_long kernels yielding)
	@$(ZIG) -s $(EXPORTS:%=-Wl,--export=%) $^ -o $@

build/studio/%.o: LEVEL = s
build/studio/twin_short.o: LEVEL = 3
build/studio/yielding.o: ARCH = -DHYPERTUNA_ARCH=portable_yielding
build/studio/%.o: $(VENV)/.installed-studio $(shell find core/include core/src hosts -type f)
	@mkdir -p $(@D)
	@$(ZIG) -std=c++20 -O$(LEVEL) -g0 -DHYPERTUNA_SMALL $(ARCH) -fno-exceptions -fno-rtti -ffp-contract=off -fvisibility=hidden -Icore/include -c -o $@ \
	  $(or $(wildcard hosts/$*.cpp),core/src/$*.cpp)

# The page of the studio, in one file. OpenBLAS and the kernels take the same way on every x86-64: the images are the
# same bytes. The pilot's curvature, of a settled turn, else differs in its last digits.
STUDIO := data/studio
SHIPPED := $(basename $(notdir $(wildcard robots/*.toml)))

.PHONY: studio
studio: studio-core $(VENV)/.installed studio/node_modules/.package-lock.json ## page of the studio: data/studio/studio.html
	@rm -rf build/studio/robots && mkdir -p build/studio/robots $(STUDIO)
	@for robot in $(SHIPPED); do OPENBLAS_CORETYPE=Prescott OMP_NUM_THREADS=1 HYPERTUNA_ISA=scalar \
	  $(BIN)/hypertuna robot image $$robot -o build/studio/robots/$$robot.robot > /dev/null || exit 1; done
	@$(BIN)/python make/interface.py > studio/interface.ts
	@cd studio && npm run --silent check >&2 && node build.mjs ../build/studio/core.wasm ../build/studio/robots ../$(STUDIO)
	@echo $(STUDIO)/studio.html

studio/node_modules/.package-lock.json: studio/package-lock.json
	@command -v npm > /dev/null || { echo 'npm is not installed: Node.js 20 or later brings it' >&2; exit 1; }
	@cd studio && npm ci --silent

test-studio: $(VENV)/.installed studio/node_modules/.package-lock.json ## tests of the studio's page in Chromium; pictures in build/studio/shots
	@command -v "$${CHROMIUM:-/usr/bin/chromium}" > /dev/null || \
	  { echo 'Chromium is not installed: `apt-get install chromium`, or CHROMIUM=/path/to/it' >&2; exit 1; }
	@node --test --test-concurrency=1 --test-reporter=spec studio/tests/*.test.mjs

test-sanitized: $(VENV)/.tools ## C++ tests of the core with the address and undefined-behavior sanitizers
	$(call run-cpp-tests,build/sanitized,-DHYPERTUNA_SANITIZE=ON)

# ASan must be loaded before Python, which leaks by its own lights.
test-hosts-sanitized: $(VENV)/.installed-test ## the same for the C interface, run from Python
	@cmake -S . -B build/hosts-sanitized -G Ninja -DHYPERTUNA_BUILD_HOSTS=ON -DHYPERTUNA_SANITIZE=ON > /dev/null
	@cmake --build build/hosts-sanitized --target hypertuna >&2
	@HYPERTUNA_HOSTS=build/hosts-sanitized LD_PRELOAD="$$(c++ -print-file-name=libasan.so)" ASAN_OPTIONS=detect_leaks=0 \
	  $(BIN)/python -m pytest -q tests/hosts/test_interface.py tests/hosts/test_device.py -k "not wasm"

# One more worker than processors: some tests wait for clocks and processes.
WORKERS ?= $(shell expr $(JOBS) + 1)
PYTEST = $(BIN)/python -m pytest -q -n $(WORKERS) --dist worksteal
test-python: $(VENV)/.installed-test ## Python tests alone
	@$(PYTEST) -m 'not (slow or fe)'

test-slow: $(VENV)/.installed-test fuzz-image ## the tests in tests/slow.txt, once `make test` has built what they run
	@$(PYTEST) -m 'slow and not fe'

# Pictures, tables and outputs of the pages where OpenBLAS, NumPy and our kernels take other ways than on this processor:
# those of 2004, and of 2013 where this one has more. Bits of images, firmware and runs: tests/hosts/test_processors.py.
# Side by side, each in one process: the pages share what is computed for the first of them.
GOLDENS = $(BIN)/python -m pytest -q -p no:cacheprovider tests/test_docs.py -k program_s
test-processors: $(VENV)/.installed-test ## goldens of the documentation as on other processors
	@OPENBLAS_CORETYPE=Prescott NPY_DISABLE_CPU_FEATURES="X86_V3 X86_V4 AVX512_ICL" HYPERTUNA_ISA=scalar $(GOLDENS) & \
	  first=$$!; status=0; \
	  ! grep -qw avx512f /proc/cpuinfo || OPENBLAS_CORETYPE=Haswell NPY_DISABLE_CPU_FEATURES="X86_V4 AVX512_ICL" $(GOLDENS) || status=$$?; \
	  wait $$first && exit $$status

# A file stays with one process: what its tests share is solved once.
FE_TESTS ?= fe
test-fe: $(VENV)/.installed-test $(VENV)/.installed-fe ## tests with finite elements; installs the extra fe
	@$(BIN)/python -m pytest -q -n $(JOBS) --dist loadfile -m '$(FE_TESTS)' $$(grep -rl --include='test_*.py' 'mark\.fe$$' tests validation)

ROOM ?= all
SEED ?= 1
mutants: $(VENV)/.installed-test ## do the tests of ROOM (or all) notice ten changes of its code, drawn by SEED?
	@$(BIN)/python validation/mutants/judge.py $(ROOM) --seed $(SEED)

bench: $(VENV)/.installed-bench build/bench ## speed against the peers, as tables
	@$(BIN)/python benchmarks/run.py

bench-json: $(VENV)/.installed-bench build/bench ## the same as one JSON object
	@$(BIN)/python benchmarks/run.py --json

.PHONY: build/bench
build/bench: $(VENV)/.tools
	@cmake -S . -B $@ -G Ninja -DHYPERTUNA_BUILD_BENCH=ON > /dev/null
	@cmake --build $@ >&2

# $(call build-firmware,FOLDER,TARGET,OPTIONS)
define build-firmware
	@cmake -S . -B $(1) -G Ninja -DHYPERTUNA_BUILD_FIRMWARE=ON -DHYPERTUNA_WERROR=$(WERROR) -DHYPERTUNA_ROBOT="$(ROBOT)" $(3) > /dev/null
	@cmake --build $(1) --target $(2) >&2
endef
ROBOT ?= hypertuna

firmware: firmware-pc ## firmware of a robot, ROBOT=name, for this machine and the emulated Cortex-M7, with its sizes
	@command -v arm-none-eabi-g++ > /dev/null || \
	  { echo 'arm-none-eabi-g++ is not installed: run `make system-deps`' >&2; exit 1; }
	$(call build-firmware,build/firmware/mps2,qemu_mps2,-DCMAKE_TOOLCHAIN_FILE=$(abspath firmware/boards/qemu_mps2/toolchain.cmake))
	@arm-none-eabi-size "build/firmware/$(ROBOT)-qemu_mps2.elf"

.PHONY: firmware-pc
firmware-pc: $(VENV)/.installed-radio ## the same for this machine alone
	$(call build-firmware,build/firmware/pc,pc)

# The sources of the board's core and libraries are other people's: they lie beside the repository, if at all.
TEENSY ?= ../shared/teensy/sources.tar.xz
TEENSY_TEXT := 150000

firmware-teensy: $(VENV)/.installed-radio ## firmware for a Teensy 4.1 with its real core and libraries, TEENSY=archive; skipped without them
	@if [ ! -f "$(TEENSY)" ]; then echo 'skipped: firmware-teensy needs the sources of Teensyduino, $(TEENSY)'; \
	  elif ! command -v arm-none-eabi-g++ > /dev/null; then echo 'skipped: firmware-teensy needs arm-none-eabi-g++'; \
	  else $(MAKE) --no-print-directory build/firmware/$(ROBOT)-teensy41.elf; fi

.PHONY: build/firmware/$(ROBOT)-teensy41.elf
build/firmware/$(ROBOT)-teensy41.elf: build/teensy/core/core_pins.h
	$(call build-firmware,build/firmware/teensy,teensy41,-DCMAKE_TOOLCHAIN_FILE=$(abspath firmware/boards/teensy41/toolchain.cmake) \
	  -DHYPERTUNA_TEENSY=$(abspath build/teensy))
	@arm-none-eabi-size "$@"
	@arm-none-eabi-size "$@" | awk 'NR == 2 && $$1 > $(TEENSY_TEXT) { print "text is above $(TEENSY_TEXT) bytes"; exit 1 }'

build/teensy/core/core_pins.h: $(TEENSY)
	@mkdir -p build && tar -C build -xmf "$<"

test-firmware: firmware-pc ## C++ tests of the firmware; those that run it, on the emulated Cortex-M7 too, are in test-python
	@cmake --build build/firmware/pc >&2
	@ctest --test-dir build/firmware/pc --output-on-failure --no-tests=error -j $(JOBS)

test-firmware-sanitized: $(VENV)/.installed-test ## the same, and the radio in lock-step, with the sanitizers of test-sanitized
	@cmake -S . -B build/firmware/sanitized -G Ninja -DHYPERTUNA_BUILD_FIRMWARE=ON -DHYPERTUNA_SANITIZE=ON -DHYPERTUNA_WERROR=$(WERROR) > /dev/null
	@cmake --build build/firmware/sanitized --target firmware/tests/all >&2
	@ctest --test-dir build/firmware/sanitized --output-on-failure --no-tests=error -j $(JOBS)
	@HYPERTUNA_BENCH=build/firmware/sanitized $(BIN)/python -m pytest -q tests/radio/test_radio_cpp.py

lock: $(VENV)/.tools ## requirements.lock anew: version and hash of each package that CI installs, for this Python
	@$(BIN)/python make/lock.py requirements.lock

system-deps: ## Arm compiler and emulator by apt, for firmware: 430 MB to fetch, 2.6 GB on disk; as root
	apt-get update -qq
	apt-get install -y -qq --no-install-recommends gcc-arm-none-eabi libnewlib-arm-none-eabi \
	  libstdc++-arm-none-eabi-newlib qemu-system-arm

CPP = $(shell find core bindings hosts benchmarks validation/hosts firmware/app firmware/boards firmware/tests -name '*.[ch]pp' -not -path '*/arduino/*')

# .ci/run leaves them out: they are among its tests
SIZES ?= tests/test_size.py
lint: $(VENV)/.installed-lint $(VENV)/.installed-test ## ruff, mypy, import-linter, clang-format, sizes of modules
	@ruff check
	@ruff format --check
	@mypy
	@lint-imports
	@clang-format --dry-run --Werror $(CPP)
	@$(if $(SIZES),$(BIN)/python -m pytest -q $(SIZES))

format: $(VENV)/.installed-lint ## put all sources into the common format
	@ruff check --fix --exit-zero
	@ruff format
	@clang-format -i $(CPP)

stub: $(VENV)/.installed-lint ## write src/hypertuna/_core.pyi anew from the extension module
	@$(BIN)/python -m nanobind.stubgen --quiet -m hypertuna._core -o src/hypertuna/_core.pyi
	@ruff format --quiet src/hypertuna/_core.pyi

docs: $(VENV)/.installed-docs ## docs/_build/index.html
	@sphinx-build --fail-on-warning --keep-going --quiet docs docs/_build
	@$(BIN)/python docs/check_site.py docs/_build
	@echo docs/_build/index.html

clean: ## remove everything that was made here
	rm -rf $(VENV) build demo dist docs/_build .hypothesis .mypy_cache .pytest_cache .ruff_cache
	find . -name __pycache__ -type d -prune -exec rm -rf {} +
