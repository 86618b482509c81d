#!/bin/sh
# Builds the sdist and proves it: from its own sources and vendored crates alone, without a network
# and with an empty cargo home, it becomes a wheel that installs into a clean environment and
# drives; twine and auditwheel are asked what they think of both.
#
#     sh rust/py/dist.sh PYTHON FOLDER
#
# PYTHON has maturin; FOLDER takes the sdist and the wheel.
set -eu
python=$1
mkdir -p "$2"
out=$(cd "$2" && pwd)
root=$(cd "$(dirname "$0")/../.." && pwd)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

rm -f "$out"/popsteer-*
(cd "$root" && "$python" -m maturin sdist --out "$out")
tar -xzf "$out"/popsteer-*.tar.gz -C "$work"
source=$(echo "$work"/popsteer-*)

echo "== vendored crates"
(cd "$source" && cargo vendor --locked "$work/crates" 2>/dev/null) >"$work/sources.toml"
ls "$work/crates" | wc -l
# The folder above the sources: nothing in the sdist changes.
mkdir "$work/.cargo" "$work/cargo"
mv "$work/sources.toml" "$work/.cargo/config.toml"

echo "== a wheel, offline"
(cd "$source" && CARGO_HOME="$work/cargo" CARGO_NET_OFFLINE=true CARGO_TARGET_DIR="$work/target" \
	"$python" -m maturin build --release --offline --interpreter "$python" --out "$out")
ls "$work/cargo/registry" 2>/dev/null && { echo "crates came from elsewhere" >&2; exit 1; }

echo "== installed into a clean environment"
"$python" -m venv "$work/clean"
"$work/clean/bin/python" -m pip install --quiet "$out"/popsteer-*.whl
(cd "$work" && "$work/clean/bin/python" - <<'PROGRAM'
import popsteer
from popsteer import sim, tracks

track = tracks.get("racetrack")
run = sim.run(popsteer.PreviewPop(popsteer.Path(track.xy, speed=track.speed)))
assert run.metrics.finished and popsteer.build_profile == "release"
print(popsteer.__version__, f"{run.metrics.settled_mean_abs_cross_track_error:.4f} m")
PROGRAM
)

echo "== what others say"
for tool in twine auditwheel; do
	"$python" -m "$tool" --version >/dev/null 2>&1 || echo "$tool is not installed: not asked"
done
if "$python" -m twine --version >/dev/null 2>&1; then
	"$python" -m twine check --strict "$out"/popsteer-*
fi
if "$python" -m auditwheel --version >/dev/null 2>&1; then
	"$python" -m auditwheel show "$out"/popsteer-*.whl
fi
