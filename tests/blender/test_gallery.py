# SPDX-License-Identifier: GPL-3.0-or-later
"""Every scene of the gallery is made by its script and rendered small: each edit does what it is shown for.

Half of them on every push: the scenes of the others take minutes all together.
"""

from __future__ import annotations

import importlib
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType

import bpy
import numpy as np
import pytest
from numpy.typing import NDArray

from support.exr import read_planes

EXAMPLES = Path(__file__).parents[2] / "examples"
SIZE_PX = (160, 90)
SKY_M = 100.0  #: What is farther away is sky, in these scenes.

# What the scripts ask of Blender is the same in all versions; one is enough for what takes long.
pytestmark = pytest.mark.skipif(bpy.app.version[:2] != (4, 5), reason="made once, in bpy 4.5")


@dataclass
class Gallery:
    """Makes scenes and renders what media scatter in them."""

    module: ModuleType
    folder: Path

    def make(self, scene: str) -> None:
        """Run the script of a scene, without saving it."""
        importlib.import_module(scene).build()

    def shafts(self, picture: str) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """As a picture of the gallery shows them: (height, width, 3), rows bottom to top, and depth in m.

        Show what is saved first: what switches edits off does not switch them on again.
        """
        scene = bpy.context.scene
        self.module.set_up_render(SIZE_PX, 1)
        scene.tyndall.shafts.resolution = 2048
        bpy.context.view_layer.use_pass_z = True
        bpy.context.view_layer.tyndall.use_pass_shafts = True
        settings = scene.render.image_settings
        settings.file_format, settings.exr_codec, settings.color_depth = "OPEN_EXR_MULTILAYER", "NONE", "32"
        next(entry for entry in self.module.PICTURES if entry.name == picture).show()
        scene.render.filepath = str(self.folder / picture)
        bpy.ops.render.render(write_still=True)
        planes = {name.rpartition(".")[2]: plane for name, plane in read_planes(self.folder / f"{picture}.exr").items()}
        return planes["Shafts"].astype(float), planes["Depth"][..., 0].astype(float)


@pytest.fixture
def gallery(tmp_path: Path) -> Iterator[Gallery]:
    """The scripts lie in no package."""
    sys.path.insert(0, str(EXAMPLES))
    yield Gallery(importlib.import_module("gallery"), tmp_path)
    sys.path.remove(str(EXAMPLES))


def blurred(picture: NDArray[np.float64], width_px: int) -> NDArray[np.float64]:
    """Means over squares, of an odd width."""
    padded = np.pad(picture, width_px // 2, mode="edge")
    return np.lib.stride_tricks.sliding_window_view(padded, (width_px, width_px)).mean(axis=(2, 3))


def rms(values: NDArray[np.float64]) -> float:
    """Root of the mean square."""
    return float(np.sqrt((values**2).mean()))


def share_of_fine_detail(shafts: NDArray[np.float64], depth: NDArray[np.float64]) -> float:
    """What varies within three pixels, against what varies within eleven, before the open sky; of logarithms."""
    brightness = np.log(shafts.mean(axis=-1))
    broad = blurred(brightness, 3)
    nearest = np.lib.stride_tricks.sliding_window_view(np.pad(depth, 2, mode="edge"), (5, 5)).min(axis=(2, 3))
    in_sky = nearest > SKY_M
    fine, coarse = (brightness - broad)[in_sky], (broad - blurred(broad, 11))[in_sky]
    return rms(fine) / rms(coarse)


@pytest.mark.dealt
def test_filled_holes_calm_the_light_of_a_palms_crown(gallery: Gallery) -> None:
    gallery.make("palm_tree")
    calm, busy = (share_of_fine_detail(*gallery.shafts(name)) for name in ("palm_tree", "palm_tree_before"))
    assert calm < 0.8 * busy


@pytest.mark.long
def test_a_silhouette_that_is_drawn_out_darkens_the_air_around_a_figure(gallery: Gallery) -> None:
    gallery.make("scarecrow")
    (after, depth), (before, _) = (gallery.shafts(name) for name in ("scarecrow", "scarecrow_before"))
    around_figure = np.s_[30:70, 45:110]
    in_sky = depth[around_figure] > SKY_M
    ratio = (after / before).mean(axis=-1)[around_figure][in_sky].mean()
    assert ratio < 0.9


@pytest.mark.long
def test_filled_holes_and_lifted_shadows_of_a_turtle_change_nothing_but_its_shade(gallery: Gallery) -> None:
    gallery.make("turtle")
    (lifted, _), (filled, _), (before, _) = (
        gallery.shafts(name) for name in ("turtle_lifted", "turtle_filled", "turtle_before")
    )
    # Closing only takes light away; the map's texels and the sun's few samples move edges both ways.
    assert np.percentile(filled / before, 99) < 1.05
    assert filled.mean() < before.mean()
    # The function multiplies shade by up to 2.6, and leaves what is lit.
    gain = (lifted / filled).mean(axis=-1)
    assert gain.max() < 2.7
    dark = filled.mean(axis=-1) < np.percentile(filled.mean(axis=-1), 5)
    assert gain[dark].mean() > 1.2 * np.median(gain)


@pytest.mark.long
def test_holes_in_crowns_let_light_onto_a_flower_bed_and_drift_over_time(gallery: Gallery) -> None:
    gallery.make("flower_bed")
    first, later, before = (gallery.shafts(name)[0] for name in ("flower_bed_1", "flower_bed_9", "flower_bed_before"))
    assert first.mean() > 1.2 * before.mean()
    assert abs(later.mean() / first.mean() - 1.0) < 0.3
    assert np.abs(later - first).mean() > 0.05 * first.mean()


@pytest.mark.long
def test_a_citadels_shafts_reach_the_colours_that_were_painted_over_three_cameras(gallery: Gallery) -> None:
    gallery.make("citadel")
    citadel = importlib.import_module("citadel")
    names = [f"citadel_{name}" for name, _camera in gallery.module.CITADEL_VIEWS]
    fitted = [gallery.shafts(name)[0] for name in names]
    gallery.module.as_it_is()
    for (_name, _eye, _target, strokes), name, reached in zip(citadel.VIEWS, names, fitted, strict=True):
        white = gallery.shafts(name)[0]
        painted = citadel.painted(strokes)[1::3, 1::3]
        is_painted = painted[..., 3] > 0
        wanted = (white * painted[..., :3])[is_painted]
        size = rms(white[is_painted])
        assert rms(reached[is_painted] - wanted) < 0.2 * size
        assert rms(white[is_painted] - wanted) > 0.4 * size


@pytest.mark.dealt
def test_paint_gives_back_the_light_behind_a_skeleton_and_leaves_the_wisps_below_it(gallery: Gallery) -> None:
    gallery.make("skeleton_hall")
    painted, textured, even = (
        gallery.shafts(name)[0].mean(axis=-1)
        for name in ("skeleton_hall", "skeleton_hall_textured", "skeleton_hall_before")
    )
    behind_claws, below = np.s_[36:54, 80:110], np.s_[:25, :]
    assert np.median(textured[behind_claws]) < 0.2 * np.median(even[behind_claws])
    assert np.median(painted[behind_claws]) > 0.5 * np.median(even[behind_claws])
    # Fine paint has every ray ask for itself; without it rays share columns of air.
    assert rms(painted[below] - textured[below]) < 0.05 * rms(textured[below])
    is_lit = even[below] > 0.1 * even.max()
    assert np.std(textured[below][is_lit] / even[below][is_lit]) > 0.2


@pytest.mark.long
def test_paint_tones_the_glare_of_an_arbor_down_and_nothing_else(gallery: Gallery) -> None:
    gallery.make("arbor")
    ratio = np.divide(*(gallery.shafts(name)[0].mean(axis=-1) for name in ("arbor", "arbor_before")))
    assert ratio.max() < 1.0 + 1e-5
    left, right = ratio[:, :60], ratio[:, 90:]
    assert np.median(left) < 0.25
    assert np.median(right) > 0.95


@pytest.mark.long
def test_a_village_has_mist_in_its_lane_smoke_on_its_roofs_and_calm_light_below_its_belfry(gallery: Gallery) -> None:
    gallery.make("village_dawn")
    dawn = gallery.shafts("village_dawn")[0].mean(axis=-1)
    bpy.context.scene.tyndall.heterogeneity.seed = 5
    other_noise = gallery.shafts("village_dawn")[0].mean(axis=-1)
    even = gallery.shafts("village_dawn_before")[0].mean(axis=-1)
    lane, roofs, below_belfry = np.s_[:20, 100:112], np.s_[45:80, :40], np.s_[30:50, 75:90]
    assert np.median(dawn[lane]) > 2.0 * np.median(even[lane])
    assert (dawn[roofs] / even[roofs]).max() > 1.8
    # Where paint has taken the texture away, another noise hardly shows.
    assert np.median(np.abs(np.log(other_noise[below_belfry] / dawn[below_belfry]))) < 0.05
