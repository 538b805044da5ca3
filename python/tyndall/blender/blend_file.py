# SPDX-License-Identifier: GPL-3.0-or-later
"""A .blend file, opened in this process by bpy: its frames render with Tyndall, its objects become triangles."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import bpy

from . import ENGINE, enable, film_parts, last_statistics, was_interrupted
from .part_files import read_parts, read_stamps, write_part
from .voxel_meshes import gather, surface_of

if TYPE_CHECKING:
    from tyndall.command_line import Settings

_FORMATS = {
    ".exr": "OPEN_EXR",
    ".png": "PNG",
    ".tif": "TIFF",
    ".tiff": "TIFF",
    ".jpg": "JPEG",
    ".jpeg": "JPEG",
    ".hdr": "HDR",
    ".webp": "WEBP",
}


class OpenBlendFile:
    """Raises RuntimeError if the file cannot be opened, ValueError for settings that it cannot take."""

    def __init__(self, path: Path, settings: Settings) -> None:
        enable()
        _open(path)
        self._scene = _chosen_scene(settings.scene)
        self._multilayer = settings.multilayer
        self._scene.render.engine = ENGINE
        self._scene.render.use_persistent_data = True  # from frame to frame, only what changed is sent
        tyndall = self._scene.tyndall
        if settings.samples is not None:
            tyndall.pixel_samples = settings.samples
        if settings.threads is not None:
            tyndall.thread_count = settings.threads
        if settings.method is not None:
            tyndall.shafts.method = settings.method

    @property
    def frames(self) -> list[int]:
        """What renders if nobody says otherwise: the frame that the file was saved at."""
        return [self._scene.frame_current]

    def render(self, frame: int, path: Path) -> dict[str, Any]:
        """Write the picture of a frame to exactly this path, and return its statistics. Raises RuntimeError."""
        self._scene.frame_set(frame)
        _set_format(self._scene.render.image_settings, path.suffix.lower(), multilayer=self._multilayer)
        self._scene.render.use_file_extension = False
        self._scene.render.filepath = str(path)
        return self._rendered(writes=True)

    def render_part(self, frame: int, layer_name: str, tile: tuple[int, int, int, int], path: Path) -> dict[str, Any]:
        """Write the planes of a view layer's tile (column, row, columns, rows) as .npz, and return the statistics."""
        self._scene.frame_set(frame)
        self._scene.render.use_compositing = False  # that is for the whole frame
        parts = film_parts()
        with parts.taking(parts.Taking(self._scene.name, layer_name, parts.Tile(*tile))) as part:
            statistics = self._rendered(writes=False)
        write_part(path, part.films, statistics, part.stamps)
        return statistics

    def assemble(self, frame: int, tiles: Mapping[str, Sequence[Sequence[Path]]], path: Path) -> dict[str, Any]:
        """Write what the tiles of each view layer, row by row from below, are together: bit for bit as ``render``."""
        films, of_parts = read_parts(tiles)
        stamps = {layer: read_stamps(rows[0][0]) for layer, rows in tiles.items()}
        parts = film_parts()
        with parts.giving(parts.Giving(self._scene.name, films, {"parts": of_parts}, stamps)):
            return self.render(frame, path)

    @property
    def layer_names(self) -> list[str]:
        """Of the view layers that render."""
        return [layer.name for layer in self._scene.view_layers if layer.use]

    def why_not_in_parts(self, *, has_tiles: bool) -> str | None:
        """What keeps the scene from being put together of view layers, and of tiles; None: nothing."""
        render, name = self._scene.render, self._scene.name
        editor = self._scene.sequence_editor
        if render.use_sequencer and editor is not None and len(_strips(editor)) > 0:
            return (
                f'scene "{name}" renders its video sequence, which has no parts: turn Sequencer off in Post Processing'
            )
        if not has_tiles:
            return None
        if render.use_border:
            return (
                f'scene "{name}" renders a region of its frame: its light shafts are laid out for that, not for tiles'
            )
        air = self._scene.tyndall.heterogeneity
        if air.is_enabled and int(air.upsampling) > 1:
            return f'scene "{name}": the texture of its air is carried over the whole frame; set its upsampling to 1'
        return None

    def _rendered(self, *, writes: bool) -> dict[str, Any]:
        try:
            outcome = bpy.ops.render.render(write_still=writes, scene=self._scene.name)
        except RuntimeError:
            if was_interrupted():
                raise KeyboardInterrupt from None
            raise
        if "FINISHED" not in outcome:
            raise KeyboardInterrupt
        return last_statistics(self._scene.name) or {}


def _strips(editor: Any) -> Any:  # noqa: ANN401  named anew in 4.4
    return editor.strips if hasattr(editor, "strips") else editor.sequences


def read_triangles(
    path: Path,
    scene_name: str | None,
    resolution: int,
    with_colors: bool,  # noqa: FBT001
    with_normals: bool,  # noqa: FBT001
) -> Any:  # noqa: ANN401
    """Positions in metres, (n, 3) float64, and triangles, (m, 3) uint32, of all that the scene shows in renders.

    Third, settings of ``tyndall.voxel_dag.Config``: textures, the colours of materials, and smooth normals, where they
    are asked for. Modifiers and instances are applied. Raises RuntimeError if the file cannot be opened,
    ValueError for a scene that is not there or has no face.
    """
    enable()
    _open(path)
    scene = _chosen_scene(scene_name)
    with bpy.context.temp_override(scene=scene, view_layer=scene.view_layers[0]):
        mesh = gather(
            bpy.context.evaluated_depsgraph_get(), [thing for thing in scene.objects if not thing.hide_render]
        )
    positions_m, triangles, carried = surface_of(
        mesh, resolution=resolution, has_colors=with_colors, has_normals=with_normals
    )
    return positions_m, triangles, carried


def _chosen_scene(name: str | None) -> Any:  # noqa: ANN401  a scene with the add-on's properties
    if name is None:
        return bpy.context.scene
    if name not in bpy.data.scenes:
        names = ", ".join(f'"{known.name}"' for known in bpy.data.scenes)
        raise ValueError(f'there is no scene "{name}"; the file has {names}')
    return bpy.data.scenes[name]


def _open(path: Path) -> None:
    try:
        bpy.ops.wm.open_mainfile(filepath=str(path), load_ui=False)
    except RuntimeError:
        # Blender raises for warnings, too, such as a missing library, and has then opened the file.
        if not bpy.data.filepath or Path(bpy.data.filepath).resolve() != path.resolve():
            raise


def _set_format(settings: Any, suffix: str, *, multilayer: bool) -> None:  # noqa: ANN401  enums by version
    if multilayer and suffix != ".exr":
        raise RuntimeError("only an .exr holds several layers")
    if bpy.app.version >= (5, 0, 0):
        settings.media_type = "MULTI_LAYER_IMAGE" if multilayer else "IMAGE"
    settings.file_format = "OPEN_EXR_MULTILAYER" if multilayer else _FORMATS[suffix]
    if suffix == ".exr":
        settings.color_depth = "32"
