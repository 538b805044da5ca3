# SPDX-License-Identifier: GPL-3.0-or-later
"""A view of the rendered viewport that looks at nothing yet."""

from __future__ import annotations

import numpy as np

from addon.engine.viewport_worker import View
from tyndall.renderer import RenderConfig
from tyndall.scene_description import Camera, CameraKind


def a_view(width: int = 203, height: int = 101, samples: int = 4) -> View:
    camera = Camera(
        kind=CameraKind.PERSPECTIVE,
        world_from_camera=np.eye(4),
        window=(-1.0, 1.0, -0.5, 0.5),
        clip_m=(0.1, 100.0),
        size_px=(width, height),
    )
    return View(camera=camera, config=RenderConfig(pixel_samples=samples))
