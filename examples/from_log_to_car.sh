#!/bin/sh
# From a log to a tuned car: five commands, and one vehicle file handed from one to the next.
#
#     examples/from_log_to_car.sh [FOLDER]
#
# Needs popsteer[lab,identify,logs,tune,sweep]. TRIALS, RUNS and SECONDS_DRIVEN make it shorter.
set -eu

here=$(CDPATH='' cd -- "$(dirname -- "$0")" && pwd)
mkdir -p "${1:-from-log-to-car}"
cd "${1:-from-log-to-car}"

step() {
    printf '\n$ popsteer %s\n\n' "$*"
    popsteer "$@"
}

# A log and waypoints, as a car's computer records them. With a car of your own, begin below.
"${PYTHON:-python3}" "$here/recorded_drive.py" . "${SECONDS_DRIVEN:-120}"

# What is my car? Give what a tape measure and the manual say; the log shows the rest.
step identify drive.mcap --out car.toml \
    --set-vehicle wheelbase=2.7 --set-vehicle rear_axle=-1.35 --set-vehicle max_steer=0.6

# How fast may it go?
step plan waypoints.csv --vehicle car.toml --out course.csv

# Which parameters suit it?
step tune --vehicle car.toml --waypoints course.csv --trials "${TRIALS:-40}" \
    --out tuned.toml

# Does it still track the course if the car differs from the one that was identified?
step sweep --vehicle car.toml --params tuned.toml --waypoints course.csv \
    --runs "${RUNS:-10000}" --out sweep.parquet

# What would it have done on the recorded drive?
step replay drive.mcap --vehicle car.toml --params tuned.toml --out replay
