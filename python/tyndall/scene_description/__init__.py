# SPDX-License-Identifier: GPL-3.0-or-later
"""A scene as plain arrays: what the Blender side writes and the native side reads. Knows neither.

Spaces: right-handed, +Z up, metres; one Blender unit is one metre, always. Matrices are float64 ``(4, 4)`` numpy arrays
indexed ``[row, column]`` that multiply column vectors. Colours are scene-linear Rec. 709.
Objects that carry a ``key`` are kept by the native session: the same key in the next frame promises the same content,
so nothing is sent again.
"""

from .arrays import FloatArray, Rgb
from .cameras import Camera, CameraKind, Lens, Panorama, PanoramaKind
from .geometry import (
    ALL_SETS,
    ATTRIBUTE_MARK,
    Instances,
    LightLinks,
    Mesh,
    ObjectLighting,
    PlacedObjects,
    StrandForm,
    StrandObjects,
    Strands,
    VoxelObjects,
    attribute_maps,
    hair_maps,
    point_maps,
)
from .images import Extension, Image, Interpolation
from .lights import Light, LightBody, LightKind, LightProjection, LightTexture, LitKinds, SpotFalloff, World
from .materials import (
    BumpShadowing,
    Code,
    Displacement,
    FacetDistribution,
    FilmSpectra,
    Gloss,
    LobeModel,
    Lobes,
    Material,
    SubsurfaceMethod,
    SurfaceOp,
    TextureUse,
)
from .media import DensityGrid, Medium, ScatterLobe, Volume
from .occluder_edits import EditKind, HoleNoise, KernelShape, LightMask, OccluderEdit
from .scene import SceneDescription

__all__ = [
    "ALL_SETS",
    "ATTRIBUTE_MARK",
    "BumpShadowing",
    "Camera",
    "CameraKind",
    "Code",
    "DensityGrid",
    "Displacement",
    "EditKind",
    "Extension",
    "FacetDistribution",
    "FilmSpectra",
    "FloatArray",
    "Gloss",
    "HoleNoise",
    "Image",
    "Instances",
    "Interpolation",
    "KernelShape",
    "Lens",
    "Light",
    "LightBody",
    "LightKind",
    "LightLinks",
    "LightMask",
    "LightProjection",
    "LightTexture",
    "LitKinds",
    "LobeModel",
    "Lobes",
    "Material",
    "Medium",
    "Mesh",
    "ObjectLighting",
    "OccluderEdit",
    "Panorama",
    "PanoramaKind",
    "PlacedObjects",
    "Rgb",
    "ScatterLobe",
    "SceneDescription",
    "SpotFalloff",
    "StrandForm",
    "StrandObjects",
    "Strands",
    "SubsurfaceMethod",
    "SurfaceOp",
    "TextureUse",
    "Volume",
    "VoxelObjects",
    "World",
    "attribute_maps",
    "hair_maps",
    "point_maps",
]
