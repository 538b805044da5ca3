# SPDX-License-Identifier: GPL-3.0-or-later
"""Whether the native module that was found fits this package: of two installed versions, each may find the other's."""

from __future__ import annotations

from pathlib import Path


def require_fit() -> None:
    """Raise RuntimeError, in words for whoever installed it, unless the native module takes what this package sends.

    Sends it one of everything, for a picture of one pixel, in some 60 ms of CPU time: a module of another version
    stumbles over an argument that it does not know, or lacks what it is asked for. ImportError: it does not load.
    """
    try:
        _render_one_of_everything()
    except (TypeError, AttributeError) as error:
        from . import _native  # noqa: PLC0415 - it may not load, which is another error

        raise RuntimeError(
            f"The native part in {Path(_native.__file__ or '').parent} is of another version than the package in "
            f"{Path(__file__).parent}: install Tyndall again, or build both anew, then restart Blender"
        ) from error


def _render_one_of_everything() -> None:
    import numpy as np  # noqa: PLC0415 - all of this needs the native module, and a load error explained needs none of it

    from . import Progress  # noqa: PLC0415
    from . import heterogeneity as air  # noqa: PLC0415
    from . import scene_description as scene  # noqa: PLC0415
    from . import transfer_functions as functions  # noqa: PLC0415
    from .renderer import RenderConfig, Session, ShaftConfig  # noqa: PLC0415

    image = scene.Image(key="image", name="image", pixels=np.ones((1, 1, 4), np.float32))
    use = scene.TextureUse(image=image)
    mask = scene.LightMask(name="mask", values=np.ones((1, 1), np.float32))
    edits = tuple(scene.OccluderEdit(name=kind.name, kind=kind, mask=mask) for kind in scene.EditKind)
    corners = np.array([[-1, -1, 0], [1, -1, 0], [0, 1, 0]], np.float32)
    mesh = scene.Mesh(key="mesh", name="mesh", positions=corners, triangles=np.array([[0, 1, 2]], np.uint32))
    description = scene.SceneDescription(
        instances=(
            scene.Instances(mesh=mesh, world_from_object=np.eye(4)[None], object_names=("mesh",), materials=(0,)),
        ),
        materials=(scene.Material(name="material", textures=(use,), medium=0),),
        media=(scene.Medium(name="medium", lobes=(scene.ScatterLobe(sigma_s_per_m=(0.1, 0.1, 0.1)),)),),
        lights=tuple(
            scene.Light(
                name=kind.name,
                kind=kind,
                strength=(1.0, 1.0, 1.0),
                world_from_light=np.eye(4),
                occluder_edits=edits,
                texture=None if kind is scene.LightKind.AREA else scene.LightTexture(use=use),
            )
            for kind in scene.LightKind
        ),
    )
    layers = tuple(
        functions.Layer(
            name=kind.name, kind=kind, ramp=((1.0,) * 4,) * 2, constraints=(functions.Constraint(),), image=image
        )
        for kind in functions.LayerKind
    )
    config = RenderConfig(
        pixel_samples=1,
        transfer_functions=(functions.WeightedFunction(function=functions.TransferFunction(name="", layers=layers)),),
        heterogeneity=air.Heterogeneity(noise=air.AirNoise(resolution=16)),
        shafts=ShaftConfig(resolution=16, light_samples=1, world_samples=1),
        thread_count=1,
    )
    camera = scene.Camera(
        kind=scene.CameraKind.PERSPECTIVE,
        world_from_camera=np.eye(4),
        window=(-0.5, 0.5, -0.5, 0.5),
        clip_m=(0.1, 10.0),
        size_px=(1, 1),
    )
    session = Session()
    session.update(description, Progress())
    session.render(camera, config, Progress())
