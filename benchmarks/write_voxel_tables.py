# SPDX-License-Identifier: GPL-3.0-or-later
"""Writes docs/voxel-tables.md from the JSON of `scripts/bench.sh voxel_tables_bench`.

benchmarks/write_voxel_tables.py RESULTS DOCS
"""

from __future__ import annotations

import math
import sys
from pathlib import Path

from write_figures import Row, Rows, read, table

MODELS = {"dragon_4096": "dragon 4096", "Sponza_2048": "Sponza 2048", "monu6": "monu6", "monu8": "monu8"}
OURS = ("ours_geometry", "ours_counts", "ours_voxels", "ours_means")
#: Of table 2.3: what, counter, and Kol's range over his scenes, of what is uncompressed.
STEPS = (
    ("without offsets", "dag", "55 %"),
    ("uncompressed", "uncompressed", "100 %"),
    ("implicit offset", "implicit_offset", "90 %"),
    ("offset compression", "offset_compression", "68 to 72 %"),
    ("pointer compression", "pointer_compression", "87 to 92 %"),
    ("8-bit child mask", "byte_masks", "92 to 93 %"),
    ("pointer entropy", "pointer_entropy", "74 to 78 %"),
    ("combined", "combined", "44 to 50 %"),
)


def mega(value: float) -> str:
    """Millions, three digits."""
    if value == 0:
        return "0"
    digits = 2 - math.floor(math.log10(value / 1e6))
    return f"{value / 1e6:.{max(0, digits)}f}"


def percent(part: float, whole: float) -> str:
    """Of the whole, two digits below 10."""
    share = 100 * part / whole
    return f"{share:.1f} %" if share < 10 else f"{share:.0f} %"  # noqa: PLR2004


def by_model(rows: Rows, name: str) -> dict[str, Row]:
    """The rows of the models that were there, by their titles."""
    found = {title: rows.get(f"{name}/{model}", {}) for model, title in MODELS.items()}
    return {title: row for title, row in found.items() if row and "error_message" not in row}


def ours(row: Row) -> float:
    """Bytes of colours or normals in ours: counts, materials, indices and means."""
    return sum(row[part] for part in OURS[1:])


def similarity(rows: Rows, name: str) -> str:
    """Nothing where no picture was made."""
    ssim = rows.get(name, {}).get("ssim")
    return "" if ssim is None else f"{ssim:.4f}"


def table_2_1(rows: Rows) -> list[str]:
    """The DAG, and arrays of 24-bit colours."""
    models = by_model(rows, "table_2_1")
    found = list(models.values())
    lines = [
        ["DAG nodes (M)", *(mega(row["dag_nodes"]) for row in found)],
        ["DAG", *(mega(row["dag"]) for row in found)],
        ["with offsets", *(mega(row["with_offsets"]) for row in found)],
    ]
    for of, title in (("all", "all levels"), ("leaf", "voxels")):
        lines += [
            [f"{title}: entries Λ (M)", *(mega(row[f"{of}_entries"]) for row in found)],
            ["different λ (M)", *(mega(row[f"{of}_different"]) for row in found)],
            ["plain, A", *(mega(row[f"{of}_plain"]) for row in found)],
            ["indexed, Ã + M", *(mega(row[f"{of}_indexed"]) for row in found)],
            ["palettes, PC", *(mega(row[f"{of}_palettes"]) for row in found)],
            ["PC / A", *(percent(row[f"{of}_palettes"], row[f"{of}_plain"]) for row in found)],
        ]
    lines += [
        ["**ours**, geometry", *(mega(row["ours_geometry"]) for row in found)],
        ["voxels and counts", *(mega(row["ours_voxels"] + row["ours_counts"]) for row in found)],
        ["means", *(mega(row["ours_means"]) for row in found)],
        ["all but geometry / A, all levels", *(percent(ours(row), row["all_plain"]) for row in found)],
    ]
    return table(["", *models], lines)


def table_2_2(rows: Rows) -> list[str]:
    """Colours of fewer bits."""
    lines = []
    for name, row in rows.items():
        if not name.startswith("table_2_2/"):
            continue
        _, model, bits = name.split("/")
        means, most = (
            "/".join(f"{row[f'{kind}_{channel}']:.{digits}f}" for channel in "rgb")
            for kind, digits in (("mean", 1), ("most", 0))
        )
        lines.append(
            [
                MODELS[model],
                bits,
                means,
                most,
                f"{row['mean_cie94']:.2f} / {row['most_cie94']:.2f}",
                similarity(rows, f"color_picture/{model}/{bits}"),
                f"{mega(row['leaf_palettes'])} ({percent(row['leaf_palettes'], row['leaf_plain'])})",
                f"{mega(row['all_palettes'])} ({percent(row['all_palettes'], row['all_plain'])})",
                f"{mega(ours(row))} ({percent(ours(row), row['all_plain'])})",
            ]
        )
    head = ["", "bits", "mean RGB", "largest RGB", "CIE94: mean / largest", "SSIM"]
    return table([*head, "palettes: voxels", "all levels", "**ours**"], lines)


def normals(rows: Rows) -> list[str]:
    """Normals of fewer bits."""
    lines = []
    for name, row in rows.items():
        if not name.startswith("normals/"):
            continue
        _, model, bits = name.split("/")
        lines.append(
            [
                MODELS[model],
                bits,
                f"{row['mean_degrees']:.2f} / {row['most_degrees']:.2f}",
                similarity(rows, f"normal_picture/{model}/{bits}"),
                f"{mega(row['leaf_palettes'])} ({percent(row['leaf_palettes'], row['leaf_plain'])})",
                f"{mega(row['all_palettes'])} ({percent(row['all_palettes'], row['all_plain'])})",
                f"{mega(ours(row))} ({percent(ours(row), row['all_plain'])})",
            ]
        )
    head = ["", "bits", "degrees: mean / largest", "SSIM"]
    return table([*head, "palettes: voxels", "all levels", "**ours**"], lines)


def table_2_3(rows: Rows) -> list[str]:
    """The DAG with offsets, step by step: a row per step here, ours last."""
    models = by_model(rows, "table_2_3")
    found = list(models.values())
    lines = [
        [title, *(f"{mega(row[step])} ({percent(row[step], row['uncompressed'])})" for row in found), kol]
        for title, step, kol in STEPS
    ]
    for title, kind in (("ours, no turns", "unturned"), ("**ours, 48 turns**", "ours")):
        sums = [row[f"{kind}_geometry"] + row[f"{kind}_counts"] for row in found]
        lines.append(
            [
                title,
                *(f"{mega(of)} ({percent(of, row['uncompressed'])})" for of, row in zip(sums, found, strict=True)),
                "",
            ]
        )
        lines.append(["of it counts", *(mega(row[f"{kind}_counts"]) for row in found), ""])
    return table(["", *models, "Kol's scenes"], lines)


def table_2_4(rows: Rows) -> list[str]:
    """12-bit colours in published structures."""
    models = by_model(rows, "table_2_4")
    found = list(models.values())

    def sized(title: str, bytes_of: list[float]) -> list[str]:
        cells = [
            f"{mega(size)} ({size / row['nodes']:.3f}; {percent(size, row['svo'])})"
            for size, row in zip(bytes_of, found, strict=True)
        ]
        return [title, *cells]

    lines = [
        ["octree's nodes (M)", *(mega(row["nodes"]) for row in found)],
        sized("SVO", [row["svo"] for row in found]),
        sized("PSVO", [row["psvo"] for row in found]),
        ["CDAG's nodes (M)", *(mega(row["cdag_nodes"]) for row in found)],
        sized("CDAG", [row["cdag"] for row in found]),
        ["Kol's geometry", *(mega(row["kol_geometry"]) for row in found)],
        ["Kol's attributes", *(mega(row["kol_attributes"]) for row in found)],
        sized("Kol's", [row["kol_geometry"] + row["kol_attributes"] for row in found]),
        ["our geometry", *(mega(row["ours_geometry"]) for row in found)],
        ["our colours", *(mega(ours(row)) for row in found)],
        sized("**ours**", [sum(row[part] for part in OURS) for row in found]),
    ]
    return table(["", *models], lines)


def joint(rows: Rows) -> list[str]:
    """Several attributes in one material."""
    models = by_model(rows, "joint")
    lines = []
    for title, kind in (
        ("12-bit colours", "color"),
        ("+ 10-bit normals", "normal"),
        ("+ 8-bit reflectance", "reflectance"),
    ):
        cells = [title]
        for row in models.values():
            size, before = row[f"{kind}_bytes"], row["color_bytes"]
            more = "" if kind == "color" else f" (+ {percent(size - before, before)})"
            cells += [mega(size) + more, mega(row[f"{kind}_materials"])]
        lines.append(cells)
    head = [cell for title in models for cell in (title, "its materials")]
    return table(["", *head], lines)


def main() -> None:
    """Write the document."""
    results, docs = Path(sys.argv[1]), Path(sys.argv[2])
    rows = read(results, "voxel_tables_bench")
    text = (Path(__file__).parent / "voxel_tables_template.md").read_text(encoding="utf-8")
    for name, write in {
        "TABLE_2_1": table_2_1,
        "TABLE_2_2": table_2_2,
        "NORMALS": normals,
        "TABLE_2_3": table_2_3,
        "TABLE_2_4": table_2_4,
        "JOINT": joint,
    }.items():
        text = text.replace(f"<!-- {name} -->", "\n".join(write(rows)))
    (docs / "voxel-tables.md").write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
