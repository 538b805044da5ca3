# SPDX-License-Identifier: GPL-3.0-or-later
"""Scene descriptions without Blender, small enough to know every pixel of their pictures."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from tyndall.scene_description import (
    Camera,
    CameraKind,
    DensityGrid,
    Instances,
    Light,
    LightKind,
    Material,
    Mesh,
    SceneDescription,
    Volume,
)
from tyndall.volumes import SparseGrid


def translation(x: float, y: float, z: float) -> NDArray[np.float64]:
    matrix = np.eye(4)
    matrix[:3, 3] = (x, y, z)
    return matrix


def square(key: str = "square") -> Mesh:
    """[-1, 1]^2 in the plane z = 0, facing +Z."""
    return Mesh(
        key=key,
        name=key,
        positions=np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]], dtype=np.float32),
        triangles=np.array([[0, 1, 2], [0, 2, 3]], dtype=np.uint32),
        uv_maps=(("UVMap", np.array([[[0, 0], [1, 0], [1, 1]], [[0, 0], [1, 1], [0, 1]]], dtype=np.float32)),),
    )


def unit_cube() -> Mesh:
    """[-1, 1] x [-1, 1] x [0, 1], facing outwards."""
    quads = np.array([[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]])
    return Mesh(
        key="cube",
        name="cube",
        positions=np.array([[x, y, z] for z in (0, 1) for y in (-1, 1) for x in (-1, 1)], dtype=np.float32),
        triangles=quads[:, [0, 1, 2, 0, 2, 3]].reshape(12, 3).astype(np.uint32),
    )


def placed(mesh: Mesh, *matrices: NDArray[np.float64], materials: tuple[int, ...] = (0,)) -> Instances:
    """The mesh at each matrix, named "<mesh>.<index>"."""
    return Instances(
        mesh=mesh,
        world_from_object=np.stack(matrices),
        object_names=tuple(f"{mesh.name}.{index}" for index in range(len(matrices))),
        materials=materials,
    )


def sun(irradiance: float = 1.0) -> Light:
    """Straight down."""
    return Light(name="Sun", kind=LightKind.SUN, strength=(irradiance,) * 3, world_from_light=np.eye(4))


def random_smoke(medium: int = 0) -> Volume:
    """1.6 x 1.6 x 1.2 m of random voxels, from 0.2 m up."""
    values = np.random.default_rng(8).uniform(0.0, 1.0, (4, 8, 8, 8)).astype(np.float32)
    grid = SparseGrid(
        name="density",
        leaf_origins=np.array([[0, 0, 0], [8, 0, 0], [0, 8, 0], [8, 8, 0]], np.int32),
        leaf_values=values**3,
        local_from_index=translation(-0.8, -0.8, 0.2) @ np.diag([0.1, 0.1, 0.15, 1.0]),
        background=0.0,
    )
    kept = DensityGrid(key="random smoke", grid=grid)
    return Volume(name="cloud", grid=kept, world_from_object=np.eye(4), medium=medium)


def lit_square(**changes: object) -> SceneDescription:
    """A diffuse square (albedo 0.8) at the origin under a sun of 1 W/m^2."""
    parts: dict[str, object] = {
        "instances": (placed(square(), np.eye(4)),),
        "materials": (Material(name="grey"),),
        "lights": (sun(),),
    }
    return SceneDescription(**(parts | changes))  # type: ignore[arg-type]


def camera_above(place: NDArray[np.float64] | None = None, size_px: tuple[int, int] = (8, 8)) -> Camera:
    """Looks down from 5 m above the origin or another place; sees 4.5 m by 4.5 m of the ground."""
    return Camera(
        kind=CameraKind.PERSPECTIVE,
        world_from_camera=(np.eye(4) if place is None else place) @ translation(0, 0, 5),
        window=(-0.45, 0.45, -0.45, 0.45),
        clip_m=(0.1, 100.0),
        size_px=size_px,
    )
