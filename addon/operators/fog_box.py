# SPDX-License-Identifier: GPL-3.0-or-later
"""One click from a clear scene to one with shafts: a bounded medium around what the camera sees.

A sun in a medium without bounds is attenuated over an infinite way: nothing of it arrives. Hence a box.
"""

from collections.abc import Iterator

import bpy
from bpy.props import BoolProperty, FloatProperty
from bpy.types import Context, Depsgraph, Material, Node, Object, Operator
from mathutils import Vector

from ..boxes import BOX_FACES, box_corners
from ..shader_nodes import is_fed_by_nodes, is_medium_only, plugged_in, use_nodes

#: Half the side of the box in a scene without anything to enclose, metres.
EMPTY_SCENE_HALF_SIDE_M = 5.0
COPIED_MEDIA = frozenset({"ShaderNodeVolumePrincipled", "ShaderNodeVolumeScatter", "ShaderNodeVolumeAbsorption"})


def select_only(context: Context, *things: Object) -> None:
    """The first of them becomes the active one."""
    for other in context.selected_objects:
        other.select_set(False)
    for thing in things:
        thing.select_set(True)
    context.view_layer.objects.active = things[0]


def enclosed_points(depsgraph: Depsgraph, *, with_camera_and_lights: bool) -> Iterator[Vector]:
    """Yield corners, in world space and metres, of what the box must hold. A sun stands nowhere and is left out."""
    for instance in depsgraph.object_instances:
        shown = instance.object
        world_from_object = instance.matrix_world
        if shown.type in {"MESH", "CURVE", "SURFACE", "META", "FONT"}:
            if instance.show_self and not is_medium_only(shown):
                yield from (world_from_object @ Vector(corner) for corner in shown.bound_box)
        elif not with_camera_and_lights:
            continue
        elif shown.type == "LIGHT" and shown.data.type != "SUN":
            yield world_from_object.translation.copy()  # the next instance overwrites this one's matrix
    if with_camera_and_lights and depsgraph.scene.camera:
        yield depsgraph.scene.camera.matrix_world.translation


def box_bounds_m(points: Iterator[Vector], margin: float) -> tuple[Vector, Vector]:
    """Lowest and highest corner of a box around finite points, widened on each side by a share of its diagonal."""
    columns = tuple(zip(*(point for point in points if abs(point.length_squared) < float("inf")), strict=True))
    if not columns:
        return Vector((-EMPTY_SCENE_HALF_SIDE_M,) * 3), Vector((EMPTY_SCENE_HALF_SIDE_M,) * 3)
    lowest, highest = Vector(map(min, columns)), Vector(map(max, columns))
    margin_m = max((highest - lowest).length * margin, 1e-3)
    return lowest - Vector((margin_m,) * 3), highest + Vector((margin_m,) * 3)


def fog_material(density_per_m: float, asymmetry_g: float) -> Material:
    """Make a medium without a surface that only scatters."""
    material = bpy.data.materials.new("Fog")
    tree = use_nodes(material)
    nodes = tree.nodes
    nodes.clear()
    output = nodes.new("ShaderNodeOutputMaterial")
    medium = nodes.new("ShaderNodeVolumePrincipled")
    medium.location = (-300, 0)
    medium.inputs["Color"].default_value = (1.0, 1.0, 1.0, 1.0)
    medium.inputs["Density"].default_value = density_per_m
    medium.inputs["Anisotropy"].default_value = asymmetry_g
    tree.links.new(medium.outputs["Volume"], output.inputs["Volume"])
    return material


def copy_medium(source: Node, material: Material) -> None:
    """Replace a material's medium by another node's, value by value."""
    tree = material.node_tree
    output = tree.get_output_node("CYCLES")
    tree.nodes.remove(output.inputs["Volume"].links[0].from_node)
    medium = tree.nodes.new(source.bl_idname)
    medium.location = (-300, 0)
    if hasattr(source, "phase"):  # Blender 4.3 and later
        medium.phase = source.phase
    for target, origin in zip(medium.inputs, source.inputs, strict=True):
        if hasattr(origin, "default_value"):
            target.default_value = origin.default_value
    tree.links.new(medium.outputs["Volume"], output.inputs["Volume"])


def add_box(context: Context, lowest: Vector, highest: Vector, material: Material) -> Object:
    """Add an axis-aligned box, centred on its origin so that scaling it keeps it in place; drawn as wires."""
    centre = (lowest + highest) / 2
    corners = [Vector(corner) - centre for corner in box_corners(lowest, highest)]
    mesh = bpy.data.meshes.new("Fog Box")
    mesh.from_pydata(corners, [], BOX_FACES)
    mesh.materials.append(material)
    box = bpy.data.objects.new("Fog Box", mesh)
    box.location = centre
    box.display_type = "WIRE"
    context.collection.objects.link(box)
    return box


class TYNDALL_OT_add_fog_box(Operator):
    """Add a box of haze around the visible scene, in which lights draw shafts."""

    bl_idname = "tyndall.add_fog_box"
    bl_label = "Add Fog Box"
    bl_options = {"REGISTER", "UNDO"}

    optical_depth: FloatProperty(
        name="Optical Depth",
        description="Along the diagonal of the box, from which the density follows: 1 lets 37 % of the light through, "
        "0.1 lets 90 %",
        min=0.0,
        max=100.0,
        soft_max=5.0,
        default=0.5,
    )
    asymmetry_g: FloatProperty(
        name="Anisotropy",
        description="Direction of scattering: 0 to all sides; towards 1 forward: shafts are bright against the light",
        min=-0.99,
        max=0.99,
        default=0.3,
    )
    margin: FloatProperty(
        name="Margin",
        description="Room around the scene, as a share of its diagonal",
        subtype="FACTOR",
        min=0.0,
        max=10.0,
        soft_max=1.0,
        default=0.05,
    )
    with_camera_and_lights: BoolProperty(
        name="Enclose Camera and Lights",
        description="Make the box hold the camera, point lights and spots, too; a sun stands nowhere and is left out",
        default=True,
    )
    replaces_world_medium: BoolProperty(
        name="Replace the World's Medium",
        description="Fill the box with the medium of the world, which has no bounds and loses all light of a sun, "
        "and take it from the world. Optical depth and anisotropy above are then not used",
        default=False,
    )

    @classmethod
    def poll(cls, context: Context) -> bool:
        if context.mode != "OBJECT":
            cls.poll_message_set("Works in Object Mode")
            return False
        return True

    def execute(self, context: Context) -> set[str]:
        world = context.scene.world
        source = plugged_in(world, "Volume") if self.replaces_world_medium else None
        if source and source.bl_idname not in COPIED_MEDIA:
            self.report({"ERROR"}, f"The world's medium is a {source.bl_label}: plug a single volume shader in first")
            return {"CANCELLED"}
        if source and is_fed_by_nodes(source):
            self.report({"ERROR"}, "Nodes feed the world's medium, and fill a box as it is: unplug them from it first")
            return {"CANCELLED"}
        points = enclosed_points(context.evaluated_depsgraph_get(), with_camera_and_lights=self.with_camera_and_lights)
        lowest, highest = box_bounds_m(points, self.margin)
        material = fog_material(self.optical_depth / (highest - lowest).length, self.asymmetry_g)
        if source:
            copy_medium(source, material)
            world_output = world.node_tree.get_output_node("CYCLES")
            world.node_tree.links.remove(world_output.inputs["Volume"].links[0])
        box = add_box(context, lowest, highest, material)
        select_only(context, box)
        return {"FINISHED"}


CLASSES = (TYNDALL_OT_add_fog_box,)
