# SPDX-License-Identifier: GPL-3.0-or-later
"""The memory that a render surely takes, before it takes any: what the machine does not have is refused.

A lower bound, so that nothing is refused that fits: the sums of samples and the planes that they become, what is made
of meshes, strands and instances, single images, and what waits for the light of fog. What maps and rows of shafts take
is known once they are laid out: native code asks for it before they are filled, from the room that these parts leave.
"""

from __future__ import annotations

import resource
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from . import InvalidInput

if TYPE_CHECKING:
    from collections.abc import Collection, Iterable

    from .render_config import DataConfig
    from .scene_description import Mesh, SceneDescription, Strands

#: Of passes that are no colours. The sums of Debug Sample Count are others'.
_CHANNELS = {
    "Combined": 4,
    "Depth": 1,
    "Shafts Visibility": 1,
    "IndexOB": 1,
    "IndexMA": 1,
    "Mist": 1,
    "Vector": 4,
    "Debug Sample Count": 0,
    "Denoising Depth": 1,
}
_MATTES = {"CryptoObject", "CryptoMaterial", "CryptoAsset"}
#: Of Embree's trees, and of what these read: half of what was measured.
_TREE_BYTES_PER_TRIANGLE, _TREE_BYTES_PER_STRAND_POINT, _TREE_BYTES_PER_SPHERE, _BYTES_PER_INSTANCE = 60, 50, 25, 250
#: A part of the ray, its weight, and its place among all. Where fog scatters, there are 12 more for the light.
_FOG_BYTES_PER_PIXEL = 32 + 12 + 4
#: Below, nobody asks how much is free.
_CHECKED_FROM_BYTES = 256 << 20


@dataclass(frozen=True)
class Part:
    """Of a render's memory."""

    what: str
    at_least_bytes: int
    advice: str  #: How to take less.


def picture_part(
    size_px: tuple[int, int], passes: Collection[str], data: DataConfig | None = None, group_count: int = 0
) -> Part:
    """Per pixel the sums and the count of samples, and the planes; ``group_count``: of light groups that are kept."""
    channels = sum(_CHANNELS.get(name, 3) for name in {"Combined", *passes} - _MATTES)
    if data is not None:
        channels += 2 * data.matte_ranks * len(_MATTES.intersection(passes))
        channels += sum(4 if is_colour else 1 for _, is_colour in data.aovs)
    channels += 3 * group_count * (2 if "Shafts" in passes else 1)
    beside = len(passes) + (len(data.aovs) if data is not None else 0) + group_count
    width, height = size_px
    names = f" with {beside} passes beside it" if beside else ""
    return Part(
        f"the picture of {width} x {height} pixels{names}",
        width * height * 4 * (2 * channels + 1),
        "lower the resolution, or render a region" + (" or fewer passes" if beside else ""),
    )


def fog_part(size_px: tuple[int, int]) -> Part:
    """What waits for the light of one sample, of each pixel's ray once: it meets fog or not, where there is any."""
    width, height = size_px
    return Part(
        f"the fog in {width} x {height} pixels",
        width * height * _FOG_BYTES_PER_PIXEL,
        "lower the resolution, or render a region",
    )


def require_room_for_image(name: str, size_px: tuple[int, int], bytes_per_pixel: int) -> None:
    """Before its pixels are read. Raises InvalidInput, which names it."""
    width, height = size_px
    require_room(
        [Part(f'image "{name}" of {width} x {height} pixels', width * height * bytes_per_pixel, "scale it down")]
    )


def scene_parts(description: SceneDescription, in_memory: Collection[str]) -> list[Part]:
    """Of its instances, and of meshes and strands, each once, but those whose keys are ``in_memory`` already."""
    places = (description.instances, description.strand_objects, description.voxel_objects)
    meshes = (group.mesh for group in description.instances)
    strands = (group.strands for group in description.strand_objects)
    return [
        _trees_part(mesh for mesh in meshes if mesh.key not in in_memory),
        _strands_part(one for one in strands if one.key not in in_memory),
        _instances_part(sum(len(group.object_names) for groups in places for group in groups)),
    ]


def _trees_part(meshes: Iterable[Mesh]) -> Part:
    triangles = sum(len(mesh.triangles) for mesh in {mesh.key: mesh for mesh in meshes}.values())
    return Part(
        f"the scene of {triangles:,} triangles",
        triangles * _TREE_BYTES_PER_TRIANGLE,
        "lower its subdivision, hide what the picture does not show, or simplify it",
    )


def _strands_part(strands: Iterable[Strands]) -> Part:
    each = {one.key: one for one in strands}.values()
    return Part(
        f"the scene's hair and points, {sum(len(one.points) for one in each):,} points in all,",
        sum(
            len(one.points) * (_TREE_BYTES_PER_STRAND_POINT if len(one.first_points) else _TREE_BYTES_PER_SPHERE)
            for one in each
        ),
        "lower its children, its steps, or the number of points",
    )


def _instances_part(count: int) -> Part:
    return Part(
        f"the scene of {count:,} instances",
        count * _BYTES_PER_INSTANCE,
        "lower their density, or hide what the picture does not show",
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
        others = at_least - largest.at_least_bytes
        rest = f", what else is there {_gib(others)}" if others else ""
        raise InvalidInput(
            f"{largest.what} takes {_gib(largest.at_least_bytes)} of memory at least{rest}, and {_gib(free)} are free: "
            + largest.advice
        )


def room_left_by(parts: Iterable[Part]) -> int | None:
    """What parts that are not yet taken leave for others; None: nothing tells."""
    free = free_bytes()
    return None if free is None else max(free - sum(part.at_least_bytes for part in parts), 0)


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
