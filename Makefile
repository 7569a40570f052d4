# The words people type. The build itself is CMake's; these only call it in the right order.
#
#   make demo            install what is missing, build, run the main job, say where the pictures are
#   make check           install what is missing, build everything, run every test, then most again under sanitizers
#   make editor          build the page of pith edit into build/editor (installs nodejs and npm)
#   make check-editor    its tests in a real browser (installs chromium); part of make check
#   make bench-editor    measure it in a real browser
#   make fuzz            feed the readers damaged bytes (needs clang)
#   make bench           measure, and keep the results under bench/results
#   make gallery         make the pictures of docs/gallery again
#   make format          put every C file into the house's layout (needs clang-format)
#   make clean           remove what was built
JOBS := $(shell nproc 2>/dev/null || echo 2)
BUILD := build
SANITIZED := build-sanitize

.PHONY: demo check check-sanitize editor check-editor bench-editor fuzz bench gallery format clean

demo: $(BUILD)/pith-configured
	@tools/install-packages demo
	@cmake --build $(BUILD) --target pith pith-tetgen -j $(JOBS) -- --no-print-directory -s
	@$(BUILD)/pith demo

# Configured once; CMake looks after itself from then on.
$(BUILD)/pith-configured:
	@tools/install-packages demo
	@cmake -G "Unix Makefiles" -S . -B $(BUILD) -DPITH_TESTS=OFF -Wno-dev --log-level=WARNING >/dev/null
	@touch $@

check:
	@tools/install-packages check
	@cmake -G "Unix Makefiles" -S . -B $(BUILD) -DPITH_TESTS=ON -Wno-dev --log-level=WARNING >/dev/null
	@cmake --build $(BUILD) -j $(JOBS) -- --no-print-directory -s
	@cd $(BUILD) && ctest --output-on-failure --parallel 2
	@$(MAKE) --no-print-directory check-editor
	@$(MAKE) --no-print-directory check-sanitize

# The page: its packages are installed once and again when their list changes, then everything is bundled.
editor/node_modules/.installed: editor/package.json editor/package-lock.json
	@tools/install-packages editor
	@cd editor && npm ci --ignore-scripts --no-audit --no-fund --loglevel=error
	@touch $@

$(BUILD)/editor/index.html: editor/node_modules/.installed $(shell find editor/src editor/assets editor/index.html editor/build.mjs -type f)
	@cd editor && node_modules/.bin/tsc --noEmit
	@node editor/build.mjs $(BUILD)/editor

editor: $(BUILD)/editor/index.html

# The page's tests: the real program, a real browser.
check-editor: editor $(BUILD)/pith-configured
	@tools/install-packages browser
	@cmake --build $(BUILD) --target pith pith-tetgen -j $(JOBS) -- --no-print-directory -s
	@cd editor && node --test $$(ls test/*.test.mjs)

bench-editor: editor $(BUILD)/pith-configured
	@tools/install-packages browser
	@cmake --build $(BUILD) --target pith pith-tetgen -j $(JOBS) -- --no-print-directory -s
	@mkdir -p bench/results
	@node editor/bench/bench.mjs | tee bench/results/editor.txt

# Everything but the longest checks, under AddressSanitizer and UndefinedBehaviorSanitizer.
check-sanitize:
	@tools/install-packages check
	@cmake -G "Unix Makefiles" -S . -B $(SANITIZED) -DPITH_TESTS=ON -DCMAKE_BUILD_TYPE=RelWithDebInfo -DPITH_SANITIZE=address,undefined \
	    -Wno-dev --log-level=WARNING >/dev/null
	@cmake --build $(SANITIZED) -j $(JOBS) -- --no-print-directory -s
	@cd $(SANITIZED) && ASAN_OPTIONS=detect_leaks=1 OMP_NUM_THREADS=2 ctest --output-on-failure --parallel 2 \
	    -E 'shipped|docs|first_cut'

# The fuzz targets of the readers, a short run each: make fuzz, or make fuzz SECONDS=3600. Needs clang.
SECONDS := 20
fuzz:
	@cmake -S . -B build-fuzz -DCMAKE_C_COMPILER=clang -DCMAKE_CXX_COMPILER=clang++ -DPITH_FUZZ=ON -DPITH_TESTS=OFF \
	    -DCMAKE_BUILD_TYPE=RelWithDebInfo -DPITH_SANITIZE=address,undefined,fuzzer-no-link -Wno-dev --log-level=WARNING >/dev/null
	@cmake --build build-fuzz -j $(JOBS) -- --no-print-directory -s
	@for target in build-fuzz/fuzz/fuzz_*; do echo $$target; $$target -max_total_time=$(SECONDS) -verbosity=0 || exit 1; done

bench: $(BUILD)/pith-configured
	@cmake --build $(BUILD) --target pith pith-tetgen -j $(JOBS) -- --no-print-directory -s
	@mkdir -p bench/results
	$(BUILD)/pith bench lapped --csv > bench/results/lapped.csv
	$(BUILD)/pith bench lapped --curve --csv > bench/results/lapped_curve.csv
	$(BUILD)/pith bench fields --json > bench/results/fields.json
	$(BUILD)/pith bench render --json > bench/results/render.json
	$(BUILD)/pith bench cut --csv > bench/results/cut.csv
	$(BUILD)/pith bench cut --curve --csv > bench/results/cut_curve.csv
	$(BUILD)/pith bench layers --csv > bench/results/layers.csv
	$(BUILD)/pith bench blend --csv > bench/results/blend.csv
	$(BUILD)/pith bench procedural --csv > bench/results/procedural.csv
	$(BUILD)/pith bench volume --json > bench/results/volume.json
	$(BUILD)/pith bench atlas --json > bench/results/atlas.json
	$(BUILD)/pith bench lines --json > bench/results/lines.json
	$(BUILD)/pith bench diffusion --json > bench/results/diffusion.json
	$(BUILD)/pith bench sketch --json > bench/results/sketch.json
	$(BUILD)/pith bench sketch_surface --json > bench/results/sketch_surface.json
	$(BUILD)/pith bench methods --picture docs/gallery/diffusion-methods.png --json > bench/results/methods.json

gallery: editor $(BUILD)/pith-configured
	@tools/install-packages browser
	@cmake --build $(BUILD) --target pith pith-tetgen -j $(JOBS) -- --no-print-directory -s
	@tools/make-gallery $(BUILD)/pith docs/gallery
	@node editor/bench/pictures.mjs docs/editor

format:
	@git ls-files '*.c' '*.h' | xargs clang-format -i

clean:
	@rm -rf $(BUILD) $(SANITIZED) build-fuzz out
