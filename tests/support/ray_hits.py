# SPDX-License-Identifier: GPL-3.0-or-later
"""Renders a square that fills the left half of the view, and prints the share of view rays that hit it: 0.5.

Where the module's calls bind to a foreign Embree, nothing fails: every ray misses, and the share is 0.
"""

import numpy as np

import tyndall
from tyndall.renderer import RenderConfig, Session
from tyndall.scene_description import Camera, CameraKind, Instances, Material, Mesh, SceneDescription

SIZE_PX = 16


def share_of_hits() -> float:
    """Share of pixels with a finite depth."""
    square = Mesh(
        key="square",
        name="square",
        positions=np.array([[-1, -1, -1], [0, -1, -1], [0, 1, -1], [-1, 1, -1]], np.float32),
        triangles=np.array([[0, 1, 2], [0, 2, 3]], np.uint32),
    )
    placed = Instances(mesh=square, world_from_object=np.eye(4)[None], object_names=("square",), materials=(0,))
    camera = Camera(
        kind=CameraKind.PERSPECTIVE,
        world_from_camera=np.eye(4),
        window=(-1.0, 1.0, -1.0, 1.0),
        clip_m=(0.1, 100.0),
        size_px=(SIZE_PX, SIZE_PX),
    )
    session = Session()
    progress = tyndall.Progress()
    session.update(SceneDescription(instances=(placed,), materials=(Material(name="grey"),)), progress)
    film = session.render(camera, RenderConfig(pixel_samples=1, passes=frozenset({"Depth"})), progress)
    return float(np.mean(film.planes["Depth"] < 2.0))


print(f"share of hits: {share_of_hits()}")
