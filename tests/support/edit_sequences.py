# SPDX-License-Identifier: GPL-3.0-or-later
"""What an artist does to a scene while it is drawn, at random: each edit is drawn by its sequence's seed."""

from __future__ import annotations

import math
import random
from collections.abc import Callable, Iterator
from contextlib import nullcontext
from typing import Any

import bpy

STEPS = 12  #: Of a sequence.
SAVED = "saved.blend"  #: In the window's folder: what is opened instead.
Edit = Callable[[random.Random, Any], None]


def is_rendering() -> bool:
    """A final render, in a thread of its own."""
    return bool(bpy.app.is_job_running("RENDER"))


def renders_begun() -> list[bool]:
    """Grows by one whenever Blender has handed a final render over to the engine."""
    from addon.engine import final  # noqa: PLC0415  after the path is set

    begun: list[bool] = []
    render = final.render

    def render_and_tell(*of_engine: Any) -> None:
        begun.append(True)
        render(*of_engine)

    final.render = render_and_tell
    return begun


def made(edit: Edit, chance: random.Random, window: Any, begun: list[bool]) -> Iterator[float]:
    """Make an edit as an artist can; ``begun`` is renders_begun().

    That keeps out two crashes of Blender 3.4 that no engine in Python can prevent. It looks into a context that is
    overridden without waiting for its turn to use Python, so that is done only where a file that was opened has taken
    the context's window with it. And it evaluates the scene of a render in that render's thread, while which nothing
    must change: the next edit waits until the engine has it.
    """
    before, was_rendering = len(begun), is_rendering()
    with nullcontext() if bpy.context.window else bpy.context.temp_override(window=window.bpy_window):
        edit(chance, window)
    if not was_rendering:
        yield from window.until(lambda: len(begun) > before or not is_rendering())


def leave_eevee() -> None:
    """The engine of the factory's scene, to which edits go back: on the CPU it draws for seconds after each."""
    if bpy.context.scene.render.engine == "BLENDER_EEVEE":
        bpy.context.scene.render.engine = "BLENDER_WORKBENCH"


def _things(*kinds: str) -> list[bpy.types.Object]:
    """In a steady order."""
    return sorted(
        (thing for thing in bpy.context.scene.objects if not kinds or thing.type in kinds), key=lambda it: it.name
    )


def _create(chance: random.Random, _window: Any) -> None:
    place = tuple(chance.uniform(-2.0, 2.0) for _ in range(3))
    if chance.random() < 0.3:
        bpy.ops.object.light_add(type=chance.choice(("POINT", "SUN", "SPOT", "AREA")), location=place)
    else:
        add = chance.choice((bpy.ops.mesh.primitive_cube_add, bpy.ops.mesh.primitive_ico_sphere_add))
        add(location=place)
    bpy.ops.ed.undo_push(message="create")


def _delete(chance: random.Random, _window: Any) -> None:
    things = _things()
    if things:
        bpy.data.objects.remove(chance.choice(things))
        bpy.ops.ed.undo_push(message="delete")


def _undo(_chance: random.Random, _window: Any) -> None:
    if bpy.ops.ed.undo.poll():
        bpy.ops.ed.undo()


def _redo(_chance: random.Random, _window: Any) -> None:
    if bpy.ops.ed.redo.poll():
        bpy.ops.ed.redo()


def _rename(chance: random.Random, _window: Any) -> None:
    for thing in chance.sample(_things(), min(2, len(_things()))):
        thing.name = chance.choice(("Box", "Lamp", "Camera", "", "\u00e9" * 40))


def _move(chance: random.Random, _window: Any) -> None:
    things = _things()
    if things:
        chance.choice(things).location = tuple(chance.uniform(-3.0, 3.0) for _ in range(3))
        bpy.ops.ed.undo_push(message="move")


def _rescale(chance: random.Random, _window: Any) -> None:
    things = _things("MESH")
    if things:
        values = (0.0, 1e-20, -1.0, 0.5, 3.0, 1e20, math.nan, math.inf)
        chance.choice(things).scale = tuple(chance.choice(values) for _ in range(3))


def _shade(chance: random.Random, _window: Any) -> None:
    things = _things("MESH")
    if things:
        made = bpy.data.materials.new("Made")
        made.use_nodes = True
        made.diffuse_color = tuple(chance.random() for _ in range(4))
        chance.choice(things).data.materials.append(made)


def _edit_mesh(chance: random.Random, _window: Any) -> None:
    things = _things("MESH")
    if things:
        data = chance.choice(things).data
        if chance.random() < 0.3:
            data.clear_geometry()
        elif data.vertices:
            data.vertices[chance.randrange(len(data.vertices))].co = (chance.uniform(-5.0, 5.0), math.nan, 1.0)
        data.update()


def _change_engine(chance: random.Random, _window: Any) -> None:
    """To Workbench and back: Cycles aborts in Debian's Embree, which checks its rays, over what other edits break."""
    bpy.context.scene.render.engine = chance.choice(("BLENDER_WORKBENCH", "TYNDALL"))


def _change_shading(chance: random.Random, window: Any) -> None:
    window.area("VIEW_3D").spaces[0].shading.type = chance.choice(("SOLID", "WIREFRAME", "RENDERED"))


def _turn(chance: random.Random, window: Any) -> None:
    view = window.area("VIEW_3D").spaces[0].region_3d
    view.view_perspective = chance.choice(("PERSP", "ORTHO", "CAMERA"))
    view.view_distance = chance.uniform(0.1, 30.0)


def _render(_chance: random.Random, _window: Any) -> None:
    """F12, which goes on while the next edits come."""
    if not is_rendering() and bpy.context.scene.camera is not None:
        bpy.context.scene.render.engine = "TYNDALL"
        bpy.context.scene.tyndall.pixel_samples = 16
        bpy.ops.render.render("INVOKE_DEFAULT")


def _close_file(chance: random.Random, window: Any) -> None:
    """For another one. Blender 3.4 crashes where factory settings are loaded while any engine in Python renders."""
    if is_rendering() or chance.random() < 0.5:
        bpy.ops.wm.open_mainfile(filepath=str(window.folder / SAVED))
    else:
        bpy.ops.wm.read_factory_settings(use_empty=chance.random() < 0.5)


EDITS: tuple[tuple[str, Edit], ...] = (
    ("create", _create),
    ("delete", _delete),
    ("undo", _undo),
    ("redo", _redo),
    ("rename", _rename),
    ("move", _move),
    ("rescale", _rescale),
    ("shade", _shade),
    ("edit mesh", _edit_mesh),
    ("change engine", _change_engine),
    ("change shading", _change_shading),
    ("turn", _turn),
    ("render", _render),
    ("close file", _close_file),
)
