# SPDX-License-Identifier: GPL-3.0-or-later
"""A viewport in which an artist works all day takes no more memory in the evening, nor does what is read stay."""

from __future__ import annotations

import ctypes
import gc
import re
from collections.abc import Callable

import bpy
import numpy as np
import pytest

from addon.engine.sessions import viewport_session
from addon.sync.cameras import read_camera
from addon.sync.reports import Reports
from addon.sync.scene import SceneReader
from support.followed_scene import Followed
from support.small_scenes import add, cube, empty_scene, light, material, node, plane

#: From the first quarter on. A leak of each new mesh and its tree would be some 27 MiB, in 1,000 edits six times that.
MOST_GROWN_BYTES = 8 << 20


SIDE = 101
GRID = np.stack([*np.meshgrid(*[np.linspace(-3.0, 3.0, SIDE)] * 2, [0.0])], axis=-1).reshape(-1, 3)


def _hill() -> bpy.types.Mesh:
    mesh = bpy.data.meshes.new("Hill")
    first = np.arange(SIDE * (SIDE - 1)).reshape(-1, SIDE)[:, :-1].ravel()
    mesh.from_pydata(GRID.tolist(), [], np.stack([first, first + 1, first + SIDE + 1, first + SIDE], axis=1).tolist())
    return mesh


def _used_bytes() -> int:
    """In blocks that are in use, of all threads: how much is resident around them differs from run to run."""
    gc.collect()
    libc = ctypes.CDLL(None)
    used, size = ctypes.c_size_t(), ctypes.c_size_t(ctypes.sizeof(ctypes.c_size_t))
    if hasattr(libc, "mallctl"):  # jemalloc, in Debian's Blender
        now = ctypes.c_uint64(1)
        libc.mallctl(b"epoch", None, None, ctypes.byref(now), ctypes.c_size_t(ctypes.sizeof(now)))
        libc.mallctl(b"stats.allocated", ctypes.byref(used), ctypes.byref(size), None, ctypes.c_size_t(0))
        return used.value
    libc.open_memstream.restype = ctypes.c_void_p
    text = ctypes.c_char_p()
    stream = ctypes.c_void_p(libc.open_memstream(ctypes.byref(text), ctypes.byref(size)))
    libc.malloc_info(0, stream)
    libc.fclose(stream)
    # One heap after another, and the sums of all at the end.
    sums = dict(re.findall(rb'<(?:total|system) type="(\w+)".*size="(\d+)"', text.value or b""))
    libc.free(text)
    return int(sums[b"current"]) - int(sums[b"fast"]) - int(sums[b"rest"]) + int(sums[b"mmap"])


def _edits(rng: np.random.Generator) -> list[Callable[[], object]]:
    def replace_hill() -> None:
        """20,000 triangles at other heights."""
        old = bpy.data.objects["Hill"].data
        mesh = old.copy()
        places = GRID.copy()
        places[:, 2] = 0.3 * rng.random(len(places))
        mesh.vertices.foreach_set("co", places.ravel())
        mesh.update()
        bpy.data.objects["Hill"].data = mesh
        bpy.data.meshes.remove(old)

    def come_and_go() -> None:
        guest = bpy.data.objects.get("Guest")
        if guest is None:
            cube("Guest").location = rng.uniform(-2, 2, 3)
        else:
            mesh = guest.data
            bpy.data.objects.remove(guest)
            bpy.data.meshes.remove(mesh)

    def move() -> None:
        bpy.data.objects["Box"].location = rng.uniform(-2, 2, 3)

    def recolour() -> None:
        tree = bpy.data.materials["Paint"].node_tree
        next(n for n in tree.nodes if n.type == "BSDF_DIFFUSE").inputs[0].default_value = (*rng.random(3), 1.0)

    def relight() -> None:
        bpy.data.objects["Sun"].data.energy = rng.uniform(1, 5)

    def hide() -> None:
        box = bpy.data.objects["Box"]
        box.hide_viewport = not box.hide_viewport

    return [move, move, recolour, relight, relight, hide, come_and_go, replace_hill]


@pytest.mark.parametrize(
    "edit_count", [pytest.param(160, marks=pytest.mark.costly), pytest.param(1000, marks=pytest.mark.long)]
)
def test_edits_leave_no_memory_behind(edit_count: int) -> None:
    """Seen to fail with sessions that forget no mesh."""
    rng = np.random.default_rng(1)
    scene = empty_scene(size_px=64)
    plane()
    paint = material("Paint", surface=lambda new, _: node(new, "ShaderNodeBsdfDiffuse").outputs[0])
    cube("Box", paint)
    fog = cube(
        "Fog", material("Fog", volume=lambda new, _: node(new, "ShaderNodeVolumeScatter", Density=0.1).outputs[0])
    )
    fog.scale = (4.0, 4.0, 4.0)
    add("Hill", _hill())
    light("SUN", (0, 0, 5))
    followed = Followed(viewport_session())
    camera = read_camera(scene.camera, scene.render, (64, 64), Reports())
    edits = _edits(rng)
    sizes = []
    with followed.hears():
        for index in range(edit_count):
            edits[rng.integers(len(edits))]()
            bpy.context.view_layer.update()
            followed.update(followed.read())
            followed.picture(camera)
            if index % 10 == 9:
                sizes.append(_used_bytes())
    quarter = len(sizes) // 4
    grown = min(sizes[-quarter:]) - min(sizes[:quarter])
    assert grown < MOST_GROWN_BYTES, [size >> 20 for size in sizes]


@pytest.mark.skipif(bpy.app.version < (4, 1, 0), reason="meshes share no arrays")
def test_reading_leaves_blenders_meshes_as_they_were() -> None:
    """Seen to fail by 11 MiB with meshes that are read themselves: each array that is asked for is copied."""
    empty_scene(size_px=64)
    mesh = bpy.data.meshes.new("Strip")
    count = 240_000  # triangles side by side
    places = np.stack(np.meshgrid(np.arange(count), np.arange(3.0), indexing="ij"), axis=-1).reshape(-1, 2)
    mesh.vertices.add(3 * count)
    mesh.vertices.foreach_set("co", np.column_stack([places, places[:, 0] % 2]).astype(np.float32).ravel())
    mesh.loops.add(3 * count)
    mesh.loops.foreach_set("vertex_index", np.arange(3 * count, dtype=np.int32))
    mesh.polygons.add(count)
    mesh.polygons.foreach_set("loop_start", np.arange(0, 3 * count, 3, dtype=np.int32))
    mesh.update(calc_edges=True)
    strip = add("Strip", mesh)
    depsgraph = bpy.context.evaluated_depsgraph_get()
    found = strip.evaluated_get(depsgraph).data
    found.calc_loop_triangles()
    _ = found.vertex_normals[0].vector
    before = _used_bytes()
    (group,) = SceneReader().read(depsgraph, Reports(), lambda: None).instances
    assert len(group.mesh.triangles) == count
    del group
    assert _used_bytes() - before < 3 << 20
