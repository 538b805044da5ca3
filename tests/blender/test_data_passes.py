# SPDX-License-Identifier: GPL-3.0-or-later
"""Cryptomattes and the other passes that tell what pixels show: names, files and shares are Cycles'."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import bpy
import numpy as np
import pytest
from numpy.typing import NDArray

from support.exr import read_planes
from support.pass_pictures import PassPictures, render_passes
from support.small_scenes import Node, add, cube, empty_scene, light, material, node, plane
from tyndall._native import matte_hash

SIZE_PX = 48
KINDS = ("CryptoObject", "CryptoMaterial", "CryptoAsset")


@pytest.fixture
def stage() -> bpy.types.Scene:
    """A cube without a material on a floor, and before it a pane that covers 0.3 and belongs to the floor."""
    scene = empty_scene(SIZE_PX)
    scene.camera.location, scene.camera.rotation_euler = (0, -8, 6), (0.9, 0, 0)
    scene.camera.data.type = "PERSP"
    red = material(
        "Röd", surface=lambda new, _: node(new, "ShaderNodeBsdfDiffuse", Color=(0.5, 0.1, 0.1, 1)).outputs[0]
    )

    def pane(new: Callable[[str], Node], link: Callable[..., object]) -> bpy.types.NodeSocket:
        mix = node(new, "ShaderNodeMixShader", Fac=0.3)
        link(node(new, "ShaderNodeBsdfTransparent").outputs[0], mix.inputs[1])
        link(node(new, "ShaderNodeBsdfDiffuse").outputs[0], mix.inputs[2])
        return mix.outputs[0]

    floor = plane(material=red, half_side=3)
    floor.pass_index, red.pass_index = 5, 3
    box = cube("Box")
    box.location.z, box.pass_index = 1, 7
    glass = cube("Pane", material("Glass", surface=pane))
    glass.scale, glass.location, glass.parent = (1.5, 0.05, 1), (0.5, -2, 1.2), floor
    light("SUN", (0, 0, 5), energy=3.0)
    layer = scene.view_layers[0]
    for kind in ("object", "material", "asset"):
        setattr(layer, f"use_pass_cryptomatte_{kind}", True)
    return scene


def mattes(picture: PassPictures, kind: str, planes: int = 3) -> dict[float, NDArray[np.float64]]:
    """Shares of each pixel, (height, width), by id."""
    shares: dict[float, NDArray[np.float64]] = {}
    for index in range(planes):
        values = picture.planes[f"{kind}{index:02d}"].astype(np.float64)
        for rank in (0, 2):
            for found in np.unique(values[..., rank]):
                share = np.where(values[..., rank] == found, values[..., rank + 1], 0.0)
                if found != 0 and share.any():
                    shares[float(found)] = shares.get(float(found), 0.0) + share
    return shares


def id_of(name: str) -> float:
    bits = matte_hash(name)
    exponent = min(max(bits >> 23 & 0xFF, 1), 254)
    return float(np.array(bits & 0x807FFFFF | exponent << 23, np.uint32).view(np.float32))


def manifest(picture: PassPictures, layer_name: str) -> dict[str, str]:
    prefix = f"cryptomatte/{matte_hash(layer_name):08x}"[:19]
    assert picture.stamps[f"{prefix}/name"] == layer_name
    assert picture.stamps[f"{prefix}/hash"] == "MurmurHash3_32"
    assert picture.stamps[f"{prefix}/conversion"] == "uint32_to_float32"
    found: dict[str, str] = json.loads(picture.stamps[f"{prefix}/manifest"])
    return found


@pytest.mark.dealt
def test_mattes_are_those_of_cycles(stage: bpy.types.Scene, tmp_path: Path) -> None:
    """Ids equal, shares equal to the noise of Cycles, which two seeds tell; manifests name the same."""
    ours = render_passes(stage, tmp_path, "TYNDALL", 256)
    theirs = [render_passes(stage, tmp_path, "CYCLES", 256, seed=seed) for seed in (1, 2)]
    for kind in KINDS:
        mine, first, second = (mattes(picture, kind) for picture in (ours, *theirs))
        assert set(mine) == set(first)
        for found, share in mine.items():
            noise = np.abs(first[found] - second[found])
            # A pixel's two values differ by sqrt(2) of one's spread; ours on edges has some, too.
            spread = float(np.sqrt((noise**2).mean() / 2))
            both = (first[found] + second[found]) / 2
            assert float(np.sqrt(((share - both) ** 2).mean())) < 2 * spread + 1e-3
            assert share.mean() == pytest.approx(both.mean(), rel=0.005)
        names = manifest(ours, f"ViewLayer.{kind}")
        known = manifest(theirs[0], f"ViewLayer.{kind}")
        assert {name: known[name] for name in names} == names
        assert {id_of(name) for name in names} == set(mine)


def test_the_largest_share_comes_first_and_levels_are_planes(stage: bpy.types.Scene, tmp_path: Path) -> None:
    stage.view_layers[0].pass_cryptomatte_depth = 4
    ours = render_passes(stage, tmp_path, "TYNDALL", 16)
    assert {name for name in ours.planes if name.startswith("CryptoObject")} == {"CryptoObject00", "CryptoObject01"}
    shares = np.concatenate([ours.planes[f"CryptoObject{index:02d}"][..., 1::2] for index in range(2)], axis=2)
    assert (np.diff(shares, axis=2) <= 0).all()
    assert shares.sum(axis=2).max() == pytest.approx(1.0, abs=1e-5)


def test_the_matte_of_an_object_alone_is_alpha(stage: bpy.types.Scene, tmp_path: Path) -> None:
    stage.render.film_transparent = True
    for name in ("Plane", "Box"):
        bpy.data.objects[name].hide_render = True
    ours = render_passes(stage, tmp_path, "TYNDALL", 64)
    alpha = ours.planes["Combined"][..., 3]
    assert 0 < alpha.max() < 0.52  # the pane, twice
    assert mattes(ours, "CryptoObject")[id_of("Pane")] == pytest.approx(alpha, abs=1e-5)


def test_names_with_quotes_stand_in_the_manifest(stage: bpy.types.Scene, tmp_path: Path) -> None:
    bpy.data.objects["Box"].name = name = 'A "box"\\ö'
    assert name in manifest(render_passes(stage, tmp_path, "TYNDALL", 1), "ViewLayer.CryptoObject")


def test_what_shows_by_instances_has_the_name_of_the_instanced_object(stage: bpy.types.Scene, tmp_path: Path) -> None:
    """As in Cycles: the empty that instances a collection has no matte, nor is it the asset."""
    boxes = bpy.data.collections.new("Boxes")
    box = bpy.data.objects["Box"]
    boxes.objects.link(box)
    stage.collection.objects.unlink(box)
    for x in (-1.5, 1.5):
        placed = add(f"At {x}", None, (x, 0, 0))
        placed.instance_type, placed.instance_collection = "COLLECTION", boxes
    ours, theirs = (render_passes(stage, tmp_path, engine, 1) for engine in ("TYNDALL", "CYCLES"))
    for kind in ("CryptoObject", "CryptoAsset"):
        assert set(mattes(ours, kind)) == set(mattes(theirs, kind))
        assert id_of("Box") in mattes(ours, kind)


def test_the_cryptomatte_node_picks_an_object(stage: bpy.types.Scene, tmp_path: Path) -> None:
    """What the compositor writes in place of the picture is the object's share."""
    expected = mattes(render_passes(stage, tmp_path, "TYNDALL", 16), "CryptoObject")[id_of("Box")]
    if bpy.app.version >= (5, 0, 0):
        tree = bpy.data.node_groups.new("Picking", "CompositorNodeTree")
        stage.compositing_node_group = tree
        tree.interface.new_socket("Image", in_out="OUTPUT", socket_type="NodeSocketColor")
        output = tree.nodes.new("NodeGroupOutput")
    else:
        stage.use_nodes = True
        tree = stage.node_tree
        tree.nodes.clear()
        output = tree.nodes.new("CompositorNodeComposite")
    tree.nodes.new("CompositorNodeRLayers")  # without one, Blender 3.4 gives the other node nothing
    picker = tree.nodes.new("CompositorNodeCryptomatteV2")
    picker.source, picker.scene = "RENDER", stage
    picker.layer_name, picker.matte_id = "ViewLayer.CryptoObject", "Box"
    tree.links.new(picker.outputs["Matte"], output.inputs[0])
    stage.render.use_compositing = True
    settings = stage.render.image_settings
    if bpy.app.version >= (5, 0, 0):
        settings.media_type = "IMAGE"
    settings.file_format, settings.color_depth, settings.exr_codec = "OPEN_EXR", "32", "NONE"
    stage.render.filepath = str(tmp_path / "picked.exr")
    bpy.ops.render.render(write_still=True)
    picked = read_planes(tmp_path / "picked.exr")[""][..., 0]
    assert 0.05 < picked.mean() < 0.5
    assert picked == pytest.approx(expected, abs=1e-5)


@pytest.mark.parametrize("falloff", ["LINEAR", "QUADRATIC", "INVERSE_QUADRATIC"])
def test_mist_is_that_of_cycles(stage: bpy.types.Scene, tmp_path: Path, falloff: str) -> None:
    """At the pixels' centres, but for edges; behind the pane, Cycles' is noisy."""
    stage.view_layers[0].use_pass_mist = True
    mist = stage.world.mist_settings
    mist.start, mist.depth, mist.falloff = 6, 6, falloff
    ours, theirs = (
        render_passes(stage, tmp_path, engine, 64, is_filtered=False).planes["Mist"] for engine in ("TYNDALL", "CYCLES")
    )
    error = np.abs(ours - theirs)
    assert np.median(error) < 1e-6
    assert error.mean() < 0.005
    assert ours.max() == 1.0


def test_indices_and_uv_are_those_of_cycles_where_nothing_is_transparent(
    stage: bpy.types.Scene, tmp_path: Path
) -> None:
    bpy.data.objects["Pane"].hide_render = True
    layer = stage.view_layers[0]
    layer.use_pass_object_index = layer.use_pass_material_index = layer.use_pass_uv = True
    layer.tyndall.use_pass_sample_count = True
    ours, theirs = (
        render_passes(stage, tmp_path, engine, 1, is_filtered=False).planes for engine in ("TYNDALL", "CYCLES")
    )
    is_5 = bpy.app.version >= (5, 0, 0)
    names = ("Object Index", "Material Index") if is_5 else ("IndexOB", "IndexMA")
    for name in (*names, "UV"):
        differs = (np.abs(ours[name] - theirs[name]) > 1e-4).any(axis=2)
        assert differs.mean() < 0.005  # centres on an edge
    assert set(np.unique(ours[names[0]])) == {0, 5, 7}
    assert set(np.unique(ours[names[1]])) == {0, 3}
    assert ours["UV"][..., 2].max() == 1
    assert (ours["Debug Sample Count"] == 1).all()


# Seen to fail: with a threshold of a half, whatever the view layer's.
@pytest.mark.parametrize("threshold", [0.0, 0.25, 0.35])
def test_data_are_of_the_first_surface_that_covers_as_much_as_the_threshold(
    stage: bpy.types.Scene, tmp_path: Path, threshold: float
) -> None:
    """As in Cycles; the pane covers 0.3, and a veil nothing, which counts where the threshold is 0.

    Behind what does not count, Cycles finds something in the share of its samples that comes through.
    """
    veil = cube("Veil", material("Veil", lambda new, _: node(new, "ShaderNodeBsdfTransparent").outputs[0]))
    veil.scale, veil.location, veil.pass_index = (0.6, 0.05, 0.6), (-1.5, -2, 1.2), 4
    layer = stage.view_layers[0]
    layer.use_pass_z = layer.use_pass_normal = layer.use_pass_object_index = layer.use_pass_position = True
    layer.pass_alpha_threshold = threshold
    bpy.data.objects["Pane"].pass_index = 9
    ours, theirs = (
        render_passes(stage, tmp_path, engine, 1, is_filtered=False).planes for engine in ("TYNDALL", "CYCLES")
    )
    for name in ours:
        if name.split(".")[0] in {"Depth", "Normal", "Position", "Object Index", "IndexOB"}:
            differs = (np.abs(ours[name] - theirs[name]) > 1e-3).any(axis=2)
            assert differs.mean() < 0.01 or threshold > 0.3, name  # centres on an edge
    index = ours["Object Index" if bpy.app.version >= (5, 0, 0) else "IndexOB"]
    assert set(np.unique(index)) == {0, 5, 7} | ({9} if threshold < 0.3 else set()) | ({4} if threshold == 0 else set())


def test_the_sample_count_tells_where_pixels_stopped(stage: bpy.types.Scene, tmp_path: Path) -> None:
    stage.view_layers[0].tyndall.use_pass_sample_count = True
    render_passes(stage, tmp_path, "TYNDALL", 32)
    stage.tyndall.noise_threshold = 0.1
    stage.render.filepath = str(tmp_path / "noise.exr")
    bpy.ops.render.render(write_still=True)
    counts = read_planes(tmp_path / "noise.exr")["ViewLayer.Debug Sample Count"]
    assert set(np.unique(counts * 32 % 4)) == {0}
    assert counts.min() < 1.0
