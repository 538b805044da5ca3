# SPDX-License-Identifier: GPL-3.0-or-later
"""What the pictures of the guide to light shafts have done to the examples: a tool is used, a control is turned."""

from __future__ import annotations

import colorsys
from pathlib import Path

import bpy
import numpy as np
from scene_kit import emission, paint_air

ROOT = Path(__file__).resolve().parent.parent
SIZE_PX = (640, 360)


def sun() -> bpy.types.Light:
    """The scene's only one."""
    return next(thing.data for thing in bpy.context.scene.objects if thing.type == "LIGHT" and thing.data.type == "SUN")


def add_edit(kind: str, **settings: object) -> bpy.types.PropertyGroup:
    """Add an edit of the sun's occluders; settings of the noise are given as they are called there."""
    edits = sun().tyndall.occluder_edits
    edit = edits.add()
    edit.name, edit.kind, edit.order = kind, kind, len(edits)
    for name, value in settings.items():
        setattr(edit.noise if hasattr(edit.noise, name) else edit, name, value)
    return edit


def colour(preset: str) -> None:
    """Recolour the shafts by a transfer function made of a preset."""
    bpy.ops.tyndall.transfer_function_preset(preset=preset)


def focus(distance_m: float, lens_steps: int) -> None:
    """With a lens of 6 cm, so that what is farther blurs."""
    scene = bpy.context.scene
    lens = scene.camera.data
    lens.dof.use_dof, lens.dof.focus_distance = True, distance_m
    lens.dof.aperture_fstop = lens.lens * 1e-3 / 0.06
    scene.tyndall.shafts.lens_steps, scene.tyndall.pixel_samples = lens_steps, 64


def polish_floor() -> None:
    """A third of the light that meets the hall's floor is mirrored, lit air included."""
    scene = bpy.context.scene
    tree = bpy.data.objects["Floor"].data.materials[0].node_tree
    output = next(node for node in tree.nodes if node.type == "OUTPUT_MATERIAL")
    stone = output.inputs["Surface"].links[0].from_socket
    mix, polish = tree.nodes.new("ShaderNodeMixShader"), tree.nodes.new("ShaderNodeBsdfGlossy")
    mix.inputs[0].default_value, polish.inputs["Roughness"].default_value = 0.35, 0.0
    tree.links.new(stone, mix.inputs[1])
    tree.links.new(polish.outputs[0], mix.inputs[2])
    tree.links.new(mix.outputs[0], output.inputs["Surface"])
    scene.tyndall.indirect.has_mirrors = True


def show_frame(frame: int) -> None:
    """Go to a frame of an animated example."""
    bpy.context.scene.frame_set(frame)


def alarm_at_dawn() -> None:
    """Give the terrain, which has functions of its own, the one of the other scenes."""
    scene = bpy.context.scene
    scene.tyndall.shafts.transfer_states.clear()
    colour("ALARM")
    scene.frame_set(25)


def stained_glass(size_px: int = 512, pane_count: int = 60) -> bpy.types.Image:
    """Panes of coloured glass between strips of lead, which tile."""
    random = np.random.default_rng(4)
    centres = random.random((pane_count, 2))
    hues = random.choice([0.0, 0.08, 0.12, 0.38, 0.6, 0.63, 0.8], pane_count)
    colours = np.array([colorsys.hsv_to_rgb(hue, 0.95, 1.0) for hue in hues])
    axis = (np.arange(size_px) + 0.5) / size_px
    places = np.stack(np.meshgrid(axis, axis), axis=-1).reshape(-1, 1, 2)
    away = np.abs(places - centres)
    distance = np.hypot(*np.moveaxis(np.minimum(away, 1.0 - away), -1, 0))
    nearest = np.argsort(distance, axis=1)[:, :2]
    gap = np.take_along_axis(distance, nearest, axis=1)
    pixels = np.ones((size_px * size_px, 4), np.float32)
    pixels[:, :3] = colours[nearest[:, 0]] * np.clip((gap[:, 1] - gap[:, 0]) / 0.02 - 0.5, 0.0, 1.0)[:, None]
    image = bpy.data.images.new("Stained Glass", size_px, size_px)
    image.pixels.foreach_set(pixels.ravel())
    return image


def breakup(size_px: int = 512) -> bpy.types.Image:
    """Blades of light that turn around the middle, as a sheet of metal throws them."""
    y, x = np.mgrid[0:size_px, 0:size_px] / size_px * 2.0 - 1.0
    radius, angle = np.hypot(x, y), np.arctan2(y, x)
    is_open = (np.sin(7.0 * angle + 5.0 * radius) > 0.15) & (radius > 0.12) & (radius < 0.95)
    pixels = np.ones((size_px, size_px, 4), np.float32)
    pixels[..., :3] = is_open[..., None]
    image = bpy.data.images.new("Breakup", size_px, size_px)
    image.pixels.foreach_set(pixels.ravel())
    return image


def throw_blades() -> None:
    """Put the same gobo into every spot."""
    image = breakup()
    for thing in bpy.context.scene.objects:
        if thing.type == "LIGHT" and thing.data.type == "SPOT":
            thing.data.tyndall.gobo_image = image


def throw_cells() -> None:
    """Put cracks before every spot, by nodes: Normal with x and y divided by z, cells of a Voronoi, and a ramp."""
    for thing in bpy.context.scene.objects:
        if thing.type != "LIGHT" or thing.data.type != "SPOT":
            continue
        thing.data.use_nodes = True
        tree = thing.data.node_tree
        emission = next(node for node in tree.nodes if node.type == "EMISSION")
        normal, parts = tree.nodes.new("ShaderNodeTexCoord"), tree.nodes.new("ShaderNodeSeparateXYZ")
        place, cells = tree.nodes.new("ShaderNodeCombineXYZ"), tree.nodes.new("ShaderNodeTexVoronoi")
        tree.links.new(normal.outputs["Normal"], parts.inputs[0])
        for axis in ("X", "Y"):
            by_depth = tree.nodes.new("ShaderNodeMath")
            by_depth.operation = "DIVIDE"
            tree.links.new(parts.outputs[axis], by_depth.inputs[0])
            tree.links.new(parts.outputs["Z"], by_depth.inputs[1])
            tree.links.new(by_depth.outputs[0], place.inputs[axis])
        cells.feature, cells.inputs["Scale"].default_value = "DISTANCE_TO_EDGE", 9.0
        ramp = tree.nodes.new("ShaderNodeValToRGB")
        ramp.color_ramp.elements[0].position, ramp.color_ramp.elements[1].position = 0.1, 0.16
        tree.links.new(place.outputs[0], cells.inputs["Vector"])
        tree.links.new(cells.outputs["Distance"], ramp.inputs[0])
        tree.links.new(ramp.outputs["Color"], emission.inputs["Color"])


def throw_glass(size_m: float) -> None:
    """Have the sun throw panes of stained glass."""
    settings = sun().tyndall
    settings.gobo_image, settings.gobo_size_m, settings.gobo_extension = stained_glass(), size_m, "REPEAT"


#: Strokes over the hall: middle and radius, as shares of the frame's width from its lower left corner, and a colour.
STROKES = (
    ((0.10, 0.25), 0.07, (1.0, 0.12, 0.05)),
    ((0.30, 0.32), 0.05, (0.1, 0.9, 0.25)),
    ((0.42, 0.33), 0.04, (0.15, 0.35, 1.0)),
)


def paint_shafts() -> None:
    """Paint over the hall what its shafts shall be like, and have the sun's map fitted to it."""
    scene = bpy.context.scene
    scene.render.engine = "TYNDALL"
    scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage = *SIZE_PX, 100
    bpy.context.view_layer.objects.active = next(thing for thing in scene.objects if thing.data == sun())
    bpy.ops.tyndall.paint_strokes()
    strokes = sun().tyndall.light_map_fit.views[0].strokes
    width, height = strokes.size
    pixels = np.zeros((height, width, 4), np.float32)
    places = np.stack(np.meshgrid(np.arange(width), np.arange(height)), axis=-1) / width
    for middle, radius, colour in STROKES:
        pixels[np.hypot(*np.moveaxis(places - middle, -1, 0)) < radius] = (*colour, 1.0)
    strokes.pixels.foreach_set(pixels.ravel())
    strokes.update()
    bpy.ops.tyndall.fit_light_map()


#: Strokes over beams of the stage: the spot, its place and a place farther along it in the picture, as shares of its
#: width and height from the lower left corner.
BEAMS = (("Back 2", (0.327, 0.832), (0.13, 0.49)), ("Back 5", (0.697, 0.852), (0.83, 0.5)))


def paint_beams() -> None:
    """Paint two beams of the stage as fans of five blades, red and dark, and have the spots' maps fitted to that."""
    scene = bpy.context.scene
    scene.render.engine = "TYNDALL"
    scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage = *SIZE_PX, 100
    for name, lamp, far in BEAMS:
        spot = scene.objects[name]
        bpy.context.view_layer.objects.active = spot
        bpy.ops.tyndall.paint_strokes()
        strokes = spot.data.tyndall.light_map_fit.views[0].strokes
        width, height = strokes.size
        columns, rows = np.meshgrid(np.arange(width), np.arange(height))
        across, up = columns - lamp[0] * width, rows - lamp[1] * height
        axis = np.array([(far[0] - lamp[0]) * width, (far[1] - lamp[1]) * height])
        along, beside = (across * axis[0] + up * axis[1]), (across * axis[1] - up * axis[0])
        blade = np.floor(beside / np.maximum(along, 1.0) / BLADE + 0.5)
        is_painted = (along > 0.0) & (np.abs(blade) <= 2.0)
        pixels = np.zeros((height, width, 4), np.float32)
        pixels[is_painted] = (0.0, 0.0, 0.0, 1.0)
        pixels[is_painted & (blade % 2.0 == 0.0)] = (4.0, 0.25, 0.05, 1.0)
        strokes.pixels.foreach_set(pixels.ravel())
        strokes.update()
        bpy.ops.tyndall.fit_light_map()


#: Tangent of the angle that a blade has in the picture.
BLADE = 0.06


def let_light_bounce(*, with_shafts: bool = False) -> None:
    """Have Cycles draw indirect light, too; with its own fog, or with light shafts over a picture without fog."""
    scene = bpy.context.scene
    scene.cycles.device, scene.cycles.samples = "CPU", 16
    scene.cycles.max_bounces = scene.cycles.diffuse_bounces = 4
    if with_shafts:
        bpy.ops.tyndall.over_engine_set_up()
        bpy.ops.tyndall.leave_fog()


def paint_one_shaft() -> None:
    """Dim the hall's shafts but the one that falls on the table, with dust in it: by paint in the air."""
    scene = bpy.context.scene
    scene.render.engine = "TYNDALL"
    bpy.ops.tyndall.add_painted_box(voxels=128)
    scene.tyndall.heterogeneity.amount = 0.0
    scene.tyndall.heterogeneity.scale_m = 0.8
    shaft_m = [(-5.5, -3.7, 5.7), (-0.4, -6.5, 0.9)]
    scene.tyndall.air_brush.volume, scene.tyndall.air_brush.intensity = "INTENSITY", 0.12
    bpy.ops.tyndall.painted_air_fill()
    paint_air(shaft_m, "INTENSITY", 5.0, 1.6)
    paint_air(shaft_m, "AMOUNT", 1.0, 1.6)


def texture(preset: str, **settings: object) -> None:
    """Give the air a preset's texture, with some of its settings changed."""
    bpy.ops.tyndall.preset_apply(filepath=str(ROOT / "addon" / "presets" / "air" / f"{preset}.py"))
    for name, value in settings.items():
        setattr(bpy.context.scene.tyndall.heterogeneity, name, value)


def draft() -> None:
    """Spend what a small picture needs."""
    settings = bpy.context.scene.tyndall
    settings.pixel_samples, settings.heterogeneity.upsampling = 8, "2"
    settings.shafts.light_samples, settings.shafts.error_target = 16, 0.01


def turn_medium(*, density_factor: float = 1.0, asymmetry_g: float | None = None, attenuates: bool = True) -> None:
    """Make the example's fog thicker or thinner, have it scatter another way, or let light through it undimmed."""
    bpy.context.scene.tyndall.shafts.attenuates_light = attenuates
    fog = bpy.data.materials["Fog"].node_tree.nodes["Volume Scatter"].inputs
    fog["Density"].default_value *= density_factor
    if asymmetry_g is not None:
        fog["Anisotropy"].default_value = asymmetry_g


def lay_banks() -> None:
    """Have the world's volume in place of the fog box: banks near the floor, by nodes."""
    bpy.context.scene.objects["Fog Box"].hide_render = True
    tree = bpy.context.scene.world.node_tree
    new, link = tree.nodes.new, tree.links.new
    place, height, falls = new("ShaderNodeNewGeometry"), new("ShaderNodeSeparateXYZ"), new("ShaderNodeMapRange")
    noise, wisps, banks = new("ShaderNodeTexNoise"), new("ShaderNodeMapRange"), new("ShaderNodeMath")
    fog = new("ShaderNodeVolumeScatter")
    falls.inputs["From Max"].default_value = 6.0  # metres
    falls.inputs["To Min"].default_value, falls.inputs["To Max"].default_value = 0.25, 0.02
    noise.inputs["Scale"].default_value = 0.6
    wisps.inputs["From Min"].default_value, wisps.inputs["From Max"].default_value = 0.42, 0.6
    banks.operation = "MULTIPLY"
    fog.inputs["Anisotropy"].default_value = 0.3
    link(place.outputs["Position"], height.inputs["Vector"])
    link(place.outputs["Position"], noise.inputs["Vector"])
    link(noise.outputs[0], wisps.inputs["Value"])
    link(height.outputs["Z"], falls.inputs["Value"])
    link(falls.outputs["Result"], banks.inputs[0])
    link(wisps.outputs["Result"], banks.inputs[1])
    link(banks.outputs["Value"], fog.inputs["Density"])
    link(fog.outputs["Volume"], tree.nodes["World Output"].inputs["Volume"])


def use_function(preset: str, use: str) -> None:
    """Have one function used another way; where it replaces the shafts, it is about as bright as they are."""
    colour(preset)
    function = bpy.context.scene.tyndall.shafts.transfer_states[0].function.tyndall
    function.use, function.strength = use, 0.25


def smoke(frame: int = 1, **settings: object) -> None:
    """Fill the stage's beams with smoke that shows each of its settings."""
    wisps = {"scale_m": 0.7, "octaves": 5, "persistence": 0.5, "contrast": 2.0, "level": 0.0, "amount": 1.0}
    texture("Drifting_Smoke", **{**wisps, **settings})
    bpy.context.scene.frame_set(frame)


def paint_stage(volume: str, value: float) -> None:
    """Paint the middle of the stage's smoke, from its floor to its lamps."""
    smoke()
    bpy.ops.tyndall.add_painted_box(voxels=96)
    paint_air([(0.0, 2.0, 0.5), (0.0, 3.5, 6.0)], volume, value, 2.2)


def become_voxels(resolution: int) -> None:
    """All that has a surface, with its colours."""
    for thing in bpy.context.scene.objects:
        thing.select_set(thing.visible_get())
    settings = bpy.context.scene.tyndall.voxelize
    settings.resolution, settings.path = str(resolution), str(Path(bpy.app.tempdir) / "voxels.tdag")
    bpy.ops.tyndall.voxelize()


def show_pass(name: str) -> None:
    """Write one of the render's passes instead of the picture; shares of 1 as they are, without a film's curve."""
    scene = bpy.context.scene
    if name != "Shafts":
        view = scene.view_settings
        view.view_transform, view.look, view.exposure, view.gamma = "Standard", "None", 0.0, 1.0
    setattr(bpy.context.view_layer.tyndall, f"use_pass_{name.lower().replace(' ', '_')}", True)
    nodes, links = compositor(scene)
    source, output = nodes
    links.new(source.outputs[name], output.inputs[0])


def compositor(scene: bpy.types.Scene) -> tuple[tuple[bpy.types.Node, bpy.types.Node], bpy.types.NodeLinks]:
    """Give the scene a compositor of its render's layers and an output, as the running Blender wants it."""
    if bpy.app.version >= (5, 0, 0):
        tree = scene.compositing_node_group = bpy.data.node_groups.new("Passes", "CompositorNodeTree")
        tree.interface.new_socket("Image", in_out="OUTPUT", socket_type="NodeSocketColor")
        output = tree.nodes.new("NodeGroupOutput")
    else:
        scene.use_nodes = True
        tree = scene.node_tree
        tree.nodes.clear()
        output = tree.nodes.new("CompositorNodeComposite")
    return (tree.nodes.new("CompositorNodeRLayers"), output), tree.links


def hang_a_ring() -> None:
    """No sun, thicker fog, and a ring of neon between the columns, which lights them with the lanterns alone."""
    for thing in bpy.context.scene.objects:
        thing.hide_render |= thing.type == "LIGHT" and not thing.name.startswith("Lantern")
    turn_medium(density_factor=2.5, asymmetry_g=0.2)
    bpy.ops.mesh.primitive_torus_add(
        major_radius=1.4, minor_radius=0.04, location=(0.0, -4.0, 2.6), rotation=(1.35, 0.0, 0.35)
    )
    bpy.context.object.data.materials.append(emission("Neon", (1.0, 0.12, 0.25), 60.0))
