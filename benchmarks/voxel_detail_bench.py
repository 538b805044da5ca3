# SPDX-License-Identifier: GPL-3.0-or-later
"""Level of detail of voxels in pictures: error and flicker beside time, in an animation of a camera that moves past.

12 frames of 160 x 90 pixels, sun and sky: each object is some 60 pixels high, so that 16 to 64 of its voxels lie
along a pixel. Per object, samples, and detail in pixels (0: every voxel is met):

  seconds    per frame, the median
  error      RMS difference to 256 samples of every voxel, of the mean light of what is seen
  flicker    RMS over pixels of that difference's standard deviation over frames
  change     the same of what changes from one frame to the next, the reference's change taken off

grille: wires, a fence and a checker one voxel thick, 2048 a side. foliage: leaves of 5 voxels in a ball, 1024 a side.
dragon: the Stanford dragon's surface with its normals, 4096 a side; without TYNDALL_SHARED_DATA it is left out.
"""

from __future__ import annotations

import argparse
import os
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from tyndall import Progress, voxel_dag
from tyndall.mesh_files import read_mesh
from tyndall.renderer import RenderConfig, Session
from tyndall.scene_description import (
    Camera,
    CameraKind,
    Light,
    LightKind,
    Material,
    SceneDescription,
    VoxelObjects,
    World,
)
from tyndall.voxel_dag import VoxelDag

_DATA = Path(os.environ.get("TYNDALL_SHARED_DATA", "../shared/data"))
_BOX = ((0.0, 0.0, 0.0), (1.0, 1.0, 1.0))
_FRAMES, _SIZE_PX = 12, (160, 90)
_SLAT = 12  #: Voxels, of 32.
_SKY = 0.3


def _grille() -> VoxelDag:
    side = 2048
    x, z = np.meshgrid(np.arange(side), np.arange(side), indexing="ij")
    third = 3 * x // side
    there = np.where(third == 0, (x % 64 == 0) | (z % 128 == 0), np.where(third == 1, x % 32 < _SLAT, (x + z) % 2 == 0))
    voxels = np.stack([x[there], np.full(there.sum(), side // 2), z[there]], -1)
    return voxel_dag.from_coordinates(voxels, voxel_dag.Config(resolution=side, bounds_m=_BOX))


def _foliage() -> VoxelDag:
    side, random = 1024, np.random.default_rng(3)
    centres = random.normal(0, 1, (60000, 3))
    centres *= (0.45 * random.random((60000, 1)) ** (1 / 3)) / np.linalg.norm(centres, axis=1, keepdims=True)
    middle = np.round((centres + 0.5) * side).astype(np.int64)
    axis = random.integers(0, 3, len(middle))
    leaf = np.array([(u, v) for u in range(-2, 3) for v in range(-2, 3)])
    voxels = np.repeat(middle[:, None], len(leaf), 1)
    for across in range(3):
        chosen = axis == across
        voxels[chosen, :, (across + 1) % 3] += leaf[:, 0]
        voxels[chosen, :, (across + 2) % 3] += leaf[:, 1]
    voxels = np.unique(voxels.reshape(-1, 3).clip(0, side - 1), axis=0)
    return voxel_dag.from_coordinates(voxels, voxel_dag.Config(resolution=side, bounds_m=_BOX))


def _dragon() -> VoxelDag | None:
    path = _DATA / "dragon/dragon_vrip.ply.gz"
    if not path.exists():
        return None
    positions, triangles = read_mesh(path)
    config = voxel_dag.Config(resolution=4096, normals="faces", normal_bits=12)
    return voxel_dag.voxelize(positions.astype(np.float32), triangles, config)


_OBJECTS: dict[str, Callable[[], VoxelDag | None]] = {"grille": _grille, "foliage": _foliage, "dragon": _dragon}


def _camera(dag: VoxelDag, frame: int) -> Camera:
    """On an arc around the object, a third of a pixel per frame or so at its middle."""
    lower, upper = (np.asarray(corner) for corner in dag.bounds_m)
    side = float(upper[0] - lower[0])
    turn, rise = 0.3 + 0.006 * frame, 0.15
    back = np.array([np.sin(turn) * np.cos(rise), -np.cos(turn) * np.cos(rise), np.sin(rise)])
    if _up_is_y(dag):
        back = back[[0, 2, 1]] * [1, 1, -1]
    up = np.array([0.0, 1.0, 0.0]) if _up_is_y(dag) else np.array([0.0, 0.0, 1.0])
    right = np.cross(up, back)
    right /= np.linalg.norm(right)
    place = np.eye(4)
    place[:3, :3] = np.stack([right, np.cross(back, right), back], -1)
    place[:3, 3] = (lower + upper) / 2 + 20.0 * side * back
    half = 0.5 / 20.0 * 1.35
    return Camera(
        kind=CameraKind.PERSPECTIVE,
        world_from_camera=place,
        window=(-half * 16 / 9, half * 16 / 9, -half, half),
        clip_m=(0.1 * side, 100.0 * side),
        size_px=_SIZE_PX,
    )


def _up_is_y(dag: VoxelDag) -> bool:
    return dag.resolution == 4096  # noqa: PLR2004 - the dragon's


def _session(dag: VoxelDag) -> Session:
    sun = np.eye(4)
    back = np.array([0.5, 0.6, 0.7]) if _up_is_y(dag) else np.array([0.5, -0.7, 0.6])
    back /= np.linalg.norm(back)
    right = np.cross([0.3, 0.2, 1.0], back)
    right /= np.linalg.norm(right)
    sun[:3, :3] = np.stack([right, np.cross(back, right), back], -1)
    session = Session()
    session.update(
        SceneDescription(
            voxel_objects=(VoxelObjects(dag=dag, world_from_object=np.eye(4)[None], object_names=("thing",)),),
            materials=(Material(name="white", diffuse=(0.8,) * 3),),
            lights=(Light(name="sun", kind=LightKind.SUN, strength=(3.0,) * 3, world_from_light=sun),),
            world=World(radiance=(_SKY,) * 3),
        ),
        Progress(),
    )
    return session


def _film(
    session: Session, dag: VoxelDag, config: RenderConfig, frames: int = _FRAMES
) -> tuple[NDArray[np.float64], float]:
    """Frames, and the median of their seconds."""
    pictures, seconds = [], []
    for frame in range(frames):
        begun = time.perf_counter()
        planes = session.render(_camera(dag, frame), config, Progress()).planes
        seconds.append(time.perf_counter() - begun)
        pictures.append(planes["Combined"][..., :3].mean(-1).astype(np.float64))
    return np.array(pictures), float(np.median(seconds))


def main() -> None:  # noqa: D103
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--objects", nargs="*", default=list(_OBJECTS), choices=list(_OBJECTS))
    parser.add_argument("--samples", nargs="*", type=int, default=[4, 16])
    parser.add_argument("--detail", nargs="*", type=float, default=[0.0, 0.25, 0.5, 1.0, 2.0])
    parser.add_argument("--pictures", type=Path, help="a folder: the first frames, as .npy")
    chosen = parser.parse_args()
    print("object   samples detail  seconds  error %  flicker %  change %")
    for name in chosen.objects:
        if (dag := _OBJECTS[name]()) is None:
            print(f"{name}: no data")
            continue
        session = _session(dag)
        exact = RenderConfig(pixel_samples=256, voxel_detail_px=0.0)
        truth, _ = _film(session, dag, exact)
        is_seen = np.abs(truth - _SKY).max(0) > _SKY / 100
        mean = truth[:, is_seen].mean()
        if chosen.pictures:
            np.save(chosen.pictures / f"{name}_truth.npy", truth[0])
        for samples in chosen.samples:
            for detail in chosen.detail:
                config = replace(exact, pixel_samples=samples, voxel_detail_px=detail)
                _film(session, dag, config, 1)
                film, seconds = _film(session, dag, config)
                if chosen.pictures:
                    np.save(chosen.pictures / f"{name}_{samples}_{detail}.npy", film[0])
                off = (film - truth)[:, is_seen]
                figures = (
                    np.sqrt((off**2).mean()),
                    np.sqrt((off.std(0) ** 2).mean()),
                    np.sqrt((np.diff(off, axis=0) ** 2).mean()),
                )
                shares = "  ".join(f"{100 * figure / mean:7.2f}" for figure in figures)
                print(f"{name:8} {samples:7} {detail:6.2f} {seconds:8.3f}  {shares}", flush=True)


if __name__ == "__main__":
    main()
