#!/bin/sh
# A smoke of Python in seconds, from the sources as they are: `make check` runs it.
#
#     tests/smoke.sh PYTHON [pytest's options]
#
# The extension is built without optimisations, with overflow checks, and put with the Python sources
# on PYTHONPATH. That spares the wheel, whose build takes minutes; `make test` has what only a wheel shows.
set -eu
python=$1
shift
cargo build --quiet --locked --package popsteer-py
package=target/smoke/popsteer
rm -rf "$package"
mkdir -p target/smoke
cp -r python/popsteer "$package"
rm -f "$package"/_core*.so
suffix=$("$python" -c 'import sysconfig; print(sysconfig.get_config_var("EXT_SUFFIX"))')
for library in target/debug/lib_core.so target/debug/lib_core.dylib; do
	if [ -e "$library" ]; then cp "$library" "$package/_core$suffix"; fi
done
# Something of each layer: imports, the interface, controllers against the reference, plants, files, commands.
PYTHONPATH="$PWD/target/smoke" HYPOTHESIS_PROFILE=smoke "$python" -m pytest -q --numprocesses 2 --dist worksteal \
	tests/meta/test_imports.py tests/meta/test_imports_python.py \
	tests/unit/test_api_laws.py tests/unit/test_status.py tests/unit/test_batch.py tests/unit/test_vehicle.py \
	tests/parity/test_laws.py::test_law_with_a_vehicle_matches_reference_random \
	tests/parity/test_laws.py::test_law_matches_reference_rollout \
	tests/closed_loop/test_run.py tests/closed_loop/test_run_reverse.py \
	tests/unit/test_tables.py tests/cli/test_errors.py tests/cli/test_help.py "$@"
