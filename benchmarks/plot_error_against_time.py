# SPDX-License-Identifier: GPL-3.0-or-later
"""Draws error against time from the JSON of scripts/bench.sh, one SVG per report that has errors.

benchmarks/plot_error_against_time.py FOLDER
A row is a point if it has a time and a counter whose name says error or rmse. Rows that share a name up to the last "/"
are one line: the same method at several settings. Lower left is better.
"""

import json
import sys
from collections import defaultdict
from pathlib import Path

from log_plot import Line, Point, draw

SECONDS_PER_UNIT = {"ns": 1e-9, "us": 1e-6, "ms": 1e-3, "s": 1.0}


def lines_of(report: dict) -> list[Line]:
    """Methods of a report of Google Benchmark, or of ours, which has the same shape."""
    methods: dict[str, list[Point]] = defaultdict(list)
    for row in report["benchmarks"]:
        errors = [value for name, value in row.items() if "error" in name or "rmse" in name]
        if not errors or not isinstance(errors[0], float) or errors[0] <= 0:
            continue
        method, _, setting = row.get("run_name", row["name"]).removesuffix("/real_time").rpartition("/")
        time_s = row["real_time"] * SECONDS_PER_UNIT[row["time_unit"]]
        methods[method or setting].append(Point(setting, time_s, errors[0]))
    return [Line(method, sorted(points, key=lambda point: point.x)) for method, points in sorted(methods.items())]


def main() -> None:
    """Draw one plot beside each report that has errors."""
    for path in sorted(Path(sys.argv[1]).glob("*.json")):
        lines = lines_of(json.loads(path.read_text(encoding="utf-8")))
        if lines:
            target = path.with_suffix(".svg")
            target.write_text(draw(f"{path.stem.replace('_', ' ')}: error against time, s", lines), encoding="utf-8")
            print(target)


if __name__ == "__main__":
    main()
