# SPDX-License-Identifier: GPL-3.0-or-later
"""Tests here run inside Blender: the bpy wheels, or Blender 3.4 in the background."""

from __future__ import annotations

import sys
import zlib
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

import bpy
import pytest

REPOSITORY = Path(__file__).parents[2]
for folder in (REPOSITORY, REPOSITORY / "tests", REPOSITORY / "python", REPOSITORY / "build/release/python"):
    if str(folder) not in sys.path:
        sys.path.append(str(folder))


#: Of every push.
VERSIONS = ((3, 4), (4, 5), (5, 0))


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """What takes long is asked of one version on every push, and of the others with --all: see the marks."""
    version = bpy.app.version[:2]
    count: Counter[str] = Counter()
    for item in items:
        is_dealt = item.get_closest_marker("dealt") is not None
        is_of_some = item.get_closest_marker("skipif") is not None  # which the others skip
        if item.get_closest_marker("costly") is not None or (is_dealt and is_of_some):
            is_asked = version == (4, 5)
        elif is_dealt and version in VERSIONS:
            function, _, case = item.nodeid.partition("[")
            among = function if case else str(item.path)
            # Files begin with different versions, and the functions of a file, which may share a fixture, with one.
            turn = zlib.crc32(item.path.name.encode()) + count[among]
            count[among] += 1
            is_asked = version == VERSIONS[turn % len(VERSIONS)]
        else:
            continue
        if not is_asked:
            item.add_marker("long")


@pytest.fixture(scope="session", autouse=True)
def registered_addon() -> Iterator[None]:
    """The add-on of the source tree. A RenderEngine class that is still registered at exit crashes or hangs bpy."""
    import addon  # noqa: PLC0415  after the path is set

    bpy.ops.wm.read_factory_settings()
    addon.register()
    yield
    addon.unregister()


@pytest.fixture
def scene() -> bpy.types.Scene:
    """Blender's factory scene: a cube, a point light, a camera and a world; the engine is ours."""
    from support.new_file import new_file  # noqa: PLC0415  after the path is set

    scene = new_file()
    scene.render.engine = "TYNDALL"
    return scene


@pytest.fixture
def function() -> bpy.types.NodeTree:
    """A new transfer function without layers, the only one of a scene with a cube."""
    from support.transfer_scene import function_scene  # noqa: PLC0415  after the path is set

    return function_scene()
