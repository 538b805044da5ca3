# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes one report of a native benchmark's: medians over its rounds, and what it was measured on.

benchmarks/merge_runs.py REPORT CONTEXT
Prints the report. Of repetitions with aggregates, their medians are taken; rows of one name are rounds.
"""

import json
import statistics
import sys
from pathlib import Path


def median_of(rows: list[dict]) -> dict:
    """One row, whose numbers are medians."""
    merged = dict(rows[0])
    for name, value in merged.items():
        if isinstance(value, float):
            merged[name] = statistics.median(row[name] for row in rows)
    return merged


def main() -> None:
    """Print the merged report."""
    measured, about = (json.loads(Path(path).read_text(encoding="utf-8")) for path in sys.argv[1:3])
    for name in ("host_name", "executable"):
        measured["context"].pop(name, None)
    measured["context"] |= about
    rounds: dict[str, list[dict]] = {}
    for row in measured["benchmarks"]:
        if row.get("aggregate_name") in {None, "median"}:
            rounds.setdefault(row["name"], []).append(row)
    measured["benchmarks"] = [median_of(rows) for rows in rounds.values()]
    json.dump(measured, sys.stdout, indent=1)
    print()


if __name__ == "__main__":
    main()
