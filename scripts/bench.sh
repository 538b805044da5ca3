#!/bin/bash
# SPDX-License-Identifier: GPL-3.0-or-later
# scripts/bench.sh [NAME...]: runs the benchmarks (all, or those named by their stem), writes benchmarks/results/*.json
# with medians, and draws error against time. Leave the machine alone meanwhile: it times itself before each.
# scripts/bench.sh voxel_tables_bench also writes docs/voxel-tables.md.
# scripts/bench.sh figures: what docs/figures.md shows, and writes it: the paper's tables, error curves, AVX-512 beside
# AVX2 in turn, flicker. About a quarter of an hour on two cores.
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
{ cmake --preset release && cmake --build build/release --target all benchmarks; } >build/logs/bench-build.log 2>&1 ||
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

# RESULT STEM ARGUMENT...: runs a native benchmark.
native() {
    local result=$1 stem=$2
    shift 2
    echo "$result"
    "build/release/benchmarks/$stem" "$@" --benchmark_out="build/logs/$result.json" >"build/logs/$result.log" 2>&1 ||
        fail "$stem failed, see build/logs/$result.log"
    /usr/bin/python3 benchmarks/merge_runs.py "build/logs/$result.json" build/logs/bench-context.json \
        >"$results/$result.json.part"
    mv "$results/$result.json.part" "$results/$result.json"
}

# RESULT STEM ARGUMENT...: runs one in Python.
in_python() {
    local result=$1 stem=$2
    shift 2
    echo "$result"
    scripts/python "benchmarks/$stem.py" "$@" --context build/logs/bench-context.json --output "$results/$result.json" \
        >"build/logs/$result.log" 2>&1 || fail "$stem failed, see build/logs/$result.log"
}

if [[ ${names[*]} == figures ]]; then
    both=(--simd=AVX-512,AVX2 --rounds=3 --benchmark_min_time=0.2)
    native paper_tables paper_tables_bench --rounds=3 --benchmark_min_time=0.1
    native simd_functions transfer_functions_bench "${both[@]}" --benchmark_filter='^(apply_(smooth|noisy))/'
    native simd_edits light_shafts_edits_bench "${both[@]}" \
        --benchmark_filter='^(close_(square|disc|rows)|dilate_rows|(moving_)?holes(_in_space)?)/size:2048'
    native simd_air heterogeneity_bench "${both[@]}" \
        --benchmark_filter='^(march/scene:[01]/steps:64|upsample/scene:[01]/side:2)/'
    native simd_fit light_map_fit_bench "${both[@]}" --benchmark_filter='^(see_and_build|steps)/0/'
    in_python simd_sliders slider_bench --simd AVX-512 AVX2
    # The first pictures also pay for memory that the machine has never had before.
    native error_curves heterogeneity_bench --benchmark_min_time=0.2 --benchmark_min_warmup_time=0.3 \
        --benchmark_filter='^(march|upsample)/'
    native flicker flicker_bench
    /usr/bin/python3 benchmarks/write_figures.py "$results" docs
    exit
fi

ran=0
for source in benchmarks/*_bench.cpp; do
    stem=$(basename "$source" .cpp)
    wanted "$stem" || continue
    native "$stem" "$stem" --benchmark_repetitions=9 --benchmark_report_aggregates_only=true
    ran=1
done
for script in benchmarks/*_bench.py; do
    stem=$(basename "$script" .py)
    wanted "$stem" || continue
    in_python "$stem" "$stem" $(grep -q has_page=True "$script" && echo --docs docs)
    ran=1
done
((ran)) || fail "there is no benchmark named ${names[*]}"
/usr/bin/python3 benchmarks/plot_error_against_time.py "$results"
if wanted voxel_tables_bench; then
    /usr/bin/python3 benchmarks/write_voxel_tables.py "$results" docs
fi
