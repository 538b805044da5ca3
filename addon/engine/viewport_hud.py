# SPDX-License-Identifier: GPL-3.0-or-later
"""What a rendered viewport did for its picture, as a few lines in its corner: time per stage, and what was reused."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import bpy

from ..amounts import duration_text

if TYPE_CHECKING:
    from bpy.types import Context

    from .viewport_worker import Work

#: Stages as the artist knows them, in the order in which they happen; parts of another stage are indented.
_STAGES = (
    ("scene reading", "Read scene"),
    ("scene update", "Scene"),
    ("camera rays and direct light", "Surfaces"),
    ("light shafts: prepare", "Shafts, prepared"),
    ("shadow map: raster", "  Depth map"),
    ("occluder edits", "  Occluder edits"),
    ("light shafts: scatter", "Shafts, scattered"),
    ("transfer functions", "Colour"),
)
_TEXT_PX, _LINE_PX, _MARGIN_PX = 11, 16, 12  # at a scale of 1
_COLOUR, _DIMMED, _BACKGROUND = (1.0, 1.0, 1.0, 0.95), (1.0, 1.0, 1.0, 0.6), (0.0, 0.0, 0.0, 0.45)


@dataclass(frozen=True, kw_only=True)
class Line:
    """A row of three columns."""

    name: str
    time: str = ""
    note: str = ""  #: What was reused.


def hud_lines(work: Work, status: str) -> list[Line]:
    """Rows about the latest picture, and what happens now."""
    statistics, scale = work.statistics, work.scale
    counts = statistics.get("counts", {})
    samples = counts.get("samples per pixel", 0)
    shown = f"1/{scale}" if scale > 1 else f"{samples:.3g} sample{'' if samples == 1 else 's'} per pixel"
    seconds: dict[str, float] = {}
    for stage in statistics.get("stages", ()):
        seconds[stage["name"]] = seconds.get(stage["name"], 0.0) + stage["seconds"]
    total_s = sum(value for name, value in seconds.items() if name in _WHOLE_STAGES)
    lines = [Line(name=shown, time=duration_text(total_s), note=status)]
    if scale == 1 and work.first_s > 0.0:
        lines.append(Line(name="First picture", time=duration_text(work.first_s), note="from the change on"))
    for name, label in _STAGES:
        note = _NOTES[name](counts) if name in _NOTES else ""
        if name in seconds or note:
            lines.append(Line(name=label, time=duration_text(seconds.get(name, 0.0)), note=note))
    lines += [Line(name=f"Skipped {entry['what']}", note=entry["reason"]) for entry in _skipped(statistics)]
    return lines


_WHOLE_STAGES = frozenset(name for name, label in _STAGES if not label.startswith(" "))


def _skipped(statistics: Mapping[str, Any]) -> Iterable[Mapping[str, str]]:
    """Those that say something about this picture, not about the scene: rays of a picture that is recoloured."""
    return [entry for entry in statistics.get("skipped", ()) if entry["what"] == "rays"]


def _scene_note(counts: Mapping[str, float]) -> str:
    if counts.get("scene rebuilt"):
        sent = int(counts.get("meshes sent", 0))
        return f"objects anew, {sent} meshes sent" if sent else "objects anew, meshes kept"
    return "only lights changed" if counts.get("scene relit") else ""


def _surface_note(counts: Mapping[str, float]) -> str:
    kept, walked = counts.get("surfaces: passes kept", 0), counts.get("surfaces: passes walked", 0)
    if not kept:
        return ""
    if walked:
        return f"{kept:.0f} of {kept + walked:.0f} samples kept"
    asked = counts.get("surfaces: lights asked", 0)
    return f"kept, {asked:.0f} light{'' if asked == 1 else 's'} anew" if asked else "kept"


def _map_note(counts: Mapping[str, float]) -> str:
    kept, made = counts.get("depth map: kept", 0), counts.get("depth map: made", 0)
    return f"{kept:.0f} of {kept + made:.0f} kept" if kept else ""


_NOTES = {
    "scene update": _scene_note,
    "camera rays and direct light": _surface_note,
    "shadow map: raster": _map_note,
}


def draw_hud(context: Context, lines: list[Line]) -> None:
    """In the lower left corner of the region, above the navigation texts of the view."""
    import blf  # there is none without a window
    import gpu
    from gpu_extras.batch import batch_for_shader

    pixel = context.preferences.system.ui_scale
    size, line_height, margin = _TEXT_PX * pixel, _LINE_PX * pixel, _MARGIN_PX * pixel
    _set_size(size)
    columns = [max(blf.dimensions(0, text)[0] for text in texts) for texts in zip(*map(_texts, lines), strict=True)]
    gap = 1.2 * size
    left, bottom = _corner(context, margin)
    width = sum(columns) + gap * (len(columns) - 1) + 2 * margin
    height = line_height * len(lines) + margin
    gpu.state.blend_set("ALPHA")
    shader = gpu.shader.from_builtin("UNIFORM_COLOR" if bpy.app.version >= (4, 0, 0) else "2D_UNIFORM_COLOR")
    shader.uniform_float("color", _BACKGROUND)
    corners = [(left, bottom), (left + width, bottom), (left + width, bottom + height), (left, bottom + height)]
    batch_for_shader(shader, "TRI_FAN", {"pos": corners}).draw(shader)
    for row, line in enumerate(lines):
        y = bottom + height - margin / 2 - (row + 1) * line_height + 0.3 * size
        name, time, note = _texts(line)
        x = left + margin
        _draw_text(name, x, y, _COLOUR)
        x += columns[0] + gap
        _draw_text(time, x + columns[1] - blf.dimensions(0, time)[0], y, _COLOUR)
        _draw_text(note, x + columns[1] + gap, y, _DIMMED)
    gpu.state.blend_set("NONE")


def _texts(line: Line) -> tuple[str, str, str]:
    return line.name, line.time, line.note


def _corner(context: Context, margin: float) -> tuple[float, float]:
    """Beside the toolbar where that lies over the view."""
    tools = next((region for region in context.area.regions if region.type == "TOOLS"), None)
    is_over = context.preferences.system.use_region_overlap and tools is not None and tools.alignment == "LEFT"
    return (tools.width if is_over and tools is not None and tools.width > 1 else 0) + margin, margin


def _set_size(size: float) -> None:
    import blf

    if bpy.app.version >= (4, 0, 0):
        blf.size(0, size)
    else:
        blf.size(0, round(size), 72)  # type: ignore[call-arg]  # the stubs are of 4.x


def _draw_text(text: str, x: float, y: float, colour: tuple[float, float, float, float]) -> None:
    import blf

    blf.color(0, *colour)
    blf.position(0, round(x), round(y), 0)
    blf.draw(0, text)
