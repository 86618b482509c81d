#!/bin/sh
# Line coverage of the core and the simulations by all tests together: `make coverage` runs it.
#
#     tests/coverage.sh OUT PYTHON [pytest's options]
#
# The extension is built with LLVM's counters and put, with the Python sources, on PYTHONPATH; every
# process that loads it counts in a few shared files, which the report sums up.
set -eu
out=$1 python=$2
shift 2
if ! cargo llvm-cov --version >/dev/null 2>&1; then
	echo "cargo-llvm-cov not found: cargo install cargo-llvm-cov, rustup component add llvm-tools" >&2
	exit 2
fi
target=$PWD/target/coverage
# %c: counted in the file itself, so that a process that is killed has counted too.
export LLVM_PROFILE_FILE="$target/popsteer-%4m%c.profraw"

# Only what is measured is built with counters; what the Python tests build themselves is not.
with_counters() {
	(
		profile=$LLVM_PROFILE_FILE
		export CARGO_TARGET_DIR="$target" CARGO_PROFILE_RELEASE_LTO=off CARGO_PROFILE_RELEASE_CODEGEN_UNITS=16
		export RUSTFLAGS="-Cllvm-args=-runtime-counter-relocation"
		eval "$(cargo llvm-cov show-env --sh 2>/dev/null)"
		LLVM_PROFILE_FILE=$profile "$@"
	)
}

# What earlier runs built would be reported too, with nothing counted.
rm -rf "$out" "$target"
mkdir -p "$out/python"
with_counters cargo test --release --locked --package popsteer-core --package popsteer-core-tests --package popsteer-sim
with_counters cargo build --release --locked --package popsteer-py
cp -r python/popsteer "$out/python/popsteer"
rm -f "$out"/python/popsteer/_core*.so
suffix=$("$python" -c 'import sysconfig; print(sysconfig.get_config_var("EXT_SUFFIX"))')
for library in "$target"/release/lib_core.so "$target"/release/lib_core.dylib; do
	if [ -e "$library" ]; then cp "$library" "$out/python/popsteer/_core$suffix"; fi
done
PYTHONPATH="$PWD/$out/python" "$python" -m pytest -q --numprocesses auto --maxprocesses 8 --dist worksteal "$@" ||
	echo "some tests failed; their lines count all the same" >&2

report() {
	with_counters cargo llvm-cov report --release \
		--ignore-filename-regex '(rust/(py|c|wasm)|benches|tests)/' "$@"
}
report --html --output-dir "$out"
report --summary-only | tee "$out/summary.txt"
report --show-missing-lines --summary-only | sed -n '/^Uncovered Lines/,$p' >"$out/missing.txt"
echo "Uncovered lines: $out/missing.txt; line by line: $out/html/index.html"
