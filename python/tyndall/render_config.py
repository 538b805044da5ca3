# SPDX-License-Identifier: GPL-3.0-or-later
"""Settings of a frame; the native side checks their ranges."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass, field

from . import _native
from .heterogeneity import Heterogeneity
from .neighbour_frames import Neighbours
from .scene_description import Camera
from .transfer_functions import WeightedFunction

METHODS = ("EXACT", "EPIPOLAR", "SHADOW_MAP")
GRID_METHODS = ("MARCH", "RATIO_TRACKING")
PIXEL_FILTERS = ("BOX", "GAUSSIAN", "BLACKMAN_HARRIS")
PASSES = (
    "Combined",
    "Depth",
    "Normal",
    "Position",
    "DiffCol",
    "Emit",
    "Shadow",
    "Shafts",
    "Shafts Visibility",
    "Transmittance",
    "AO",
    "Unshadowed",
    "Shadow Catcher",
    #: From here on by what sends light to the camera; light, not divided by the colour of what sends it.
    "DiffDir",
    "DiffInd",
    "GlossDir",
    "GlossInd",
    "TransDir",
    "TransInd",
    "Env",
    "GlossCol",
    "TransCol",
)
#: Names of planes; those of mattes have a number of two digits behind it.
DATA_PASSES = (
    "CryptoObject",
    "CryptoMaterial",
    "CryptoAsset",
    "IndexOB",
    "IndexMA",
    "UV",
    "Mist",
    "Debug Sample Count",
    "Denoising Normal",
    "Denoising Albedo",
    "Denoising Depth",
    "Vector",
)


@dataclass(frozen=True, kw_only=True)
class ShaftConfig:
    """How light shafts are found; the native side checks the ranges."""

    method: str = "EPIPOLAR"  #: One of METHODS.
    error_target: float = 0.002  #: Relative RMS error of the frame that EPIPOLAR picks its resolution by, [1e-5, 0.1].
    resolution: int = 0  #: Texels per side of rows and maps, [16, 16384]; 0: from error_target.
    light_samples: int = 16  #: Strata of a light with a size, [1, 65536].
    world_samples: int = 64  #: Directions of the world's light, [0, 65536]; 0: it does not scatter.
    attenuates_light: bool = True  #: False: no loss between light and scattering point (Kol 2018, eq. 5.1).
    adapts_strata: bool = False  #: light_samples and world_samples are the most; each takes what error_target asks for.
    #: Neighbouring pixels share the strata of lights that have more of them than a pixel has samples; never with EXACT.
    shares_strata: bool = True
    grid_method: str = "MARCH"  #: One of GRID_METHODS: how rays that meet density grids are integrated.
    grid_error_target: float = 0.005  #: Relative RMS error of what density grids scatter, [1e-4, 0.3]; of MARCH.
    #: Of SHADOW_MAP: rays towards or from a light, for which there are no rows, are as coarse as its map, too. Else
    #: they are exact, at the cost of 0.5 us per triangle where the first one comes.
    walks_maps: bool = False
    seed: int = 0
    #: Of several pictures whose mean is shown, to which strata of lights are dealt out: which samples of all this one
    #: has, first and end; how many there are; and how many pictures, or fewer.
    part: tuple[int, int, int, int] = (0, 1, 1, 1)
    #: Each of these is seen from another place: the errors of their rows average out, as those of strata do.
    part_has_own_view: bool = False


@dataclass(frozen=True, kw_only=True)
class IndirectConfig:
    """What surfaces see of one another, all off; the native side checks the ranges."""

    #: The world's light on surfaces is stopped by what stands within ambient_distance_m, and not by what is farther.
    ambient_occlusion: bool = False
    ambient_distance_m: float = 0.0  #: Of the AO pass, too, whether that is on or not; [0, 1e9], 0: any distance.
    ambient_samples: int = 4  #: Rays of the AO pass per camera ray, [1, 1024].
    #: One diffuse bounce: surfaces catch the light of lamps and world on other surfaces, and what these emit.
    bounce: bool = False
    bounce_samples: int = 0  #: Its rays per camera ray, [0, 1024]; 0: a pilot decides.
    mirror_depth: int = 0  #: Mirrors that a camera ray follows, one after another, [0, 64]; 0: what they show is black.
    #: Surfaces of the models BENT_GLASS_3, BENT_GLASS and REFRACTION that bend a camera ray, one after another,
    #: [0, 64]; 0: they are black. What they mirror counts among the mirrors.
    refraction_depth: int = 0


@dataclass(frozen=True, kw_only=True)
class DataConfig:
    """What passes tell that a picture does not need; the native side checks the ranges."""

    matte_ranks: int = 6  #: Names that a pixel's mattes tell apart, [1, 16]; two to a plane.
    asset_of: Mapping[str, str] = field(default_factory=dict)  #: By an object's name: the one that it belongs to.
    material_index: Mapping[str, float] = field(default_factory=dict)  #: By name; the others' is 0.
    #: Passes that materials fill: name, and whether it is a colour with alpha or a number.
    aovs: tuple[tuple[str, bool], ...] = ()
    mist_start_m: float = 5.0
    mist_depth_m: float = 25.0  #: 0: all is near.
    mist_exponent: float = 2.0  #: Of the way from one to the other.
    neighbours: Neighbours | None = None  #: Of the pass Vector, which is 0 without them.


@dataclass(frozen=True, kw_only=True)
class RenderConfig:
    """One frame's settings; the native side checks the ranges and raises ``InvalidInput``."""

    pixel_samples: int = 16  #: [1, 65536]; 1: pixel centres.
    #: Which of them this frame takes, the others being other frames', as a ``FilmMean`` averages them.
    first_sample: int = 0
    sample_count: int = 0  #: From the first one on; 0: all that there are.
    pixel_filter: str = "BLACKMAN_HARRIS"  #: One of PIXEL_FILTERS.
    filter_width_px: float = 1.5  #: As in Cycles, [0.01, 10].
    #: Pixels stop taking samples when their standard error falls below this times the square root of their mean, as in
    #: Cycles; [0, 1], 0: all of them take all samples. Of this frame's.
    noise_threshold: float = 0.0
    region_px: tuple[int, int, int, int] | None = None  #: x0, y0, x1, y1 in the full frame, y up; None: all of it.
    #: The region is a tile of a frame that others put together: bit for bit what the full frame has there.
    is_tile: bool = False
    #: Camera rays meet cubes of voxels no wider than so many pixels, as many of them as the voxels would stop, with the
    #: means of colours and normals; [0, 64], 0: they meet every voxel.
    voxel_detail_px: float = 0.5
    film_transparent: bool = False
    passes: frozenset[str] = frozenset()  #: Names in PASSES and DATA_PASSES; Combined is always there.
    #: Depth, position, normal, UV, motion and indices are of the first surface that lets no more pass than 1 less this;
    #: [0, 1], 0: of the first one there is.
    pass_alpha_threshold: float = 0.5
    data: DataConfig = field(default_factory=DataConfig)
    #: For each light group of the scene a plane "Combined_…", and where "Shafts" is asked for "Shafts_…".
    keeps_light_groups: bool = False
    shafts: ShaftConfig = field(default_factory=ShaftConfig)
    transfer_functions: tuple[WeightedFunction, ...] = ()  #: What they make of the light that media scatter.
    #: Name of the light whose visibility, lit parts and angle the functions are about. "": the strongest sun that
    #: scatters; without one, the mean over all lights, and the angle to the strongest lamp.
    reference_light: str = ""
    heterogeneity: Heterogeneity | None = None  #: The air's texture; None: media scatter evenly.
    indirect: IndirectConfig = field(default_factory=IndirectConfig)
    #: A pilot finds how many shadow rays each light is worth at a surface point; False: one, for the coarsest picture.
    adapts_shadow_rays: bool = True
    #: It may find lights that are not worth a ray at every sample: they are asked at every second or fourth alone, and
    #: what is shown on the way waits until each has had its turn.
    lights_take_turns: bool = False
    seed: int = 0
    thread_count: int = 0  #: 0: all.

    def region_size_px(self, camera: Camera) -> tuple[int, int]:
        """Width and height of what is rendered."""
        if self.region_px is None:
            return camera.size_px
        x0, y0, x1, y1 = self.region_px
        return max(x1 - x0, 0), max(y1 - y0, 0)


def index_of(names: tuple[str, ...], name: str, what: str) -> int:
    """The number of a name among those of a setting. Raises ``InvalidInput`` for others."""
    if name not in names:
        raise _native.InvalidInput(f'{what} is "{name}", not one of {", ".join(names)}')
    return names.index(name)


def native_shafts(
    config: ShaftConfig,
    kept_maps: _native.MapCache | None = None,
    room_bytes: int | None = None,
    kept_strata: _native.KeptStrata | None = None,
) -> _native.ShaftConfig:
    """``room_bytes``: for maps and rows. Raises ``InvalidInput`` for a method that does not exist."""
    indices = {
        "method": index_of(METHODS, config.method, "shafts.method"),
        "grid_method": index_of(GRID_METHODS, config.grid_method, "shafts.grid_method"),
    }
    return _native.ShaftConfig(
        **asdict(config) | indices, kept_strata=kept_strata, kept_maps=kept_maps, room_bytes=room_bytes
    )
