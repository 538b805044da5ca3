# SPDX-License-Identifier: GPL-3.0-or-later
"""Draws error against time from the JSON of scripts/bench.sh, one SVG per report that has errors.

benchmarks/plot_error_against_time.py FOLDER
A row is a point if it has a time and a counter whose name says error or rmse. Rows that share a name up to the last "/"
are one line: the same method at several settings. Lower left is better.
"""

import json
import math
import sys
from collections import defaultdict
from dataclasses import dataclass
from html import escape
from pathlib import Path

WIDTH_PX, HEIGHT_PX, MARGIN_PX = 760, 480, 64
COLOURS = ("#0b6e99", "#c0392b", "#2e7d32", "#8e44ad", "#b9770e", "#34495e", "#d81b60", "#00897b")
SECONDS_PER_UNIT = {"ns": 1e-9, "us": 1e-6, "ms": 1e-3, "s": 1.0}


@dataclass(frozen=True)
class Point:
    """One setting of one method."""

    setting: str
    time_s: float
    error: float


def points_by_method(report: dict) -> dict[str, list[Point]]:
    """Points of a report of Google Benchmark, or of ours, which has the same shape."""
    methods: dict[str, list[Point]] = defaultdict(list)
    for row in report["benchmarks"]:
        errors = [value for name, value in row.items() if "error" in name or "rmse" in name]
        if not errors or not isinstance(errors[0], float) or errors[0] <= 0:
            continue
        method, _, setting = row.get("run_name", row["name"]).removesuffix("/real_time").rpartition("/")
        time_s = row["real_time"] * SECONDS_PER_UNIT[row["time_unit"]]
        methods[method or setting].append(Point(setting, time_s, errors[0]))
    return methods


def decades(values: list[float]) -> tuple[int, int]:
    """Powers of ten that enclose the values."""
    low, high = math.floor(math.log10(min(values))), math.ceil(math.log10(max(values)))
    return low, max(high, low + 1)


def plot(title: str, methods: dict[str, list[Point]]) -> str:
    """Draw an SVG with logarithmic axes."""
    points = [point for method in methods.values() for point in method]
    x_low, x_high = decades([point.time_s for point in points])
    y_low, y_high = decades([point.error for point in points])

    def x_px(time_s: float) -> float:
        return MARGIN_PX + (math.log10(time_s) - x_low) / (x_high - x_low) * (WIDTH_PX - 2 * MARGIN_PX)

    def y_px(error: float) -> float:
        return HEIGHT_PX - MARGIN_PX - (math.log10(error) - y_low) / (y_high - y_low) * (HEIGHT_PX - 2 * MARGIN_PX)

    lines = [
        (
            f'<svg xmlns="http://www.w3.org/2000/svg" width="{WIDTH_PX}" height="{HEIGHT_PX}" font-family="sans-serif" '
            'font-size="12"><rect width="100%" height="100%" fill="white"/>'
        ),
        f'<text x="{MARGIN_PX}" y="28" font-size="15">{escape(title)}: error against time, s</text>',
    ]
    for decade in range(x_low, x_high + 1):
        x = x_px(10.0**decade)
        lines.append(f'<path d="M{x:.1f} {MARGIN_PX}V{HEIGHT_PX - MARGIN_PX}" stroke="#ddd"/>')
        lines.append(f'<text x="{x:.1f}" y="{HEIGHT_PX - MARGIN_PX + 18}" text-anchor="middle">1e{decade}</text>')
    for decade in range(y_low, y_high + 1):
        y = y_px(10.0**decade)
        lines.append(f'<path d="M{MARGIN_PX} {y:.1f}H{WIDTH_PX - MARGIN_PX}" stroke="#ddd"/>')
        lines.append(f'<text x="{MARGIN_PX - 6}" y="{y + 4:.1f}" text-anchor="end">1e{decade}</text>')
    for index, (method, members) in enumerate(sorted(methods.items())):
        colour = COLOURS[index % len(COLOURS)]
        members.sort(key=lambda point: point.time_s)
        track = " ".join(f"{x_px(point.time_s):.1f},{y_px(point.error):.1f}" for point in members)
        lines.append(f'<polyline points="{track}" fill="none" stroke="{colour}"/>')
        for point in members:
            x, y = x_px(point.time_s), y_px(point.error)
            hint = escape(f"{method} {point.setting}: {point.time_s:.3g} s, {point.error:.3g}")
            lines.append(f'<circle cx="{x:.1f}" cy="{y:.1f}" r="4" fill="{colour}"><title>{hint}</title></circle>')
            lines.append(f'<text x="{x + 6:.1f}" y="{y - 6:.1f}" fill="{colour}">{escape(point.setting)}</text>')
        legend_y = MARGIN_PX + 16 * index
        lines.append(
            f'<text x="{WIDTH_PX - MARGIN_PX}" y="{legend_y}" fill="{colour}" text-anchor="end">{escape(method)}</text>'
        )
    return "\n".join([*lines, "</svg>\n"])


def main() -> None:
    """Draw one plot beside each report that has errors."""
    for path in sorted(Path(sys.argv[1]).glob("*.json")):
        methods = points_by_method(json.loads(path.read_text(encoding="utf-8")))
        if methods:
            target = path.with_suffix(".svg")
            target.write_text(plot(path.stem.replace("_", " "), methods), encoding="utf-8")
            print(target)


if __name__ == "__main__":
    main()
