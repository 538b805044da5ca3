#!/bin/bash
# SPDX-License-Identifier: GPL-3.0-or-later
# scripts/test.sh [--all]: sets up, builds, and runs every test: native, Python, packaging, and the Blender side in
# bpy 4.5, bpy 5.0 and Blender 3.4, then the linters. --all adds the sanitizers, the tests marked long, and the same
# again on a fresh minimal Debian. Ends with one line of counts; logs lie in build/logs.
set -uo pipefail
cd "$(dirname "$0")/.."
all=0
case "${1:-}" in
    --all) all=1 ;;
    "") ;;
    *) echo "usage: scripts/test.sh [--all]" >&2 && exit 2 ;;
esac

logs=build/logs results=build/test-results
rm -rf "$results"
mkdir -p "$logs" "$results"
time_limit_s=$((all ? 14400 : 3600)) # of one stage; a hang at exit is a failure, not a wait
long=$( ((all)) && echo "" || echo "not long")

# stage NAME COMMAND...: runs it, shows one line, and the end of its log when it fails. A stage that leaves no counts in
# $results/NAME.xml counts as one test; so does one that crashed before it could write them.
stage() {
    local name=$1 begin=$SECONDS code=0
    shift
    timeout --kill-after=30 "$time_limit_s" "$@" >"$logs/$name.log" 2>&1 </dev/null || code=$?
    printf '%-4s %-22s %4d s\n' "$( ((code)) && echo FAIL || echo ok)" "$name" $((SECONDS - begin))
    ((code == 0)) || tail -n 40 "$logs/$name.log" | sed 's/^/     | /'
    echo "$name $code" >>"$results/stages.txt"
    return $code
}

# Adds up what the stages left behind; a sentence of a native test (a doctest case) counts as one test.
counts() {
    /usr/bin/python3 - "$results" <<'PYTHON'
import re
import sys
from pathlib import Path
from xml.etree import ElementTree

results = Path(sys.argv[1])
passed = failed = skipped = 0
for line in (results / "stages.txt").read_text().splitlines():
    name, code = line.split()
    report = results / f"{name}.xml"
    failed_before = failed
    if report.exists():
        for suite in ElementTree.parse(report).iter("testsuite"):
            cases = re.findall(r"\[doctest\] test cases:\s*\d+ \|\s*(\d+) passed \|\s*(\d+) failed", "".join(suite.itertext()))
            bad = int(suite.get("failures", 0)) + int(suite.get("errors", 0))
            missing = int(suite.get("skipped", 0))
            if cases:
                passed += sum(int(case[0]) for case in cases)
                failed += max(bad, sum(int(case[1]) for case in cases))
            else:
                passed += int(suite.get("tests", 0)) - bad - missing
                failed += bad
            skipped += missing
    elif code == "0":
        passed += 1
    # Exit code 5 of pytest, "no tests", is a failure as well: a folder of tests has been lost.
    if code != "0" and failed == failed_before:
        failed += 1
print(f"{passed} passed, {failed} failed" + (f", {skipped} skipped" if skipped else ""))
sys.exit(1 if failed else 0)
PYTHON
}

finish() {
    echo "logs: $logs"
    counts
    exit
}

# beside COMMAND...: runs it while what follows goes on, beside one other at most, as a stage keeps little more than one of
# two cores busy; the window, which waits for half of its time, does not count.
window_pid=none
beside() {
    while (($(jobs -pr | grep -cvx "$window_pid") >= 2)); do wait -n; done
    "$@" &
}

python_tests() { # NAME COMMAND... : pytest with our usual arguments
    local name=$1
    shift
    BLENDER_USER_RESOURCES=$PWD/build/test-user/$name stage "$name" "$@" -c pyproject.toml --rootdir . \
        -p no:cacheprovider -m "$long" "--junitxml=$results/$name.xml"
}

native_tests() { # PRESET
    local label=()
    ((all)) || label=(--label-exclude long)
    stage "native-$1" ctest --test-dir "build/$1" --output-on-failure --parallel 2 "${label[@]}" \
        --output-junit "$PWD/$results/native-$1.xml"
}

build() { # PRESET
    stage "configure-$1" cmake --preset "$1" && stage "build-$1" cmake --build "build/$1"
}

scripts/setup.sh $( ((all)) && echo --all) || exit 1
tools=.deps/build/bin
build release || finish
native_tests release

package() {
    stage package scripts/package.sh && python_tests packaging $tools/python -m pytest tests/packaging
}

python_tests window .deps/bpy45/bin/python -m pytest tests/window &
window_pid=$!
# The longest first, so that both ends are met at about the same time.
beside python_tests bpy-4.5 .deps/bpy45/bin/python -m pytest tests/blender
beside python_tests bpy-5.0 .deps/bpy50/bin/python -m pytest tests/blender
beside python_tests blender-3.4 env PATH=/usr/bin:/bin blender -b --factory-startup --python-exit-code 1 \
    --python tests/support/pytest_in_blender.py -- tests/blender
beside python_tests python $tools/python -m pytest tests/python
beside package
beside stage build-benchmarks cmake --build build/release --target benchmarks --parallel 1
beside stage mypy $tools/mypy
beside stage clang-format bash -c 'git ls-files -z -- "*.cpp" "*.hpp" | xargs -0 clang-format --dry-run --Werror'
beside stage ruff-check $tools/ruff check
beside stage ruff-format $tools/ruff format --check
beside stage layers scripts/check_layers.py
wait

if ((all)); then
    build asan && native_tests asan
    export TSAN_OPTIONS=suppressions=$PWD/tests/support/thread_sanitizer.txt
    build tsan && native_tests tsan
    stage fresh-machine scripts/fresh-machine
fi
finish
