#!/bin/sh
# Line coverage of the core and the simulations by all tests together: `make coverage` runs it.
#
#     tests/coverage.sh OUT PYTHON [pytest's options]
#
# The extension is built with LLVM's counters and put, with the Python sources, on PYTHONPATH; every
# process that loads it adds its counts to a few files, which the report sums up.
set -eu
out=$1 python=$2
shift 2
if ! cargo llvm-cov --version >/dev/null 2>&1; then
	echo "cargo-llvm-cov not found: cargo install cargo-llvm-cov, rustup component add llvm-tools" >&2
	exit 2
fi
rm -rf "$out"
mkdir -p "$out/python"
export CARGO_TARGET_DIR="$PWD/target/coverage"
eval "$(cargo llvm-cov show-env --sh 2>/dev/null)"
export LLVM_PROFILE_FILE="$CARGO_TARGET_DIR/popsteer-%4m.profraw"
rm -f "$CARGO_TARGET_DIR"/*.profraw

# Optimised a little: unoptimised, the simulations that the Python tests drive take ten times as long.
export CARGO_PROFILE_DEV_OPT_LEVEL=1

cargo test --locked --package popsteer-core --package popsteer-sim
cargo build --locked --package popsteer-py
cp -r python/popsteer "$out/python/popsteer"
rm -f "$out"/python/popsteer/_core*.so
suffix=$("$python" -c 'import sysconfig; print(sysconfig.get_config_var("EXT_SUFFIX"))')
library=$(ls "$CARGO_TARGET_DIR"/debug/lib_core.so "$CARGO_TARGET_DIR"/debug/lib_core.dylib 2>/dev/null)
cp "$library" "$out/python/popsteer/_core$suffix"
PYTHONPATH="$PWD/$out/python" "$python" -m pytest -q --numprocesses auto --maxprocesses 8 --dist worksteal "$@" ||
	echo "some tests failed; their lines count all the same" >&2

report() {
	cargo llvm-cov report --ignore-filename-regex '(rust/(py|c|wasm)|benches|tests)/' "$@"
}
report --html --output-dir "$out"
report --summary-only | tee "$out/summary.txt"
report --show-missing-lines --summary-only | sed -n '/^Uncovered Lines/,$p' >"$out/missing.txt"
echo "Uncovered lines: $out/missing.txt; line by line: $out/html/index.html"
