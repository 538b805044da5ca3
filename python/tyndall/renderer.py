# SPDX-License-Identifier: GPL-3.0-or-later
"""Renders scene descriptions: keeps native objects from frame to frame, so that only what changed is built again."""

from __future__ import annotations

import resource
from collections.abc import Callable
from dataclasses import asdict, dataclass, field
from time import perf_counter
from typing import Any

import numpy as np
from numpy.typing import NDArray

from . import _native
from .fingerprints import fingerprint
from .kept_pictures import UnstyledPictures
from .memory_estimate import fog_part, picture_part, require_room, room_left_by
from .native_camera import native_camera
from .native_data_passes import build_data_passes
from .native_heterogeneity import KeptAir
from .native_scene import KeptGeometry, NativeParts, light_scene, update_geometry
from .native_transfer_functions import build_weighted_functions
from .neighbour_frames import Neighbours, native_neighbours
from .render_config import (
    DATA_PASSES,
    GRID_METHODS,
    METHODS,
    PASSES,
    PIXEL_FILTERS,
    DataConfig,
    IndirectConfig,
    RenderConfig,
    ShaftConfig,
    index_of,
    native_shafts,
)
from .scene_description import Camera, FloatArray, SceneDescription

__all__ = [
    "DATA_PASSES",
    "GRID_METHODS",
    "METHODS",
    "PASSES",
    "PIXEL_FILTERS",
    "DataConfig",
    "Film",
    "IndirectConfig",
    "RenderConfig",
    "Session",
    "ShaftConfig",
]

_LIGHT_TREES_BYTES = 256 << 20  #: Of two million lights.


@dataclass(frozen=True, kw_only=True, eq=False)
class Film:
    """A picture: planes by name, float32 ``(height, width, channels)``, rows bottom to top."""

    planes: dict[str, FloatArray]
    #: ``stages`` (name, seconds), ``skipped`` (what, reason), ``counts`` (name: number), ``reports`` (lines); for JSON.
    statistics: dict[str, Any] = field(default_factory=dict)


class Session:
    """A scene in native memory. ``update`` brings it up to date, ``render`` makes a picture of it.

    Not for two threads at once; ``progress.cancel()`` may come from any thread.
    """

    def __init__(
        self,
        *,
        kept_pictures: int = 0,
        kept_maps_bytes: int = 0,
        kept_surfaces_bytes: int = 0,
        follows_moves: bool = False,
        keeps_trees: bool = False,
        builds_hastily: bool = False,
    ) -> None:
        """Keep nothing from picture to picture but the scene, or more of it.

        ``kept_pictures``: how many of the last are kept, so that changed transfer functions need no rays.
        ``kept_maps_bytes``: of lights' depth maps before their edits, and of slope rows, so that a changed edit costs
        its filters and its noise.
        ``kept_surfaces_bytes``: of what camera rays met in the last pictures and how it is lit, so that changed shafts
        trace no ray, and a changed light only its own. Pictures are the same, bit for bit.
        ``follows_moves``: the last description, so that an update that shares all but a few ``instances`` with it,
        which stand elsewhere, looks at these alone.
        ``keeps_trees``: where it does, and there are thousands, those over what did not move stay as they are. The only
        difference in pictures is which of two surfaces in one place shows.
        ``builds_hastily``: trees of large meshes, for a picture at once; call ``finish_trees`` before one that takes
        long.
        """
        self._unstyled = UnstyledPictures(kept_pictures)
        self._kept_maps: _native.MapCache | None = None
        if kept_maps_bytes > 0:
            self.keep_maps(kept_maps_bytes)
        self._kept_surfaces = _native.KeptSurfaces(kept_surfaces_bytes) if kept_surfaces_bytes > 0 else None
        self._kept_light_trees = _native.KeptLightTrees(_LIGHT_TREES_BYTES)
        self._kept_strata = _native.KeptStrata()
        self._parts = NativeParts(follows_moves=follows_moves, keeps_trees=keeps_trees, builds_hastily=builds_hastily)
        self._function_textures: dict[str, _native.Texture] = {}
        self._kept_air = KeptAir()
        self._scene: _native.Scene | None = None
        self._geometry: KeptGeometry | None = None
        self._lit_by = b""
        self._origin_in_world: NDArray[np.float64] = np.zeros(3)
        self._update_seconds = 0.0
        self._reports: list[str] = []
        self._light_names: list[str] = []
        self._light_groups: tuple[str, ...] = ()
        self._aov_programs: dict[str, dict[int, int]] = {}

    @property
    def statistics(self) -> dict[str, Any]:
        """What the last update sent, reused and rebuilt, and what it had to leave out."""
        return {
            "stages": [{"name": "scene update", "seconds": self._update_seconds}],
            "skipped": [],
            "counts": self._parts.counts.copy(),
            "reports": self._reports.copy(),
        }

    def update(self, description: SceneDescription, progress: _native.Progress) -> None:
        """Build what is new in the description; the rest, told by its keys, stays.

        A part that cannot be used is left out with a report that names it. Raises ``Cancelled``, after which the
        session holds the scene of the last complete update.
        """
        start = perf_counter()
        self._parts.begin_update()
        geometry = update_geometry(description, self._parts, progress)
        lit_by = fingerprint((description.lights, description.world, description.reports))
        if self._scene is None or geometry is not self._geometry or lit_by != self._lit_by:
            built = light_scene(description, geometry, self._parts)
            self._scene, self._origin_in_world, self._reports = built.scene, built.origin_in_world, built.reports
            self._light_names, self._aov_programs = built.light_names, built.aov_programs
            self._geometry, self._lit_by = geometry, lit_by
            self._light_groups = description.light_groups
            self._unstyled.clear()
        else:
            self._parts.count_all_as_reused()
        self._update_seconds = perf_counter() - start

    def render(
        self,
        camera: Camera,
        config: RenderConfig,
        progress: _native.Progress,
        on_update: Callable[[Film], None] | None = None,
    ) -> Film:
        """A picture of the scene as last updated; ``on_update`` gets the picture so far about twice a second.

        Raises ``InvalidInput``, which names the culprit, also of a picture that memory has no room for, and
        ``Cancelled``.
        """
        if self._scene is None:
            raise _native.InvalidInput("there is no scene to render: update the session first")
        kept = self._unstyled.find(camera, config)
        reports: list[str] = []
        functions = self._functions(config, reports)
        if kept is not None:
            start = perf_counter()
            planes = _native.restyle(kept, functions, progress)
            statistics = {
                "stages": [{"name": "transfer functions", "seconds": perf_counter() - start}],
                "skipped": [{"what": "rays", "reason": "only layers of transfer functions changed"}],
                "counts": {},
                "reports": reports,
            }
            return Film(planes=planes, statistics=statistics)
        groups = len(self._light_groups) if config.keeps_light_groups else 0
        size_px = config.region_size_px(camera)
        asked = [picture_part(size_px, config.passes, config.data, groups)]
        if self._scene.has_fog:
            asked.append(fog_part(size_px))
        require_room(asked)
        self._parts.texture_files.begin_picture()
        planes, native_statistics, unstyled = _native.render(
            self._scene,
            native_camera(camera, self._origin_in_world),
            self._native_config(
                config,
                functions,
                reports,
                keeps_unstyled=self._unstyled.capacity > 0,
                shafts_room_bytes=room_left_by(asked) if self._scene.has_fog else None,
            ),
            progress,
            None if on_update is None else lambda so_far: on_update(Film(planes=so_far)),
        )
        texture_counts = self._parts.texture_files.end_picture()
        if unstyled is not None:
            self._unstyled.keep(camera, config, unstyled)
        of_scene = self._scene.statistics.to_dict()
        if not (self._parts.counts["scene rebuilt"] or self._parts.counts["scene moved"]):
            of_scene["stages"] = []  # of another update
        parts = (self.statistics, of_scene, native_statistics.to_dict())
        merged = _merged(*parts)
        merged["reports"] += reports
        merged["counts"].update(texture_counts)
        merged["counts"]["picture's memory, at least, MiB"] = asked[0].at_least_bytes / (1 << 20)
        merged["counts"]["peak memory, MiB"] = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
        return Film(planes=planes, statistics=merged)

    @property
    def has_hasty_trees(self) -> bool:
        """Whether ``finish_trees`` has something to do."""
        return any(mesh.has_hasty_tree for mesh in self._parts.meshes.values())

    def finish_trees(self, progress: _native.Progress) -> None:
        """Pictures stay the same, but for which of two surfaces in one place shows. Raises ``Cancelled``."""
        for mesh in self._parts.meshes.values():
            mesh.finish_tree(progress)

    def has_picture(self, camera: Camera, config: RenderConfig) -> bool:
        """Whether ``render`` would only recolour a picture that is kept."""
        return self._unstyled.find(camera, config) is not None

    def ray_parameters(
        self, camera: Camera, config: RenderConfig, places_px: FloatArray, progress: _native.Progress
    ) -> FloatArray:
        """Where the rays through raster positions, (n, 2), y up, are in the first of ``config.transfer_functions``.

        (n, 2), [0, 1], over its x and y axis. Raises ``InvalidInput`` without a function, and ``Cancelled``.
        """
        if self._scene is None:
            raise _native.InvalidInput("there is no scene to ask: update the session first")
        found: FloatArray = _native.ray_parameters(
            self._scene,
            native_camera(camera, self._origin_in_world),
            self._native_config(config, self._functions(config, []), [], keeps_unstyled=False),
            np.ascontiguousarray(places_px, np.float32),
            progress,
        )
        return found

    def _native_config(
        self,
        config: RenderConfig,
        functions: list[_native.WeightedFunction],
        reports: list[str],
        *,
        keeps_unstyled: bool,
        shafts_room_bytes: int | None = None,
    ) -> _native.FrameConfig:
        reference_light = None
        if functions and config.reference_light in self._light_names:
            reference_light = self._light_names.index(config.reference_light)
        elif functions and config.reference_light:
            reports.append(
                f'Light "{config.reference_light}", which the transfer functions are about, is not drawn: they follow '
                "the strongest sun, or all lights"
            )
        return _native.FrameConfig(
            pixel_samples=config.pixel_samples,
            first_sample=config.first_sample,
            sample_count=config.sample_count,
            pixel_filter=index_of(PIXEL_FILTERS, config.pixel_filter, "pixel_filter"),
            filter_width_px=config.filter_width_px,
            noise_threshold=config.noise_threshold,
            region_px=config.region_px,
            is_tile=config.is_tile,
            voxel_detail_px=config.voxel_detail_px,
            film_transparent=config.film_transparent,
            passes=sorted(config.passes.difference(DATA_PASSES)),
            pass_alpha_threshold=config.pass_alpha_threshold,
            data=build_data_passes(
                config.data,
                sorted(config.passes.intersection(DATA_PASSES)),
                self._aov_programs,
                self._native_neighbours(config.data.neighbours, reports),
            ),
            light_groups=list(self._light_groups) if config.keeps_light_groups else [],
            shafts=native_shafts(config.shafts, self._kept_maps, shafts_room_bytes, self._kept_strata),
            transfer_functions=functions,
            reference_light=reference_light,
            heterogeneity=self._kept_air.build(config.heterogeneity, self._origin_in_world, reports),
            indirect=_native.IndirectConfig(**asdict(config.indirect)),
            kept_surfaces=self._kept_surfaces,
            kept_light_trees=self._kept_light_trees,
            adapts_shadow_rays=config.adapts_shadow_rays,
            lights_take_turns=config.lights_take_turns,
            keeps_unstyled=keeps_unstyled,
            seed=config.seed,
            thread_count=config.thread_count,
        )

    def _native_neighbours(self, neighbours: Neighbours | None, reports: list[str]) -> tuple[Any, Any] | None:
        if neighbours is None or self._scene is None:
            return None
        has_mesh = self._parts.meshes.__contains__
        count, origin = self._scene.instance_count, self._origin_in_world
        return native_neighbours(neighbours, has_mesh, count, origin, self.native_camera, reports)

    def _functions(self, config: RenderConfig, reports: list[str]) -> list[_native.WeightedFunction]:
        functions = config.transfer_functions
        return build_weighted_functions(functions, self._origin_in_world, self._function_textures, reports)

    def light_depth_picture(
        self, light_name: str, resolution: int, progress: _native.Progress
    ) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
        """A light's depth map before and after its occluder edits, (height, width), rows bottom to top.

        0 is nearest to the light, 1 farthest or nothing. ``resolution``: texels along the longer side, [16, 16384]; the
        six faces of a point light lie three by two. Edits along the view do not show. Of several lights of one name,
        the first. Raises ``InvalidInput``, which names the culprit, and ``Cancelled``.
        """
        scene, light = self.native_light(light_name)
        before, after = _native.light_depth_picture(scene, light, resolution, progress)
        return before, after

    def native_light(self, light_name: str) -> tuple[_native.Scene, int]:
        """The scene, and which of its lights has that name, of several the first; for calls that ask about a light."""
        if self._scene is None or light_name not in self._light_names:
            raise _native.InvalidInput(f'Light "{light_name}" is not in the scene, or cannot be used')
        return self._scene, self._light_names.index(light_name)

    def keep_maps(self, capacity_bytes: int) -> None:
        """As ``kept_maps_bytes`` of a new session, from now on, unless maps are kept already."""
        if self._kept_maps is None:
            self._kept_maps = _native.MapCache(capacity_bytes)

    @property
    def kept_maps(self) -> _native.MapCache | None:
        """For calls that look at the scene's occluders, too."""
        return self._kept_maps

    def native_camera(self, camera: Camera) -> _native.Camera:
        """The camera in the scene as last updated. Raises ``InvalidInput``."""
        return native_camera(camera, self._origin_in_world)


def _merged(*parts: dict[str, Any]) -> dict[str, Any]:
    counts: dict[str, float] = {}
    for part in parts:
        counts |= part["counts"]
    return {
        "stages": [stage for part in parts for stage in part["stages"]],
        "skipped": [entry for part in parts for entry in part["skipped"]],
        "counts": counts,
        "reports": list(dict.fromkeys(line for part in parts for line in part["reports"])),
    }
