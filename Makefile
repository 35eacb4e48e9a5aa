# Two commands: `make run` serves on http://127.0.0.1:8080, `make test` runs every check. Both need a Rust toolchain, Node.js and make.

CARGO ?= cargo
NPM ?= npm
NPM_CI = $(NPM) ci --no-audit --no-fund --silent

.PHONY: run viewer test format lint unit browser soak bench peers image pictures fuzz clean

run: viewer
	$(CARGO) run --release -- serve

viewer: web/dist/index.html

web/node_modules/.package-lock.json: web/package.json web/package-lock.json
	$(NPM_CI) --prefix web
	@touch $@

web/dist/index.html: web/node_modules/.package-lock.json web/index.html web/play.html web/vite.config.ts $(shell find web/src web/public -type f)
	$(NPM) --prefix web run --silent build

test: format lint unit browser

format:
	$(CARGO) fmt --check

lint: viewer
	$(CARGO) clippy --all-targets --all-features -- -D warnings
	$(CARGO) clippy --lib --bins -- -D warnings
	$(CARGO) check --lib --no-default-features
	RUSTDOCFLAGS="-D warnings" $(CARGO) doc --no-deps --lib --all-features
	$(NPM) --prefix web run --silent check

# Unit, integration, contract and documentation tests.
unit: viewer
	$(CARGO) test --all-features
	$(NPM) --prefix web test --silent

# The viewer in a real browser against the real program.
browser: viewer
	$(CARGO) build --release
	TERRANE_BIN="$${CARGO_TARGET_DIR:-$(CURDIR)/target}/release/terrane" tests/browser/run
	TERRANE_BIN="$${CARGO_TARGET_DIR:-$(CURDIR)/target}/release/terrane" tests/clients/gdal

# The long forms: hours of what `make test` does in seconds.
soak:
	TERRANE_KILLS=500 $(CARGO) test --release --test it -- program::a_killed_server
	TERRANE_LEAVERS=1000 TERRANE_HOSTILE=200 $(CARGO) test --release --test it -- --include-ignored --nocapture --test-threads=1 load:: hostile::
	TERRANE_KILLS=100 $(CARGO) test --release --test it -- pyramid::a_killed_export
	TERRANE_PROGRAMMES=100000 $(CARGO) test --release --test it -- properties::
	$(CARGO) test --release --test it -- --ignored --nocapture costs::costs_are_predicted
	$(CARGO) test --release --test it -- --ignored --nocapture levels::
	TERRANE_BIN="$${CARGO_TARGET_DIR:-$(CURDIR)/target}/release/terrane" TERRANE_EXAMPLES=500 tests/contract/run

# The pictures of docs/programmes.md.
pictures: viewer
	$(CARGO) build --release
	docs/pictures/draw "$${CARGO_TARGET_DIR:-$(CURDIR)/target}/release/terrane"

FUZZING = -timeout=20 -max_total_time=$${TERRANE_FUZZ_SECONDS:-1800}

# Needs cargo-fuzz. What is found worth keeping stands in fuzz/corpus, which `make test` replays.
fuzz:
	RUSTC_BOOTSTRAP=1 $(CARGO) fuzz run programme -- -dict=fuzz/programme.dict -max_len=2048 $(FUZZING)
	RUSTC_BOOTSTRAP=1 $(CARGO) fuzz run features -- -dict=fuzz/features.dict -max_len=4096 $(FUZZING)
	RUSTC_BOOTSTRAP=1 $(CARGO) fuzz run world -- -dict=fuzz/features.dict -max_len=4096 $(FUZZING)
	RUSTC_BOOTSTRAP=1 $(CARGO) fuzz run request -- -dict=fuzz/request.dict -max_len=1024 $(FUZZING)
	RUSTC_BOOTSTRAP=1 $(CARGO) fuzz run config -- -max_len=2048 $(FUZZING)
	RUSTC_BOOTSTRAP=1 $(CARGO) fuzz run part -- -max_len=2048 $(FUZZING)

bench: viewer
	$(CARGO) bench

# A cached tile beside nginx and martin. Needs wrk, and those that are to be measured.
peers: viewer
	$(CARGO) build --release
	benches/peers "$${CARGO_TARGET_DIR:-$(CURDIR)/target}/release/terrane"

# The program without libraries to load, and the test of the image that holds it. Needs buildah.
image: viewer
	RUSTFLAGS="-C target-feature=+crt-static" $(CARGO) build --release --locked --features disk --target "$$(rustc --print host-tuple)"
	TERRANE_BIN="$${CARGO_TARGET_DIR:-$(CURDIR)/target}/$$(rustc --print host-tuple)/release/terrane" docker/test

clean:
	$(CARGO) clean
	rm -rf web/node_modules web/dist/assets web/dist/index.html tests/browser/node_modules tests/browser/out
