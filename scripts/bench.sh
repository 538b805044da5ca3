#!/bin/bash
# SPDX-License-Identifier: GPL-3.0-or-later
# scripts/bench.sh [NAME...]: runs the benchmarks (all, or those named by their stem), writes benchmarks/results/*.json
# with medians, and draws error against time. Leave the machine alone meanwhile: it times itself before each.
set -euo pipefail
cd "$(dirname "$0")/.."
shopt -s nullglob
results=benchmarks/results
mkdir -p "$results" build/logs

fail() {
    echo "bench: $*" >&2
    exit 1
}
wanted() { # STEM: whether it was asked for
    ((${#names[@]} == 0)) || [[ " ${names[*]} " == *" $1 "* ]]
}

names=("$@")
scripts/setup.sh
{ cmake --preset release && cmake --build build/release; } >build/logs/bench-build.log 2>&1 ||
    fail "the benchmarks do not build, see build/logs/bench-build.log"

# A report names what it was measured on (the CPU, the commit), and neither the host nor the folder.
/usr/bin/python3 - >build/logs/bench-context.json <<'PYTHON'
import json
import subprocess

git = ["git", "describe", "--always", "--dirty"]
with open("/proc/cpuinfo") as cpuinfo:
    cpu = next(line.split(":")[1].strip() for line in cpuinfo if line.startswith("model name"))
commit = subprocess.run(git, capture_output=True, text=True, check=True).stdout.strip()
print(json.dumps({"cpu": cpu, "commit": commit}))
PYTHON

ran=0
for source in benchmarks/*_bench.cpp; do
    stem=$(basename "$source" .cpp)
    wanted "$stem" || continue
    echo "$stem"
    "build/release/benchmarks/$stem" --benchmark_repetitions=9 --benchmark_report_aggregates_only=true \
        --benchmark_out="build/logs/$stem.json" >"build/logs/$stem.log" 2>&1 || fail "$stem failed, see build/logs/$stem.log"
    /usr/bin/python3 - "build/logs/$stem.json" build/logs/bench-context.json >"$results/$stem.json.part" <<'PYTHON'
import json
import sys

with open(sys.argv[1]) as report, open(sys.argv[2]) as context:
    measured, about = json.load(report), json.load(context)
for name in ("host_name", "executable"):
    measured["context"].pop(name, None)
measured["context"] |= about
measured["benchmarks"] = [row for row in measured["benchmarks"] if row.get("aggregate_name") in {None, "median"}]
json.dump(measured, sys.stdout, indent=1)
print()
PYTHON
    mv "$results/$stem.json.part" "$results/$stem.json"
    ran=1
done
for script in benchmarks/*_bench.py; do
    stem=$(basename "$script" .py)
    wanted "$stem" || continue
    echo "$stem"
    scripts/python "$script" --context build/logs/bench-context.json --output "$results/$stem.json" \
        >"build/logs/$stem.log" 2>&1 || fail "$stem failed, see build/logs/$stem.log"
    ran=1
done
((ran)) || fail "there is no benchmark named ${names[*]}"
/usr/bin/python3 benchmarks/plot_error_against_time.py "$results"
