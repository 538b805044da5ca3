# SPDX-License-Identifier: GPL-3.0-or-later
"""Things that stand in the small scenes for the comparison with Cycles: planes, and occluders to choose from."""

from __future__ import annotations

from collections.abc import Callable

import bmesh
import bpy
import numpy as np
from mathutils import Matrix, Vector


def _link(name: str, data: bpy.types.ID | None, matrix: Matrix | None = None) -> bpy.types.Object:
    made = bpy.data.objects.new(name, data)
    bpy.context.scene.collection.objects.link(made)
    made.matrix_world = matrix or Matrix()
    return made


def _output(
    owner: bpy.types.Material | bpy.types.World,
) -> tuple[bpy.types.NodeTree, bpy.types.Node]:
    if not owner.use_nodes:
        owner.use_nodes = True
    owner.node_tree.nodes.clear()
    kind = "ShaderNodeOutputWorld" if isinstance(owner, bpy.types.World) else "ShaderNodeOutputMaterial"
    return owner.node_tree, owner.node_tree.nodes.new(kind)


def diffuse(colour: tuple[float, float, float]) -> bpy.types.Material:
    """Lambert's law."""
    material = bpy.data.materials.new("Diffuse")
    tree, output = _output(material)
    node = tree.nodes.new("ShaderNodeBsdfDiffuse")
    node.inputs["Color"].default_value = (*colour, 1)
    tree.links.new(node.outputs[0], output.inputs["Surface"])
    return material


def _mesh(
    name: str, make: Callable[[bmesh.types.BMesh], object], material: bpy.types.Material | None = None
) -> bpy.types.Mesh:
    mesh = bpy.data.meshes.new(name)
    shape = bmesh.new()
    make(shape)
    shape.to_mesh(mesh)
    shape.free()
    if material is not None:
        mesh.materials.append(material)
    return mesh


def _plane(name: str, matrix: Matrix, material: bpy.types.Material, cells: int = 1) -> bpy.types.Object:
    mesh = _mesh(
        name,
        lambda shape: bmesh.ops.create_grid(shape, x_segments=cells, y_segments=cells, size=0.5, calc_uvs=False),
        material,
    )
    layer = mesh.uv_layers.new(name="UVMap")
    for loop in mesh.loops:
        corner = mesh.vertices[loop.vertex_index].co
        layer.data[loop.index].uv = (corner.x + 0.5, corner.y + 0.5)
    return _link(name, mesh, matrix)


# --- occluders -------------------------------------------------------------------------------------------------------
def _grid() -> None:
    """A plate with 5 x 5 holes above the floor."""
    cells = 11

    def make(shape: bmesh.types.BMesh) -> None:
        bmesh.ops.create_grid(shape, x_segments=cells, y_segments=cells, size=1.5)
        holes = [face for index, face in enumerate(shape.faces) if index % cells % 2 and index // cells % 2]
        bmesh.ops.delete(shape, geom=holes, context="FACES_ONLY")

    _link(
        "Grid",
        _mesh("Grid", make, diffuse((0.7, 0.7, 0.7))),
        Matrix.LocRotScale(Vector((-0.3, 0.8, 2.2)), None, None) @ Matrix.Rotation(0.3, 4, "Y"),
    )


def _monkey() -> None:
    monkey = _mesh("Monkey", bmesh.ops.create_monkey, diffuse((0.6, 0.5, 0.4)))
    _link("Monkey", monkey, Matrix.Translation((0, 0.8, 1.7)) @ Matrix.Rotation(0.5, 4, "Z"))


def _instances() -> None:
    """A nested collection: posts, in rows, instanced thrice, one of them mirrored."""
    post, row = bpy.data.collections.new("Post"), bpy.data.collections.new("Row")
    mesh = _mesh(
        "Post",
        lambda shape: bmesh.ops.create_cone(shape, segments=8, radius1=0.12, radius2=0.05, depth=2.0, cap_ends=True),
        diffuse((0.7, 0.6, 0.3)),
    )
    post.objects.link(bpy.data.objects.new("Post", mesh))
    for index in range(4):
        empty = bpy.data.objects.new("Post", None)
        empty.instance_type, empty.instance_collection = "COLLECTION", post
        empty.matrix_world = Matrix.LocRotScale(
            Vector((index * 0.8 - 1.2, 0, 1.0)),
            None,
            Vector((1, 1, 0.8 + 0.15 * index)),
        )
        row.objects.link(empty)
    for y, mirror in ((0.0, 1), (0.7, -1), (1.5, 1)):
        empty = _link(
            "Row",
            None,
            Matrix.LocRotScale(Vector((0, y, 0)), None, Vector((mirror, 1, 1))),
        )
        empty.instance_type, empty.instance_collection = "COLLECTION", row


def _checker_image() -> bpy.types.Image:
    image = bpy.data.images.new("Leaves", 16, 16, alpha=True)
    rows, columns = np.mgrid[0:16, 0:16]
    pixels = np.ones((16, 16, 4), np.float32)
    pixels[..., :3] = (0.3, 0.6, 0.2)
    pixels[..., 3] = ((rows // 2 + columns // 2) % 2) * ((rows + 2 * columns) % 5 > 0)
    image.pixels.foreach_set(pixels.ravel())
    image.pack()
    return image


def _alpha() -> None:
    """A plane whose image lets light through in places: sharp texels, as in a leaf's texture."""
    material = bpy.data.materials.new("Leaves")
    tree, output = _output(material)
    texture, clear = (
        tree.nodes.new("ShaderNodeTexImage"),
        tree.nodes.new("ShaderNodeBsdfTransparent"),
    )
    solid, mix = (
        tree.nodes.new("ShaderNodeBsdfDiffuse"),
        tree.nodes.new("ShaderNodeMixShader"),
    )
    texture.image, texture.interpolation = _checker_image(), "Closest"
    tree.links.new(texture.outputs["Color"], solid.inputs["Color"])
    tree.links.new(texture.outputs["Alpha"], mix.inputs["Fac"])
    tree.links.new(clear.outputs[0], mix.inputs[1])
    tree.links.new(solid.outputs[0], mix.inputs[2])
    tree.links.new(mix.outputs[0], output.inputs["Surface"])
    _plane(
        "Leaves",
        Matrix.Translation((-0.2, 0.8, 2.4)) @ Matrix.Diagonal((3, 3, 1, 1)),
        material,
    )


def _glass() -> None:
    """Two panes, a red and a blue one, that overlap: transparent surfaces multiply."""
    for colour, x, z in (((0.9, 0.2, 0.1), -0.6, 2.3), ((0.1, 0.3, 0.9), 0.4, 2.6)):
        material = bpy.data.materials.new("Pane")
        tree, output = _output(material)
        clear = tree.nodes.new("ShaderNodeBsdfTransparent")
        clear.inputs["Color"].default_value = (*colour, 1)
        tree.links.new(clear.outputs[0], output.inputs["Surface"])
        _plane(
            "Pane",
            Matrix.Translation((x, 0.8, z)) @ Matrix.Diagonal((1.8, 2.0, 1, 1)),
            material,
        )


def _glow() -> None:
    """A glowing plate that the camera sees, and that lights nothing: Cycles would count it as direct light."""
    material = bpy.data.materials.new("Glow")
    tree, output = _output(material)
    emission = tree.nodes.new("ShaderNodeEmission")
    (
        emission.inputs["Color"].default_value,
        emission.inputs["Strength"].default_value,
    ) = (1.0, 0.4, 0.1, 1), 2.0
    tree.links.new(emission.outputs[0], output.inputs["Surface"])
    if hasattr(material.cycles, "emission_sampling"):
        material.cycles.emission_sampling = "NONE"
    else:
        material.cycles.sample_as_light = False
    plate = _plane("Glow", Matrix.Translation((0, 0.8, 2.0)) @ Matrix.Rotation(0.6, 4, "X"), material)
    # Without it, rays that leave a surface or a medium after the last bounce still end on the plate and see it glow.
    plate.visible_diffuse = plate.visible_volume_scatter = False


OCCLUDERS: dict[str, Callable[[], None]] = {
    "none": lambda: None,
    "grid": _grid,
    "monkey": _monkey,
    "instances": _instances,
    "alpha": _alpha,
    "glass": _glass,
    "glow": _glow,
}
