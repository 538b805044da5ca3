# SPDX-License-Identifier: GPL-3.0-or-later
"""A scene as plain arrays: what the Blender side writes and the native side reads. Knows neither.

Spaces: right-handed, +Z up, metres; one Blender unit is one metre, always. Matrices are float64 ``(4, 4)`` numpy arrays
indexed ``[row, column]`` that multiply column vectors. Colours are scene-linear Rec. 709.
Objects that carry a ``key`` are kept by the native session: the same key in the next frame promises the same content,
so nothing is sent again.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from enum import IntEnum
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from . import _native
    from .volumes import SparseGrid
    from .voxel_dag import VoxelDag

Rgb = tuple[float, float, float]
FloatArray = NDArray[np.float32]


ATTRIBUTE_MARK = "\x1f"  #: What no UV map's name begins with.


@dataclass(frozen=True, kw_only=True, eq=False)
class Mesh:
    """Triangles in object space. Normals and UVs are per corner of a triangle.

    What ``_native.shared_array`` made is shared with native code, any other array copied.
    """

    key: str
    name: str
    positions: FloatArray  #: (vertices, 3), metres.
    triangles: NDArray[np.uint32]  #: (triangles, 3), into positions.
    material_slots: NDArray[np.uint16] | None = None  #: (triangles,); None: all 0.
    corner_normals: FloatArray | None = None  #: (triangles, 3, 3), unit; None: flat shading.
    #: Name and (triangles, 3, 2), the active one first; then colours, likewise, as attribute_maps() names them.
    uv_maps: tuple[tuple[str, FloatArray], ...] = ()
    vertex_normals: FloatArray | None = None  #: (vertices, 3), smooth; asked for by what moves the mesh alone.


def attribute_maps(name: str) -> tuple[str, str]:
    """Names of two UV maps that are an attribute of a surface: red and green, blue and alpha, linear.

    "": the active one. Voxels have "Color" and the names of their channels, numbers as colours of three equal parts.
    """
    return f"{ATTRIBUTE_MARK}rg {name}", f"{ATTRIBUTE_MARK}ba {name}"


ALL_SETS = (1 << 64) - 1


@dataclass(frozen=True, kw_only=True)
class LightLinks:
    """Which sets of objects an emitter lights, and which cast its shadows: bit s is set s, of up to 64."""

    receiver_sets: int = ALL_SETS
    blocker_sets: int = ALL_SETS


@dataclass(frozen=True, kw_only=True)
class ObjectLighting:
    """How light meets an object, beside its visibility; most objects have none of it."""

    light_group: str = ""  #: Of what it emits; one of SceneDescription.light_groups, or none.
    receiver_set: int = 0  #: That emitters light, or do not.
    blocker_set: int = 0  #: That casts emitters' shadows, or does not.
    links: LightLinks | None = None  #: Of what it emits; None: all.


@dataclass(frozen=True, kw_only=True, eq=False)
class Instances:
    """Every placement of one mesh that shares a material assignment and flags."""

    mesh: Mesh
    world_from_object: NDArray[np.float64]  #: (count, 4, 4), affine, may mirror.
    object_names: tuple[str, ...]  #: count names, for reports.
    materials: tuple[int, ...]  #: Per material slot, into SceneDescription.materials.
    is_camera_visible: bool = True
    casts_shadow: bool = True
    is_bounce_visible: bool = True  #: Its light falls on other surfaces by a bounce.
    is_mirror_visible: bool = True
    is_glass_visible: bool = True  #: Through what bends rays.
    lights_media: bool = True  #: Its light falls on media.
    is_held_out: bool = False  #: What cameras see of it is cut out of the picture.
    is_shadow_catcher: bool = False  #: Of it cameras see only the shadows that others cast on it.
    lighting: ObjectLighting | None = None  #: None: as it begins.
    color: tuple[float, float, float, float] = (1.0, 1.0, 1.0, 1.0)  #: The object's own, for materials that ask.
    pass_index: float = 0.0
    random: NDArray[np.float32] | None = None  #: (count,) in [0, 1), for materials that ask; None: all 0.
    #: (count, 14), for materials that ask which particle each is: its index, a random number in [0, 1), age and
    #: lifetime in frames, size; location, velocity and angular velocity in the world. NaN: none. None: none is one.
    particles: NDArray[np.float32] | None = None
    #: (count, values, 4), for materials that ask what their instancer gives each: colours with alpha, as many for all
    #: groups that have some. None: all are 0.
    instancer_values: NDArray[np.float32] | None = None


@dataclass(frozen=True, kw_only=True, eq=False)
class VoxelObjects:
    """Every placement of the same voxels that shares a material and flags. Voxels are opaque."""

    dag: VoxelDag  #: Told by itself, not by its content: keep it from frame to frame. Its bounds are in object space.
    world_from_object: NDArray[np.float64]  #: (count, 4, 4), affine, may mirror.
    object_names: tuple[str, ...]  #: count names, for reports.
    material: int | None = None  #: Into SceneDescription.materials; None: grey.
    is_camera_visible: bool = True
    casts_shadow: bool = True
    is_bounce_visible: bool = True  #: Its light falls on other surfaces by a bounce.
    is_mirror_visible: bool = True
    is_glass_visible: bool = True  #: Through what bends rays.
    is_held_out: bool = False  #: What cameras see of it is cut out of the picture.
    is_shadow_catcher: bool = False  #: Of it cameras see only the shadows that others cast on it.
    lighting: ObjectLighting | None = None  #: None: as it begins.


class StrandForm(IntEnum):
    """How strands are drawn; native/scene/strands.hpp says what each is."""

    RIBBON = 0
    ROUND = 1
    ROUND_LINEAR = 2
    SPHERES = 3


@dataclass(frozen=True, kw_only=True, eq=False)
class Strands:
    """Hair in object space: smooth lines through points, each with a radius. Or, as SPHERES, points alone."""

    key: str
    name: str
    form: StrandForm
    points: FloatArray  #: (points, 4), metres: position and radius.
    first_points: NDArray[np.uint32]  #: (strands,), ascending from 0; of SPHERES empty.
    ribbon_pieces: int = 4  #: Straight pieces that a ribbon's segment is made of, [1, 16].
    #: As those of Mesh, with one (strands, 2) or (points, 2) each; of points straight between them.
    uv_maps: tuple[tuple[str, FloatArray], ...] = ()
    randoms: FloatArray | None = None  #: Likewise, [0, 1), for materials that ask.


def hair_maps() -> dict[str, str]:
    """Names of UV maps that only strands have: what materials may ask of them, two numbers each.

    ``axy`` and ``az``, the way along a strand, are followed by two digits, the corners of a triangle between which a
    mesh's way is.
    """
    return {name: f"{ATTRIBUTE_MARK}hair {name}" for name in ("is", "il", "rt", "xy", "z", "axy", "az")}


def point_maps() -> tuple[str, str, str]:
    """Names of UV maps that only point clouds have: x and y of a point's centre, its z and radius, random and 1."""
    return f"{ATTRIBUTE_MARK}point xy", f"{ATTRIBUTE_MARK}point zr", f"{ATTRIBUTE_MARK}point random"


@dataclass(frozen=True, kw_only=True, eq=False)
class StrandObjects:
    """Every placement of the same strands that shares a material and flags. Strands are opaque."""

    strands: Strands
    world_from_object: NDArray[np.float64]  #: (count, 4, 4), affine, may mirror.
    object_names: tuple[str, ...]  #: count names, for reports.
    material: int | None = None  #: Into SceneDescription.materials; None: grey.
    is_camera_visible: bool = True
    casts_shadow: bool = True
    is_bounce_visible: bool = True  #: Its light falls on other surfaces by a bounce.
    is_mirror_visible: bool = True
    is_glass_visible: bool = True  #: Through what bends rays.
    is_held_out: bool = False  #: What cameras see of it is cut out of the picture.
    is_shadow_catcher: bool = False  #: Of it cameras see only the shadows that others cast on it.
    lighting: ObjectLighting | None = None  #: None: as it begins.


class Image:
    """Pixels as Blender's ``Image.pixels`` orders them: rows bottom to top, RGBA, alpha unassociated.

    ``key``: the same key in the next frame promises the same content. uint8 is encoded as ``is_srgb`` says, float32 is
    scene-linear. What ``_native.shared_array`` made is shared with textures, any other array copied into each.
    """

    def __init__(
        self,
        *,
        key: str,
        name: str,
        pixels: NDArray[np.uint8] | NDArray[np.float32],
        is_srgb: bool = True,
        has_alpha: bool = False,
    ) -> None:
        self.key = key
        self.name = name
        self.is_srgb = is_srgb
        self.has_alpha = has_alpha
        self.shape: tuple[int, ...] = pixels.shape  #: (height, width, 4).
        self.is_float = pixels.dtype != np.uint8
        self.broken_pixel_count = 0  #: Of one in a file: those that were not finite, and are black.
        self._texels: NDArray[Any] | _native.TiledTexels = pixels

    @property
    def byte_count(self) -> int:
        """Of its texels."""
        return int(np.prod(self.shape)) * (4 if self.is_float else 1)

    @property
    def tiles(self) -> _native.TiledTexels | None:
        """Where it lies; None: in memory."""
        return None if isinstance(self._texels, np.ndarray) else self._texels

    @property
    def pixels(self) -> NDArray[Any]:
        """All of them; read from its file, anew each time, where it lies in one. Raises IoError."""
        return self._texels if isinstance(self._texels, np.ndarray) else self._texels.whole()

    def lie_in(self, tiles: _native.TiledTexels, broken_pixel_count: int) -> None:
        """Let go of the memory. The key changes: who has the old one keeps what it has."""
        # In this order: whoever reads both meanwhile has the old key of the new texels, which are the same.
        self.broken_pixel_count = broken_pixel_count
        self._texels = tiles
        self.key += f" in file {id(tiles.cache)}"


class Extension(IntEnum):
    """What lies outside of an image, in Blender's words."""

    REPEAT = 0
    EXTEND = 1
    CLIP = 2
    MIRROR = 3


class Interpolation(IntEnum):
    """How texels become a colour between their centres."""

    CLOSEST = 0
    LINEAR = 1
    CUBIC = 2  #: B-spline, Blender's Smart too.


class Code(IntEnum):
    """Operations of a surface program; native/shading/material.hpp says what each computes."""

    CONSTANT = 0
    TEXTURE = 1
    TEXTURE_ALPHA = 2
    MULTIPLY = 3
    ADD = 4
    SUBTRACT = 5
    MIX = 6
    CLAMP = 7
    AVERAGE = 8
    BACKFACING = 9
    UV = 10
    MATH = 11
    VECTOR_MATH = 12
    MAP_RANGE = 13
    VECTOR_ROTATE = 14
    AFFINE = 15
    CURVE = 20
    HUE_SATURATION = 21
    GAMMA = 22
    BLEND = 23
    COMBINE = 24
    SEPARATE = 25
    INPUT = 30
    FRESNEL = 31
    LAYER_WEIGHT = 32
    NORMAL_MAP = 33
    BUMP = 34
    NOISE = 40
    VORONOI = 41
    WAVE = 42
    MAGIC = 43
    GRADIENT = 44
    CHECKER = 45
    BRICK = 46
    MUSGRAVE = 47
    WHITE_NOISE = 48
    GABOR = 49
    IMAGE_AT = 60
    IMAGE_ALPHA_AT = 61
    ENVIRONMENT_AT = 62
    PHOTOMETRY = 63
    AMBIENT_OCCLUSION = 70
    BEVEL = 71


@dataclass(frozen=True, kw_only=True, eq=False)
class TextureUse:
    """One image as one node uses it."""

    image: Image
    extension: Extension = Extension.REPEAT
    interpolation: Interpolation = Interpolation.LINEAR


@dataclass(frozen=True, kw_only=True, eq=False)
class SurfaceOp:
    """One step of a surface program: ``register[out] = code(register[a], …, register[f])``."""

    code: Code
    out: int
    a: int = 0
    b: int = 0
    c: int = 0
    d: int = 0
    e: int = 0
    f: int = 0
    option: int = 0  #: Which of the operation's kinds.
    selector: int = 0  #: Which of its results.
    texture: int = 0  #: Into Material.textures.
    uv_map: int = 0  #: Into Material.uv_maps.
    table: int = 0  #: Into Material.tables.
    shift: int = 0  #: Where positions and UV maps are read: 0 at the point, 1 and 2 half a pixel beside it.
    value: Rgb = (0.0, 0.0, 0.0)
    uv_matrix: tuple[float, ...] = (1, 0, 0, 0, 1, 0, 0, 0, 1)  #: 3x3, row by row, applied to (u, v, 1).


@dataclass(frozen=True, kw_only=True, eq=False)
class Gloss:
    """What mirrors of a surface: shares of what comes along the mirrored ray. Weights already carry mix factors."""

    facing: Rgb = (0.0, 0.0, 0.0)  #: Seen straight; constants, used while the material's program is empty.
    edge: Rgb = (0.0, 0.0, 0.0)  #: At a grazing angle. A plain mirror has the same here; a metal 1.
    coat: Rgb = (0.0, 0.0, 0.0)  #: Weight of a clear layer, which mirrors by Fresnel's equations.
    coated: Rgb = (0.0, 0.0, 0.0)  #: Diffuse colour below that layer, in the light that it lets in.
    registers: tuple[int, int, int, int] = (0, 0, 0, 0)  #: Of these four.
    mirror_ior: float = 0.0  #: By which facing rises to edge: as a dielectric of that index, or, for 0, as metals.
    coat_ior: float = 1.5  #: Of the clear layer, at least 1.


class LobeModel(IntEnum):
    """A shader that is more than a diffuse share; its inputs are listed in native/shading/lobes/lobe_source.hpp."""

    OREN_NAYAR_3 = 0
    OREN_NAYAR = 1
    TRANSLUCENT = 2
    GLOSSY_3 = 3
    GLOSSY = 4
    METAL_F82 = 5
    CONDUCTOR = 6
    GLASS_3 = 7
    GLASS = 8
    VELVET = 9
    DIFFUSE_TOON = 10
    GLOSSY_TOON = 11
    PRINCIPLED_3 = 12
    PRINCIPLED = 13
    LAMBERT = 14
    PRINCIPLED_SHEEN = 15
    SHEEN = 16
    HAIR_OF_COLOUR = 17
    HAIR_OF_MELANIN = 18
    HAIR_OF_ABSORPTION = 19
    HAIR_REFLECTION = 20
    HAIR_TRANSMISSION = 21
    BENT_GLASS_3 = 22
    BENT_GLASS = 23
    REFRACTION = 24
    SUBSURFACE = 25
    PRINCIPLED_SUBSURFACE = 26
    PRINCIPLED_3_SUBSURFACE = 27


class BumpShadowing(IntEnum):
    """What bumps take from light that comes in flat; see native/shading/lobes/bump_shadowing.hpp."""

    NONE = 0
    SMOOTH = 1
    FACETS = 2


class SubsurfaceMethod(IntEnum):
    """How light gets from where it is seen to where it came in; see native/shading/lobes/subsurface.hpp."""

    NONE = 0
    PROFILE = 1
    COSINE_WALK = 2
    COSINE_SKIN_WALK = 3
    REFRACTED_WALK = 4
    SKIN_WALK = 5


class FacetDistribution(IntEnum):
    """How the normals of microfacets spread; see native/shading/lobes/lobe_source.hpp."""

    GGX = 0
    BECKMANN = 1
    ASHIKHMIN_SHIRLEY = 2


@dataclass(frozen=True, kw_only=True, eq=False)
class Lobes:
    """What one shader of a surface does beside Material's results. The first input is its share of the surface."""

    model: LobeModel
    inputs: tuple[Rgb, ...]  #: Numbers have three equal channels.
    registers: tuple[int, ...]  #: Of each input; below 0 the input itself counts.
    preserves_energy: bool = False  #: What microfacets hide from one another comes back, too.
    #: Registers of unit normals: of what is diffuse, of microfacets, of a coat; below 0 the point's own.
    normals: tuple[int, int, int] = (-1, -1, -1)
    bump_shadowing: BumpShadowing = BumpShadowing.NONE  #: Of what is diffuse around such a normal.
    subsurface: SubsurfaceMethod = SubsurfaceMethod.NONE  #: Of models that scatter below the surface.
    distribution: FacetDistribution = FacetDistribution.GGX
    #: Register of what facets are wide along, as long as the root of how much wider than across; below 0: nothing.
    tangent: int = -1


@dataclass(frozen=True, kw_only=True, eq=False)
class Material:
    """A surface program with three results, or three constants; and the medium inside, if any."""

    name: str
    has_surface: bool = True  #: False: light and view pass through (a fog box).
    diffuse: Rgb = (0.8, 0.8, 0.8)  #: Constants, used while ``program`` is empty.
    transparent: Rgb = (0.0, 0.0, 0.0)
    emission: Rgb = (0.0, 0.0, 0.0)
    held_out: float = 0.0  #: Share that is cut out of what cameras see: neither light nor cover.
    program: tuple[SurfaceOp, ...] = ()
    diffuse_register: int = 0
    transparent_register: int = 0
    emission_register: int = 0
    held_out_register: int | None = None  #: None: a program that holds out nothing.
    textures: tuple[TextureUse, ...] = ()
    uv_maps: tuple[str, ...] = ()  #: Names the program reads; "" is the active one.
    tables: tuple[NDArray[np.float32], ...] = ()  #: (steps, 4) each, RGBA over [0, 1].
    gloss: Gloss | None = None  #: What it mirrors; None: nothing.
    lobes: tuple[Lobes, ...] = ()
    #: Passes that it fills, by name: what programs of their own emit, less their diffuse part: neither is below 0.
    aovs: tuple[tuple[str, Material], ...] = ()
    displacement: Displacement | None = None  #: Sync has moved the meshes by it already.
    medium: int = -1  #: Into SceneDescription.media; -1: none.


@dataclass(frozen=True, kw_only=True, eq=False)
class Displacement:
    """How a material moves the vertices of its meshes, see displacement.py."""

    program: Material  #: What it emits is by how much, in the world.
    keeps_normals: bool = False  #: Those of before: a bump makes the surface's.


@dataclass(frozen=True, kw_only=True, eq=False)
class ScatterLobe:
    """Scattering with one Henyey-Greenstein phase function."""

    sigma_s_per_m: Rgb
    asymmetry_g: float = 0.0  #: (-1, 1); positive scatters forward.


@dataclass(frozen=True, kw_only=True, eq=False)
class Medium:
    """A participating medium: homogeneous in a mesh or in the world, and what a density of 1 is in a grid."""

    name: str
    lobes: tuple[ScatterLobe, ...] = ()
    sigma_a_per_m: Rgb = (0.0, 0.0, 0.0)
    emission_w_per_m3_sr: Rgb = (0.0, 0.0, 0.0)
    receiver_set: int = 0  #: As ObjectLighting's, of the objects that hold it.

    def sigma_t_per_m(self) -> Rgb:
        """Extinction coefficient."""
        red, green, blue = (
            absorbed + sum(lobe.sigma_s_per_m[channel] for lobe in self.lobes)
            for channel, absorbed in enumerate(self.sigma_a_per_m)
        )
        return red, green, blue


@dataclass(frozen=True, kw_only=True, eq=False)
class DensityGrid:
    """Densities in an object's space, trilinear between the centres of voxels; below 0 they are 0."""

    key: str
    grid: SparseGrid


@dataclass(frozen=True, kw_only=True, eq=False)
class Volume:
    """A density grid in the scene. The coefficients and the emission of its medium are those at density 1."""

    name: str
    grid: DensityGrid
    world_from_object: NDArray[np.float64]  #: (4, 4), affine, may mirror.
    medium: int  #: Into SceneDescription.media.
    density_scale: float = 1.0  #: Multiplies the densities, [0, 1e9].


class LightKind(IntEnum):
    """Where a light sends its light from."""

    SUN = 0
    POINT = 1
    SPOT = 2
    AREA = 3


class SpotFalloff(IntEnum):
    """How a spot fades towards its cone, which changed between Blender 3 and 4."""

    BLENDER_3 = 0
    BLENDER_4 = 1


class LightBody(IntEnum):
    """The shape of a point or spot light that has a radius."""

    FACING_DISC = 0
    SPHERE = 1


class EditKind(IntEnum):
    """What is done to the occluders before a light."""

    CLOSE = 0  #: Holes up to a size vanish.
    EPIPOLAR_CLOSE = 1  #: The same along the light's planes through the camera only: no halo in mid-air.
    SILHOUETTE = 2  #: Occluders grow away from the camera, behind what it sees of them.
    HOLES = 3  #: Thresholded Perlin noise.


class KernelShape(IntEnum):
    """Of the largest hole that CLOSE fills."""

    DISC = 0
    SQUARE = 1


@dataclass(frozen=True, kw_only=True)
class HoleNoise:
    """Perlin noise in the light's own metres; the native side checks the ranges."""

    scale_m: float = 1.0  #: Of its coarsest octave, (0, 1e6].
    octaves: int = 3  #: [1, 12]; each has twice the frequency of the one before.
    persistence: float = 0.5  #: [0, 1]: amplitude of an octave, of the one before.
    probability: float = 0.3  #: [0, 1]: share of holes.
    sway: float = 0.0  #: [0, 100]: how far the noise moves its own lookup, in units of scale_m; 0: none.
    turn_rad: float = 0.0  #: Turns the first lookup: over time, holes drift and change their form.
    seed: int = 0


@dataclass(frozen=True, kw_only=True, eq=False)
class LightMask:
    """A picture in the light's space: an edit works where it is at least 1/2, and not outside of it.

    Sun: size_m wide, upright along the light's axes, its middle on the line through the light's origin. Spot: as wide
    as its cone. Point: all directions, equirectangular around the light's Z.
    """

    name: str
    values: NDArray[np.float32]  #: (height, width), rows bottom to top, [0, 1].
    size_m: float = 10.0


@dataclass(frozen=True, kw_only=True, eq=False)
class OccluderEdit:
    """An edit of what stands between a light and the air; surfaces see the occluders as they are, unless it says so."""

    name: str
    kind: EditKind
    shape: KernelShape = KernelShape.DISC  #: CLOSE.
    #: CLOSE: diameter of the largest holes that vanish. EPIPOLAR_CLOSE: their length. SILHOUETTE: by how much.
    size_m: float = 0.1
    distance_m: float = 5.0  #: Lamps: sizes are measured this far from the light, and grow with the distance.
    noise: HoleNoise = field(default_factory=HoleNoise)  #: HOLES.
    affects_surfaces: bool = False  #: Surfaces see what it does, too: light through holes, the shadows of the others.
    objects: tuple[str, ...] | None = None  #: Names of the objects that it means; None: all.
    mask: LightMask | None = None


class LightProjection(IntEnum):
    """How a place in a light's space becomes a place in the picture that colours it."""

    PLANAR = 0  #: Sun: across the light, in metres.
    DIRECT = 1  #: Its first two components.
    PERSPECTIVE = 2  #: Those divided by the third: how a slide is thrown.
    SPHERE = 3  #: Longitude and latitude, as Cycles' ``map_to_sphere``.
    EMITTER = 4  #: Area light: where the light leaves it; its box along its axes is (0, 0) to (1, 1).
    DIRECTIONS = 5  #: As SPHERE, of a picture whose rows are an angle apart, without a seam.


@dataclass(frozen=True, kw_only=True, eq=False)
class LightTexture:
    """A picture that colours the beam of a light: its strength is multiplied by ``offset + gain @ picture``.

    ``PLANAR``: ``width_m`` wide, upright along the light's axes, its middle ``centre_m`` along them from the line
    through the light's origin. ``EMITTER``: the place on an area light, (u, v, 1), times ``uv_from_projected``. Else,
    of the direction in which the light leaves, or of the normal of the sphere that emits it: the unit vector along
    ``axes_from_world @ vector``, extended by 1, times ``place_from_axes``, projected to (u, v), extended by 1, times
    ``uv_from_projected``.
    """

    use: TextureUse
    projection: LightProjection = LightProjection.PLANAR
    width_m: float = 10.0
    centre_m: tuple[float, float] = (0.0, 0.0)
    follows_normal: bool = False
    axes_from_world: NDArray[np.float64] = field(default_factory=lambda: np.eye(3))  #: (3, 3)
    place_from_axes: NDArray[np.float64] = field(default_factory=lambda: np.eye(3, 4))  #: (3, 4)
    uv_from_projected: NDArray[np.float64] = field(default_factory=lambda: np.eye(3))  #: (3, 3), affine.
    offset: Rgb = (0.0, 0.0, 0.0)
    gain: NDArray[np.float64] = field(default_factory=lambda: np.eye(3))  #: (3, 3)
    #: Of lamps: times the distance d from where the light leaves to this power, 0 to 2, and d^2 / (d^2 + smooth_m2).
    distance_power: int = 0
    smooth_m2: float = 0.0


@dataclass(frozen=True, kw_only=True, eq=False)
class Light:
    """A light in radiometric units."""

    name: str
    kind: LightKind
    #: Sun: irradiance on a plane that faces it, W/m^2. Point and spot: radiant intensity, W/sr. Area: the same along
    #: its axis if it spread over half a turn, radiance times area; a pi-th of the watts that it sends, at any spread.
    strength: Rgb
    #: (4, 4); the light shines along its -Z; scale shapes a spot's cone and an area light's sides.
    world_from_light: NDArray[np.float64]
    half_angle_rad: float = 0.0  #: Sun: angular radius.
    radius_m: float = 0.0
    spot_half_angle_rad: float = 0.7
    spot_blend: float = 0.0
    spot_falloff: SpotFalloff = SpotFalloff.BLENDER_4
    body: LightBody = LightBody.SPHERE
    size_m: tuple[float, float] = (1.0, 1.0)  #: Area: along its X and Y, before the scale in its matrix; > 0.
    is_ellipse: bool = False  #: Area: an ellipse with these axes; else a rectangle.
    spread_rad: float = math.pi  #: Area: between the outermost directions in which it shines, [0, pi].
    casts_shadow: bool = True
    lights_surfaces: bool = True
    #: Shadows of its light show on shadow catchers; else it only brightens what they show.
    lights_catchers: bool = True
    scatters_in_media: bool = True
    occluder_edits: tuple[OccluderEdit, ...] = ()  #: In the order in which they are made.
    texture: LightTexture | None = None  #: Colours its beam.
    light_group: str = ""  #: One of SceneDescription.light_groups, or none.
    links: LightLinks | None = None  #: Which objects it lights, and which block it; None: all.
    #: Into SceneDescription.media: one in which it scatters nothing, and one that only dims, as much as that does.
    unlit_media: tuple[tuple[int, int], ...] = ()


@dataclass(frozen=True, kw_only=True, eq=False)
class World:
    """Radiance from infinity: a colour, times an equirectangular image if there is one."""

    name: str = "World"
    radiance: Rgb = (0.0, 0.0, 0.0)
    image: Image | None = None
    image_from_world: NDArray[np.float64] = field(default_factory=lambda: np.eye(3))  #: (3, 3) rotation.
    seen_image: Image | None = None  #: What cameras see in place of the image, without its light.
    seen_program: Material | None = None  #: Or the emission of this: its points are directions.
    medium: int = -1  #: Into SceneDescription.media: fills all space; -1: none.
    light_group: str = ""  #: One of SceneDescription.light_groups, or none.


class CameraKind(IntEnum):
    """How view rays leave the camera."""

    PERSPECTIVE = 0
    ORTHOGRAPHIC = 1
    PANORAMIC = 2


class PanoramaKind(IntEnum):
    """What the window of a panoramic camera means; (0, 0) is straight ahead."""

    EQUIRECTANGULAR = 0  #: Longitude and latitude, radians.
    FISHEYE_EQUIDISTANT = 1  #: Their length is the angle from ahead, radians.
    FISHEYE_EQUISOLID = 2  #: Their length is the sine of half the angle: lengths on a sensor by 2 focal lengths.
    FISHEYE_POLYNOMIAL = 3  #: Lengths on the sensor, in the unit of the polynomial.
    MIRROR_BALL = 4  #: Radii of the ball.
    EQUIANGULAR_CUBEMAP_FACE = 5  #: Angles to the right and up, each seen along the other axis, radians.
    CENTRAL_CYLINDRICAL = 6  #: Longitude, radians; height on a cylinder of radius 1.


@dataclass(frozen=True, kw_only=True)
class Panorama:
    """Where a panoramic camera looks."""

    kind: PanoramaKind = PanoramaKind.EQUIRECTANGULAR
    #: Of fisheyes and mirror balls: the longest way from (0, 0) that is shown; of a polynomial the largest angle.
    rim: float = math.inf
    #: Of a polynomial: radians, of the powers 0 to 4 of the radius.
    angle_by_radius: tuple[float, float, float, float, float] = (0.0, 0.0, 0.0, 0.0, 0.0)


@dataclass(frozen=True, kw_only=True)
class Lens:
    """What blurs that which is not in focus, as soon as a pixel has more than one sample.

    Shafts are seen through one point of it: pictures through several add up to their blur (lens_points.py).
    """

    radius_m: float  #: Of the circle around the aperture, above 0.
    focus_m: float  #: Along -Z (panoramic: along the ray), above 0.
    blades: int = 0  #: Sides of the aperture; fewer than 3: a disc.
    rotation_rad: float = 0.0  #: Of the blades.
    ratio: float = 1.0  #: Height of the aperture by its width, above 0.
    #: Where shafts are seen through, of a perspective camera's: a place of [0, 1)^2 whose equal areas are equal ones of
    #: the aperture. None: its middle.
    air_place: tuple[float, float] | None = None


@dataclass(frozen=True, kw_only=True, eq=False)
class Camera:
    """Sensor fit, shift and pixel aspect are already resolved into the window."""

    kind: CameraKind
    world_from_camera: NDArray[np.float64]  #: (4, 4), no scale; looks along -Z.
    #: Left, right, bottom, top: at 1 m (perspective), metres (orthographic), or in the panorama's units.
    window: tuple[float, float, float, float]
    clip_m: tuple[float, float]  #: Near and far, along -Z (panoramic: along the ray).
    size_px: tuple[int, int]  #: Width and height of the full frame.
    lens: Lens | None = None  #: None: all is sharp.
    panorama: Panorama = field(default_factory=Panorama)  #: Of a panoramic camera.


@dataclass(frozen=True, kw_only=True, eq=False)
class SceneDescription:
    """Everything but the camera. Equal keys of meshes and images mean equal content."""

    instances: tuple[Instances, ...] = ()
    voxel_objects: tuple[VoxelObjects, ...] = ()
    strand_objects: tuple[StrandObjects, ...] = ()
    materials: tuple[Material, ...] = ()
    media: tuple[Medium, ...] = ()
    volumes: tuple[Volume, ...] = ()
    lights: tuple[Light, ...] = ()
    world: World = field(default_factory=World)
    light_groups: tuple[str, ...] = ()  #: Names, each once: what pictures may hold apart.
    reports: tuple[str, ...] = ()  #: What the exporter replaced or left out, one line each, naming the culprit.
