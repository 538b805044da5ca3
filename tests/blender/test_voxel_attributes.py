# SPDX-License-Identifier: GPL-3.0-or-later
"""What voxels keep of Blender's surfaces: colour attributes, and gloss, metal and glow of their materials."""

from __future__ import annotations

from collections.abc import Callable, Collection
from pathlib import Path

import bpy
import numpy as np
import pytest

from addon.properties.voxels import CHANNELS
from addon.sync.voxel_meshes import gather
from addon.sync.voxel_surfaces import glow_of
from addon.voxel_boxes import file_of
from support.engine_pictures import cycles_pixels, tyndall_pixels
from support.small_scenes import Build, Node, empty_scene, light, material, mesh, node
from tyndall.voxel_dag import VoxelDag, load

New, Link = Callable[[str], Node], Callable[..., object]
IS_4 = bpy.app.version >= (4, 0, 0)
SPECULAR = "Specular_IOR_Level" if IS_4 else "Specular"
EMISSION = "Emission_Color" if IS_4 else "Emission"
RESOLUTION = 64
#: Linear, of the corners of a square: what is between them is linear along x.
LEFT, RIGHT = (0.0, 1.0, 0.5, 1.0), (1.0, 0.25, 0.5, 0.5)


@pytest.fixture
def scene() -> bpy.types.Scene:
    return empty_scene()


def encoded(linear: np.ndarray) -> np.ndarray:
    """As sRGB's bytes have it."""
    linear = np.asarray(linear, float)
    return 255.0 * np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * np.maximum(linear, 0) ** (1 / 2.4) - 0.055)


def linear(encoded_bytes: np.ndarray) -> np.ndarray:
    """The inverse."""
    values = encoded_bytes / 255.0
    return np.where(values <= 0.04045, values / 12.92, ((values + 0.055) / 1.055) ** 2.4)


def square(
    surface: bpy.types.Material | None, name: str = "Tint", *, domain: str = "POINT", kind: str = "FLOAT_COLOR"
) -> bpy.types.Object:
    """Of 2 m, whose colour attribute goes from left to right."""
    corners = [(-1.0, -1.0, 0.0), (1.0, -1.0, 0.0), (1.0, 1.0, 0.0), (-1.0, 1.0, 0.0)]
    data = mesh("Square", corners, [(0, 1, 2, 3)], surface)
    data.uv_layers.new(name="UV")
    attribute = data.color_attributes.new(name, kind, domain)
    for index, element in enumerate(attribute.data):
        vertex = index if domain == "POINT" else data.loops[index].vertex_index
        element.color = RIGHT if corners[vertex][0] > 0.0 else LEFT
    thing = bpy.data.objects.new("Square", data)
    bpy.context.scene.collection.objects.link(thing)
    return thing


def voxelized(thing: bpy.types.Object, folder: Path, channels: Collection[str] = (), **settings: object) -> VoxelDag:
    bpy.context.view_layer.update()
    for other in bpy.context.view_layer.objects:
        other.select_set(other == thing)
    bpy.context.view_layer.objects.active = thing
    asked = bpy.context.scene.tyndall.voxelize
    asked.resolution, asked.path = str(RESOLUTION), str(folder / "made.tdag")
    for name in CHANNELS:
        setattr(asked, f"has_{name}", name in channels)
    for name, value in settings.items():
        setattr(asked, name, value)
    assert bpy.ops.tyndall.voxelize() == {"FINISHED"}
    return load(file_of(bpy.context.object))


def voxels_of(dag: VoxelDag) -> np.ndarray:
    return np.concatenate(list(dag.coordinates()))


def along(dag: VoxelDag) -> np.ndarray:
    """How far to the right voxels are, (k, 1)."""
    return (voxels_of(dag)[:, :1] + 0.5) / RESOLUTION


def ramp(dag: VoxelDag) -> np.ndarray:
    """The attribute in the middle of voxels, linear, (k, 4)."""
    return np.array(LEFT) + along(dag) * (np.array(RIGHT) - LEFT)


def of_attribute(name: str, *, by: str = "ShaderNodeVertexColor", output: str = "Color") -> Build:
    def build(new: New, link: Link) -> bpy.types.NodeSocket:
        reader, shader = new(by), new("ShaderNodeBsdfDiffuse")
        if by == "ShaderNodeVertexColor":
            reader.layer_name = name
        else:
            reader.attribute_name = name
        link(reader.outputs[output], shader.inputs["Color"])
        return shader.outputs[0]

    return build


# Colour attributes


@pytest.mark.parametrize("domain", ["POINT", "CORNER"])
@pytest.mark.parametrize("kind", ["FLOAT_COLOR", "BYTE_COLOR"])
@pytest.mark.parametrize(
    "reader", [("Tint", "ShaderNodeVertexColor"), ("", "ShaderNodeVertexColor"), ("Tint", "ShaderNodeAttribute")]
)
def test_voxels_have_the_colours_of_corners(
    scene: bpy.types.Scene, tmp_path: Path, domain: str, kind: str, reader: tuple[str, str]
) -> None:
    """As the material's node reads them: of whatever domain and type, by its name or as the active one."""
    name, by = reader
    dag = voxelized(square(material("Shown", of_attribute(name, by=by)), domain=domain, kind=kind), tmp_path)
    assert np.abs(dag.colors_at(voxels_of(dag)) - encoded(ramp(dag)[:, :3])).max() <= 1.0


def test_the_alpha_of_an_attribute_is_a_colour_too(scene: bpy.types.Scene, tmp_path: Path) -> None:
    """As nodes may use it."""
    dag = voxelized(square(material("Shown", of_attribute("Tint", output="Alpha"))), tmp_path)
    assert np.abs(dag.colors_at(voxels_of(dag)) - encoded(ramp(dag)[:, 3:])).max() <= 1.0


def test_of_several_attributes_the_one_for_renders_is_the_active_one(scene: bpy.types.Scene, tmp_path: Path) -> None:
    """Whatever their order; each is found by its name."""
    thing = square(material("Shown", of_attribute("")))
    other = thing.data.color_attributes.new("Other", "BYTE_COLOR", "CORNER")
    for element in other.data:
        element.color = (0.0, 0.0, 1.0, 1.0)
    thing.data.color_attributes.render_color_index = 1
    dag = voxelized(thing, tmp_path)
    assert (dag.colors_at(voxels_of(dag)) == [0, 0, 255]).all()
    thing.data.color_attributes.render_color_index = 0
    thing.hide_set(False)
    dag = voxelized(thing, tmp_path)
    assert np.abs(dag.colors_at(voxels_of(dag)) - encoded(ramp(dag)[:, :3])).max() <= 1.0


def test_without_a_material_the_colours_are_those_of_the_mesh(scene: bpy.types.Scene, tmp_path: Path) -> None:
    """As artists paint and scanners write them; a mesh without any is grey."""
    dag = voxelized(square(None), tmp_path)
    assert np.abs(dag.colors_at(voxels_of(dag)) - encoded(ramp(dag)[:, :3])).max() <= 1.0
    bare = square(None)
    bare.data.color_attributes.remove(bare.data.color_attributes[0])
    dag = voxelized(bare, tmp_path)
    assert np.abs(dag.colors_at(voxels_of(dag)) - encoded(0.8)).max() <= 0.51


def test_an_attribute_that_is_not_there_is_black_and_named(scene: bpy.types.Scene, tmp_path: Path) -> None:
    """As in Cycles."""
    dag = voxelized(square(material("Shown", of_attribute("Shade"))), tmp_path)
    assert (dag.colors_at(voxels_of(dag)) == 0).all()
    bpy.data.objects["Square"].hide_set(False)
    found = gather(bpy.context.evaluated_depsgraph_get(), [bpy.data.objects["Square"]])
    assert 'Object "Square": has no colour attribute "Shade", which its material reads: black' in found.reports.lines()


def checks(size: int = RESOLUTION) -> bpy.types.Image:
    """Linear floats, with a texel for each voxel."""
    created = bpy.data.images.new("Checks", size, size, float_buffer=True)
    texels = np.ones((size, size, 4), np.float32)
    texels[..., :3] = np.random.default_rng(1).uniform(0.0, 1.0, (size, size, 1))
    created.pixels.foreach_set(texels.ravel())
    return created


def texels_of(image: bpy.types.Image, dag: VoxelDag) -> np.ndarray:
    """At the voxels, (k, 1)."""
    size = image.size[0]
    pixels = np.array(image.pixels[:]).reshape(size, size, 4)[..., :1]
    voxels = voxels_of(dag)
    return pixels[voxels[:, 1] * size // RESOLUTION, voxels[:, 0] * size // RESOLUTION]


def picture_and_tint(image: bpy.types.Image, blend: str) -> Build:
    def surface(new: New, link: Link) -> bpy.types.NodeSocket:
        picture, tint, mix, shader = (
            new(kind)
            for kind in ("ShaderNodeTexImage", "ShaderNodeVertexColor", "ShaderNodeMixRGB", "ShaderNodeBsdfDiffuse")
        )
        picture.image, picture.interpolation, tint.layer_name, mix.blend_type = image, "Closest", "Tint", blend
        mix.inputs["Fac"].default_value = 1.0 if blend == "MULTIPLY" else 0.5
        link(picture.outputs["Color"], mix.inputs["Color1"])
        link(tint.outputs["Color"], mix.inputs["Color2"])
        link(mix.outputs["Color"], shader.inputs["Color"])
        return shader.outputs[0]

    return surface


def test_pictures_are_tinted_by_attributes(scene: bpy.types.Scene, tmp_path: Path) -> None:
    image = checks()
    dag = voxelized(square(material("Shown", picture_and_tint(image, "MULTIPLY"))), tmp_path)
    # Vertices are snapped to 1/256 of a voxel, and so of a texel.
    shown, expected = linear(dag.colors_at(voxels_of(dag))), texels_of(image, dag) * ramp(dag)[:, :3]
    assert np.abs(shown - expected).max() <= 0.012


def test_pictures_are_mixed_with_attributes(scene: bpy.types.Scene, tmp_path: Path) -> None:
    """Between the edges of texels of 8 voxels. Seen to fail: as a product."""
    image = checks(RESOLUTION // 8)
    dag = voxelized(square(material("Shown", picture_and_tint(image, "MIX"))), tmp_path)
    shown, expected = linear(dag.colors_at(voxels_of(dag))), 0.5 * (texels_of(image, dag) + ramp(dag)[:, :3])
    is_inside = ((voxels_of(dag)[:, :2] % 8 > 0) & (voxels_of(dag)[:, :2] % 8 < 7)).all(axis=1)
    assert np.abs(shown - expected)[is_inside].max() <= 0.012


# Channels


def of_principled(**inputs: object) -> Build:
    return lambda new, _link: node(new, "ShaderNodeBsdfPrincipled", **inputs).outputs[0]


def values(dag: VoxelDag) -> dict[str, list[int]]:
    """Of each channel, those that occur."""
    return {name: np.unique(dag.channel_at(name, voxels_of(dag))).tolist() for name in dag.channels}


def test_channels_are_those_of_the_principled_shader(scene: bpy.types.Scene, tmp_path: Path) -> None:
    """Numbers; emission as a share of the brightest; what is not chosen is not kept, and colours need not be."""
    glowing = {EMISSION: (1.0, 0.5, 0.0, 1.0), "Emission_Strength": 3.0}
    glossy = material("Glossy", of_principled(Roughness=0.2, Metallic=0.6, **{SPECULAR: 0.4}, **glowing))
    thing = square(glossy)
    dag = voxelized(thing, tmp_path, CHANNELS)
    assert dag.has_colors
    assert values(dag) == {"roughness": [51], "metallic": [153], "emission": [255], "reflectance": [102]}
    thing.hide_set(False)
    dag = voxelized(thing, tmp_path, channels={"metallic"}, has_colors=False)
    assert not dag.has_colors
    assert values(dag) == {"metallic": [153]}
    thing.hide_set(False)
    assert voxelized(thing, tmp_path, channels=set(), has_colors=True).channels == []


def test_closures_are_mixed_by_their_share(scene: bpy.types.Scene, tmp_path: Path) -> None:
    """Diffuse is rough, metal is Glossy; what is transparent has no gloss."""

    def build(new: New, link: Link) -> bpy.types.NodeSocket:
        mix, glossy, outer = new("ShaderNodeMixShader"), new("ShaderNodeBsdfGlossy"), new("ShaderNodeMixShader")
        mix.inputs[0].default_value, outer.inputs[0].default_value = 0.25, 0.5
        glossy.inputs["Roughness"].default_value = 0.2
        link(new("ShaderNodeBsdfDiffuse").outputs[0], mix.inputs[1])
        link(glossy.outputs[0], mix.inputs[2])
        link(mix.outputs[0], outer.inputs[1])
        link(new("ShaderNodeBsdfTransparent").outputs[0], outer.inputs[2])
        return outer.outputs[0]

    dag = voxelized(square(material("Mixed", build)), tmp_path, channels={"roughness", "metallic", "reflectance"})
    assert values(dag) == {"roughness": [round(255 * 0.8)], "metallic": [64], "reflectance": [32]}


def test_colours_are_those_of_what_scatters_or_bends_light(scene: bpy.types.Scene, tmp_path: Path) -> None:
    """By their share; voxels are opaque: what is transparent has none, and glass is its own. Seen to fail: the sum."""

    def build(new: New, link: Link) -> bpy.types.NodeSocket:
        glass, diffuse, inner, outer = (
            node(new, "ShaderNodeBsdfGlass", Color=(0.2, 0.4, 0.6, 1)),
            node(new, "ShaderNodeBsdfDiffuse", Color=(0.6, 0.4, 0.2, 1)),
            new("ShaderNodeMixShader"),
            new("ShaderNodeMixShader"),
        )
        inner.inputs[0].default_value, outer.inputs[0].default_value = 0.25, 0.5
        link(glass.outputs[0], inner.inputs[1])
        link(diffuse.outputs[0], inner.inputs[2])
        link(inner.outputs[0], outer.inputs[1])
        link(new("ShaderNodeBsdfTransparent").outputs[0], outer.inputs[2])
        return outer.outputs[0]

    thing = square(material("Mixed", build))
    dag = voxelized(thing, tmp_path)
    assert np.allclose(dag.colors_at(voxels_of(dag)), encoded(np.array((0.3, 0.4, 0.5))), atol=1.0)
    thing.hide_set(False)
    lines = gather(bpy.context.evaluated_depsgraph_get(), [thing]).reports.lines()
    assert lines == ('Material "Mixed": glass is opaque on voxels, in its colour',)
    clear = {"Base_Color": (0.3, 0.4, 0.5, 1), "Transmission_Weight" if IS_4 else "Transmission": 1.0, "Alpha": 0.5}
    dag = voxelized(square(material("Clear", of_principled(**clear))), tmp_path)
    assert np.allclose(dag.colors_at(voxels_of(dag)), encoded(np.array((0.3, 0.4, 0.5))), atol=1.0)


def test_channels_come_from_pictures_and_attributes(scene: bpy.types.Scene, tmp_path: Path) -> None:
    """Where the colour's pictures lie."""
    image = checks()

    def build(new: New, link: Link) -> bpy.types.NodeSocket:
        picture, tint, separate = (
            new("ShaderNodeTexImage"),
            new("ShaderNodeVertexColor"),
            new("ShaderNodeSeparateColor"),
        )
        shader = new("ShaderNodeBsdfPrincipled")
        picture.image, tint.layer_name = image, "Tint"
        link(picture.outputs["Color"], shader.inputs["Roughness"])
        link(tint.outputs["Color"], separate.inputs[0])
        link(separate.outputs[0], shader.inputs["Metallic"])
        return shader.outputs[0]

    dag = voxelized(square(material("Painted", build)), tmp_path, channels={"roughness", "metallic"})
    voxels = voxels_of(dag)
    assert np.abs(dag.channel_at("roughness", voxels) - 255 * texels_of(image, dag)[:, 0]).max() <= 3.0
    assert np.abs(dag.channel_at("metallic", voxels) - 255 * ramp(dag)[:, 0]).max() <= 1.0


# In pictures


@pytest.mark.parametrize("output", ["Color", "Alpha"])
def test_meshes_show_their_colours_as_in_cycles(scene: bpy.types.Scene, output: str) -> None:
    """Between corners, too."""
    scene.camera.data.ortho_scale = 1.8
    square(material("Shown", of_attribute("Tint", output=output)), domain="CORNER", kind="BYTE_COLOR")
    light("SUN", (0, 0, 1), energy=np.pi, angle=0.0)
    ours = tyndall_pixels(scene)
    assert np.ptp(ours[..., 0]) > 0.3
    difference = np.abs(ours - cycles_pixels(scene, 16, 1))
    assert np.median(difference) < 1e-4
    assert difference.max() < 0.01  # one of a pixel's 16 samples may lie anywhere in it


def test_glowing_voxels_glow_as_what_they_stand_for(scene: bpy.types.Scene, tmp_path: Path) -> None:
    """By their emission, in its hue and strength, whatever their own colour."""
    glow = {EMISSION: (1.0, 0.5, 0.1, 1.0), "Emission_Strength": 4.0, SPECULAR: 0.0}
    thing = square(material("Lamp", of_principled(**glow)))
    before = tyndall_pixels(scene)
    assert before.min() > 0.3
    voxelized(thing, tmp_path, channels={"emission"})
    assert np.allclose(tyndall_pixels(scene), before, rtol=0.01)


# Seen to fail where all glowed in the hue of what glows most.
def test_what_glows_in_different_colours_does_so_as_voxels(scene: bpy.types.Scene, tmp_path: Path) -> None:
    """Two lamps, a picture that glows, and a surface that does not: each as the mesh shows it, in the sun."""
    image = bpy.data.images.new("Screen", 32, 32, float_buffer=True)
    quarters = np.array([[[4, 0.2, 0, 1], [0, 3, 0.5, 1]], [[0.5, 0, 2, 1], [0, 0, 0, 1]]])
    image.pixels = np.kron(quarters, np.ones((16, 16, 1))).ravel().tolist()

    def screen(new: New, link: Link) -> bpy.types.NodeSocket:
        picture, glow = new("ShaderNodeTexImage"), new("ShaderNodeEmission")
        picture.image = image
        link(picture.outputs["Color"], glow.inputs["Color"])
        return glow.outputs[0]

    def lamp(color: tuple[float, ...], strength: float) -> Build:
        return lambda new, _: node(new, "ShaderNodeEmission", Color=color, Strength=strength).outputs[0]

    looks = (
        lamp((1.0, 0.1, 0.05, 1.0), 2.0),
        lamp((0.1, 0.3, 1.0, 1.0), 0.5),
        screen,
        lambda new, _: node(new, "ShaderNodeBsdfDiffuse", Color=(0.3, 0.6, 0.4, 1.0)).outputs[0],
    )
    corners = [(x, y, 0.0) for y in (-1.0, 0.0, 1.0) for x in (-1.0, 0.0, 1.0)]
    faces = [(0, 1, 4, 3), (1, 2, 5, 4), (3, 4, 7, 6), (4, 5, 8, 7)]
    data = mesh("Four", corners, faces)
    for number, look in enumerate(looks):
        data.materials.append(material(f"Look {number}", look))
        data.polygons[number].material_index = number
    for corner, place in zip(data.uv_layers.new(name="UV").data, 4 * [(0, 0), (1, 0), (1, 1), (0, 1)], strict=True):
        corner.uv = place
    thing = bpy.data.objects.new("Four", data)
    scene.collection.objects.link(thing)
    light("SUN", (0, 0, 1), energy=np.pi, angle=0.0)
    scene.camera.data.ortho_scale = 1.9
    before = tyndall_pixels(scene)
    assert len(np.unique(before.reshape(-1, 3).round(2), axis=0)) >= 6
    voxelized(thing, tmp_path, channels={"emission"})
    difference = np.abs(tyndall_pixels(scene) - before)
    assert np.median(difference) < 0.01
    assert (difference.max(axis=2) > 0.04).mean() < 0.12  # voxels on borders have the mean of both sides


def test_voxels_without_colours_say_that_they_glow_in_one(scene: bpy.types.Scene, tmp_path: Path) -> None:
    lamps = [
        square(material(name, of_principled(**{EMISSION: (*color, 1.0), "Emission_Strength": 2.0})))
        for name, color in (("Red", (1.0, 0.0, 0.0)), ("Blue", (0.0, 0.0, 1.0)))
    ]
    depsgraph = bpy.context.evaluated_depsgraph_get()
    told = "Emission: voxels without colours glow in one, that of what glows most"
    for has_colors, lines in ((False, (told,)), (True, ())):
        found = gather(depsgraph, lamps, channels=["emission"])
        glow = glow_of(found, has_colors=has_colors)
        assert (glow.hue is None) == has_colors
        assert found.reports.lines() == lines


def test_materials_read_channels_of_voxels_by_their_names(scene: bpy.types.Scene, tmp_path: Path) -> None:
    """Here roughness becomes the colour."""
    thing = square(material("Half", of_principled(Roughness=0.5)))
    voxelized(thing, tmp_path, channels={"roughness"})
    bpy.context.object.data.materials[0] = material("Rough", of_attribute("roughness", by="ShaderNodeAttribute"))
    light("SUN", (0, 0, 1), energy=np.pi, angle=0.0)
    # The voxels' white by their colours, 0.8, times what the material reads
    shown = tyndall_pixels(scene)
    assert np.allclose(shown, 0.8 * round(255 * 0.5) / 255, atol=0.005)


def test_metal_and_gloss_look_as_what_they_stand_for(scene: bpy.types.Scene, tmp_path: Path) -> None:
    """By the material that the voxels get. Seen to fail: as a diffuse one."""
    finish = {"Base_Color": (0.9, 0.6, 0.3, 1), "Roughness": 0.4, "Metallic": 0.8, SPECULAR: 0.7}
    thing = square(material("Brass", of_principled(**finish)))
    light("SUN", (0.3, 0.2, 1), energy=np.pi, angle=0.0)
    before = tyndall_pixels(scene)
    dag = voxelized(thing, tmp_path, channels={"roughness", "metallic", "reflectance"}, has_normals=True)
    assert set(dag.channels) == {"roughness", "metallic", "reflectance"}
    assert np.allclose(tyndall_pixels(scene), before, rtol=0.02)
    thing.hide_set(False)
    depsgraph = bpy.context.evaluated_depsgraph_get()
    told = 'Material "Brass": metal is diffuse, in its colour, unless voxels keep Metallic'
    assert gather(depsgraph, [thing]).reports.lines() == (told,)
    assert gather(depsgraph, [thing], channels=["metallic"]).reports.lines() == ()
