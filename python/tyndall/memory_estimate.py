# SPDX-License-Identifier: GPL-3.0-or-later
"""The memory that a render surely takes, before it takes any: what the machine does not have is refused.

A lower bound, so that nothing is refused that fits: the sums of samples and the planes that they become, and Embree's
trees. What shafts and textures take depends on what the picture shows, and is told afterwards, as the peak.
"""

from __future__ import annotations

import resource
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from . import InvalidInput

if TYPE_CHECKING:
    from collections.abc import Collection, Iterable

    from .scene_description import Mesh

#: Of passes that are no colours.
_CHANNELS = {"Combined": 4, "Depth": 1, "Shafts Visibility": 1}
#: Of Embree's tree, and of the vertices and indices that it reads: half of what was measured.
_TREE_BYTES_PER_TRIANGLE = 60
#: Below, nobody asks how much is free.
_CHECKED_FROM_BYTES = 256 << 20


@dataclass(frozen=True)
class Part:
    """Of a render's memory."""

    what: str
    at_least_bytes: int
    advice: str  #: How to take less.


def picture_part(size_px: tuple[int, int], passes: Collection[str]) -> Part:
    """Per pixel the sums and the count of samples, and the planes; ``passes`` without data passes."""
    channels = sum(_CHANNELS.get(name, 3) for name in {"Combined", *passes})
    width, height = size_px
    names = f" with {len(passes)} passes beside it" if passes else ""
    return Part(
        f"the picture of {width} x {height} pixels{names}",
        width * height * 4 * (2 * channels + 1),
        "lower the resolution, or render a region" + (" or fewer passes" if passes else ""),
    )


def trees_part(meshes: Iterable[Mesh]) -> Part:
    """Of meshes that are not in memory yet; each once."""
    triangles = sum(len(mesh.triangles) for mesh in {mesh.key: mesh for mesh in meshes}.values())
    return Part(
        f"the scene of {triangles:,} triangles",
        triangles * _TREE_BYTES_PER_TRIANGLE,
        "lower its subdivision, hide what the picture does not show, or simplify it",
    )


def require_room(parts: Iterable[Part], free: int | None = None) -> None:
    """``free``: bytes; None: what this process may still take. Raises InvalidInput, which names the largest part."""
    parts = list(parts)
    at_least = sum(part.at_least_bytes for part in parts)
    if at_least < _CHECKED_FROM_BYTES:
        return
    free = free_bytes() if free is None else free
    if free is not None and at_least > free:
        largest = max(parts, key=lambda part: part.at_least_bytes)
        rest = f", what else is there {_gib(at_least - largest.at_least_bytes)}" if len(parts) > 1 else ""
        raise InvalidInput(
            f"{largest.what} takes {_gib(largest.at_least_bytes)} of memory at least{rest}, and {_gib(free)} are free: "
            + largest.advice
        )


def free_bytes() -> int | None:
    """Of the machine, of what its control group leaves, and of the process's limit, the least; None: nothing tells."""
    known = [bytes_ for bytes_ in (_of_machine(), control_group_bytes(), _of_limit()) if bytes_ is not None]
    return max(min(known), 0) if known else None


def _gib(count: int) -> str:
    return f"{count / (1 << 30):.1f} GiB"


def _of_machine() -> int | None:
    try:
        lines = dict(line.split(":", 1) for line in Path("/proc/meminfo").read_text().splitlines())
        return sum(int(lines[name].split()[0]) << 10 for name in ("MemAvailable", "SwapFree"))
    except (OSError, KeyError, ValueError):
        return None


def control_group_bytes(
    root: Path = Path("/sys/fs/cgroup"), of_process: Path = Path("/proc/self/cgroup")
) -> int | None:
    """Version 2: the least of its own group and of all above it; files that were read can make room."""
    try:
        line = next(line for line in of_process.read_text().splitlines() if line.startswith("0::"))
        group = root / line[3:].lstrip("/")
    except (OSError, StopIteration):
        return None
    found = []
    for folder in (group, *group.parents):
        if not folder.is_relative_to(root):
            break
        try:
            limit = (folder / "memory.max").read_text().strip()
            if limit != "max":
                used = int((folder / "memory.current").read_text())
                lines = (line.split() for line in (folder / "memory.stat").read_text().splitlines())
                cached = sum(int(number) for name, number in lines if name in {"inactive_file", "active_file"})
                found.append(int(limit) - used + cached)
        except (OSError, ValueError):
            continue
    return min(found, default=None)


def _of_limit() -> int | None:
    limit, _ = resource.getrlimit(resource.RLIMIT_AS)
    if limit == resource.RLIM_INFINITY:
        return None
    try:
        pages = int(Path("/proc/self/statm").read_text().split()[0])
    except (OSError, ValueError):
        return None
    return limit - pages * resource.getpagesize()
