# SPDX-License-Identifier: GPL-3.0-or-later
"""All shader nodes of the running Blender: what the compiler says of each, and how far its values are off Cycles'.

scripts/python benchmarks/node_table_bench.py --context FILE --output FILE [--docs FOLDER], for nodes.md.
"""

from __future__ import annotations

import sys
import time
from pathlib import Path

import bpy

import tyndall.blender
from report import argument_parser, row, write_page, write_report

ROOT = Path(__file__).resolve().parent.parent
sys.path.append(str(ROOT / "tests"))

HEADER = """# Nodes
Every shader node of Blender {blender}: what a render reports where it is not drawn as it is (by choice: of a shader's
other distributions, and with shares that are 0 when it is added), and the largest deviation of its values from the
running Cycles' over random inputs, relative where they are above 1, of the {share:.0%} of points that agree best (where
patterns and texels jump, the last bit of a place decides). The set-ups are tests in 3.4, 4.5 and 5.0; a test holds this
page's states. `scripts/bench.sh node_table_bench` makes it anew. Options change what is said here: mirrors show what is
around them, and glass bends what is seen through it ([indirect light](indirect-light.md)).

| node | state | largest deviation | set-ups |
|---|---|---|---|
"""


def main() -> None:
    """Measure all of them."""
    arguments = argument_parser(__doc__, has_page=True).parse_args()
    tyndall.blender.enable()
    from support.image_setups import IMAGES, NORMALS  # noqa: PLC0415  they need the add-on
    from support.input_setups import INPUT_SETUPS  # noqa: PLC0415
    from support.node_measurements import BEST_SHARE, measured  # noqa: PLC0415
    from support.node_states import ELSEWHERE, TESTS, node_states  # noqa: PLC0415
    from support.pattern_setups import setups_of, usual_cases  # noqa: PLC0415
    from support.photometry_files import PHOTOMETRY  # noqa: PLC0415

    start = time.process_time()
    patterns = [setup for setup, _ in setups_of(usual_cases()).values()]
    found = measured(patterns, {**INPUT_SETUPS, **IMAGES, **NORMALS, **PHOTOMETRY})
    rows = []
    text = HEADER.format(blender=bpy.app.version_string, share=BEST_SHARE)
    for kind, state in sorted(node_states().items(), key=lambda item: item[1].label):
        deviation, count = found.get(kind, (-1.0, 0))
        said = ELSEWHERE.get(kind) or state.said()
        shown = f"{deviation:.0e}" if count else f"`{TESTS[kind]}`" if kind in TESTS else ""
        text += f"| {state.label} | {said} | {shown} | {count or ''} |\n"
        rows.append(row(kind, time.process_time() - start, state=said, deviation=deviation, setups=float(count)))
        print(rows[-1], flush=True)
    write_report(rows, arguments)
    write_page("nodes.md", text, arguments)


if __name__ == "__main__":
    main()
