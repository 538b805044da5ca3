# SPDX-License-Identifier: GPL-3.0-or-later
"""Writes docs/figures.md, and the plots in it, from the JSON of `scripts/bench.sh figures`.

benchmarks/write_figures.py RESULTS DOCS
"""

from __future__ import annotations

import json
import sys
from pathlib import Path

from log_plot import Line, Point, draw, draw_side_by_side

Row = dict[str, float]
Rows = dict[str, Row]

MS_PER_UNIT = {"ns": 1e-6, "us": 1e-3, "ms": 1.0, "s": 1e3}
SCENES = {"S": 0, "F": 1}  #: As arguments of benchmarks.
TABLE_5_1 = {
    "map": "depth map",
    "holes": "holes, moving",
    "g_buffer": "camera rays",
    "visibility": "visibility",
    "function": "function",
}
SIZES = (512, 1024, 2048)
TABLE_5_2 = ((11, 15), (21, 30), (41, 60))
STEPS = (4, 8, 16, 32, 64, 128, 256, 512, 1024, 2048)
SIDES = (1, 2, 4, 8, 16)
#: Of the issue: what, report, benchmark, what was asked for.
SECTION_8 = (
    ("function applied, full HD: smooth", "simd_functions", "apply_smooth/{}", "6"),
    ("noisy", "simd_functions", "apply_noisy/{}", "6"),
    ("closing 41 x 41, 2048²: square", "simd_edits", "close_square/{}/size:2048", "6"),
    ("disc", "simd_edits", "close_disc/{}/size:2048", "20"),
    ("closing along rows, length 61, 2048²", "simd_edits", "close_rows/{}/size:2048", "1.3"),
    ("silhouettes by 60", "simd_edits", "dilate_rows/{}/size:2048", ""),
    ("holes, 5 octaves, 2048²: still", "simd_edits", "holes/{}/size:2048", ""),
    ("moving", "simd_edits", "moving_holes/{}/size:2048", "15"),
    ("moving, of a lamp", "simd_edits", "moving_holes_in_space/{}/size:2048", ""),
    ("texture of the air, 64 steps, full HD: S", "simd_air", "march/{}/scene:0/steps:64", "60"),
    ("F", "simd_air", "march/{}/scene:1/steps:64", "60"),
    ("half resolution: S", "simd_air", "upsample/{}/scene:0/side:2", "20"),
    ("F", "simd_air", "upsample/{}/scene:1/side:2", "20"),
    ("light map fit, S: what strokes see, and its matrix", "simd_fit", "see_and_build/{}/0", ""),
    ("its 32 steps", "simd_fit", "steps/{}/0", ""),
    ("slider to picture, forest of 1M triangles: function", "simd_sliders", "transfer function/{}", "40"),
    ("occluder edit", "simd_sliders", "occluder edit/{}", "80"),
    ("sun moved", "simd_sliders", "sun moved/{}", "150"),
)


def read(results: Path, name: str) -> Rows:
    """Rows by their name, without what Google Benchmark adds at its end; ``ms`` is the time."""
    report = json.loads((results / f"{name}.json").read_text(encoding="utf-8"))
    rows = {}
    for row in report["benchmarks"]:
        parts = row["name"].split("/")
        while parts[-1] in {"real_time", "process_time", "manual_time"} or parts[-1].startswith(("iter", "repeats")):
            parts.pop()
        rows["/".join(parts)] = row | {"ms": row["real_time"] * MS_PER_UNIT[row["time_unit"]]}
    return rows


def number(value: float) -> str:
    """Two digits, three from 100 on."""
    return f"{value:.0f}" if abs(value) >= 100 else f"{value:.2g}"  # noqa: PLR2004


def table(head: list[str], rows: list[list[str]]) -> list[str]:
    """Lines of Markdown."""
    return [f"| {' | '.join(line)} |" for line in (head, ["---"] * len(head), *rows)]


def table_5_1(rows: Rows) -> list[str]:
    """The paper's milliseconds beside ours, and beside the plain way of doing it here."""
    lines = []
    for size in SIZES:
        for column, title in TABLE_5_1.items():
            of_forest = rows[f"table_5_1/{column}/F/{size}"]
            cells = [f"{size}²", title, number(of_forest["kol_gpu_ms"])]
            for scene in ("F", "S"):
                ours = rows.get(f"table_5_1/{column}/{scene}/{size}")
                plain = rows.get(f"table_5_1/plain_{column}/{scene}/{size}")
                cells += [number(row["ms"]) if row and "ms" in row else "" for row in (ours, plain)]
            lines.append(cells)
    return table(["map", "", "Kol, GPU", "F", "F, plain", "S", "S, plain"], lines)


def table_5_2(rows: Rows) -> list[str]:
    """The same for the closings."""
    lines = []
    for size in SIZES:
        for kernel, length in TABLE_5_2:
            disc, square, plain = (
                rows[f"table_5_2/{name}/F/{size}/{kernel}"] for name in ("disc", "square", "plain_square")
            )
            along, plain_along = (rows[f"table_5_2/{name}/F/{size}/{length}"] for name in ("rows", "plain_rows"))
            lines.append(
                [
                    f"{size}²",
                    str(kernel),
                    *(number(value) for value in (disc["kol_gpu_ms"], disc["ms"], square["ms"], plain["ms"])),
                    str(length),
                    *(number(value) for value in (along["kol_gpu_ms"], along["ms"], plain_along["ms"])),
                    *(f"{row['filled_percent']:.0f} %" for row in (disc, along)),
                ]
            )
    head = ["map", "kernel", "Kol, GPU", "disc", "square", "plain", "length", "Kol, GPU", "rows", "plain", "disc fills"]
    return table([*head, "rows fill"], lines)


def error_curves(rows: Rows, plot: Path) -> list[str]:
    """Error and time by steps, and by pixels that share a ray."""
    lines = []
    for scene, index in SCENES.items():
        for name, values, argument in (("march", STEPS, "steps"), ("upsample", SIDES, "side")):
            points = [
                Point(str(value), row["ms"], row["error_percent"])
                for value in values
                if (row := rows.get(f"{name}/scene:{index}/{argument}:{value}")) and row["error_percent"] > 0
            ]
            title = "steps per ray" if name == "march" else "side of the squares of pixels, 64 steps"
            if points:
                lines.append(Line(f"{scene}: {title}", points))
    plot.write_text(
        draw("The texture of the air, full HD: error in percent against time in ms", lines), encoding="utf-8"
    )
    by_steps = [[str(steps), *cells(rows, "march", "steps", steps)] for steps in STEPS]
    by_side = [[f"{side} x {side}", *cells(rows, "upsample", "side", side)] for side in SIDES]
    return [
        *table(["steps", "S: ms", "error", "F: ms", "error"], by_steps),
        "",
        *table(["pixels per ray", "S: ms", "error", "F: ms", "error"], by_side),
    ]


def cells(rows: Rows, name: str, argument: str, value: int) -> list[str]:
    """Milliseconds and error of both scenes; empty where a scene is not there."""
    result = []
    for index in SCENES.values():
        row = rows.get(f"{name}/scene:{index}/{argument}:{value}")
        result += [number(row["ms"]), f"{number(row['error_percent'])} %"] if row else ["", ""]
    return result


def instruction_sets(results: Path) -> list[str]:
    """Milliseconds of both, in turn."""
    reports = {name: read(results, name) for name in sorted({report for _, report, _, _ in SECTION_8})}
    lines = []
    for what, report, benchmark, wanted in SECTION_8:
        measured = [reports[report].get(benchmark.format(name)) for name in ("AVX-512", "AVX2")]
        lines.append([what, wanted, *(number(row["ms"]) if row and "ms" in row else "" for row in measured)])
    return table(["ms", "at most", "AVX-512", "AVX2"], lines)


def flicker(rows: Rows, plot: Path) -> list[str]:
    """What changes from frame to frame beyond what should."""
    counters = (
        "error_percent",
        "reference_change_percent",
        "change_percent",
        "excess_percent",
        "change_of_error_percent",
        "worst_change_of_error_percent",
        "reference_fast_percent",
        "fast_percent",
    )
    lines, panels = [], []
    for scene in SCENES:
        for motion in ("wind", "holes", "louvre"):
            drawn, reference = [], None
            for name, row in rows.items():
                if not name.startswith(f"flicker/{scene}/{motion}/") or "error_percent" not in row:
                    continue
                setting = name.rpartition("/")[2]
                lines.append([scene, motion, setting, *(f"{row[counter]:.2f}" for counter in counters)])
                if setting != "pixels":
                    drawn.append(Line(setting, spectrum(row, "at_")))
                    # The last one is the finest.
                    reference = Line("as it should be", spectrum(row, "reference_at_"), is_reference=True)
            if reference:
                panels.append((f"{scene}, {motion}: amplitude in percent of the light against Hz", [*drawn, reference]))
    plot.write_text(draw_side_by_side(3, panels), encoding="utf-8")
    head = ["", "", "setting", "error", "due", "change", "excess", "of error", "its worst", "fast, due", "fast"]
    return table(head, lines)


def spectrum(row: Row, prefix: str) -> list[Point]:
    """Amplitudes by frequency, as flicker_bench names them."""
    of_hertz = {
        float(name.removeprefix(prefix).removesuffix("_hz_percent")): value
        for name, value in row.items()
        if name.startswith(prefix)
    }
    return [Point("", hertz, value) for hertz, value in sorted(of_hertz.items()) if value > 0]


def main() -> None:
    """Write the document and its plots."""
    results, docs = Path(sys.argv[1]), Path(sys.argv[2])
    paper = read(results, "paper_tables")
    context = json.loads((results / "paper_tables.json").read_text(encoding="utf-8"))["context"]
    text = (Path(__file__).parent / "figures_template.md").read_text(encoding="utf-8")
    for name, lines in {
        "MACHINE": [f"{context['num_cpus']} threads of {context['cpu']}, commit {context['commit']}."],
        "TABLE_5_1": table_5_1(paper),
        "TABLE_5_2": table_5_2(paper),
        "ERROR_CURVES": error_curves(read(results, "error_curves"), docs / "pictures" / "error_curves.svg"),
        "INSTRUCTION_SETS": instruction_sets(results),
        "FLICKER": flicker(read(results, "flicker"), docs / "pictures" / "flicker.svg"),
    }.items():
        text = text.replace(f"<!-- {name} -->", "\n".join(lines))
    (docs / "figures.md").write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
