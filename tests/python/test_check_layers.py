# SPDX-License-Identifier: GPL-3.0-or-later
"""Arrows between layers point down only; the check that holds this is itself shown one violation of every kind."""

import subprocess
import sys
from pathlib import Path

import pytest

CHECK = Path(__file__).parents[2] / "scripts" / "check_layers.py"


def check(root: Path) -> tuple[int, str]:
    """Exit code and output of the check on a tree."""
    result = subprocess.run([sys.executable, CHECK, root], capture_output=True, text=True, check=False)
    assert result.stderr == ""
    return result.returncode, result.stdout


def plant(root: Path, path: str, line: str) -> None:
    """Make a one-line file, below root."""
    (root / path).parent.mkdir(parents=True, exist_ok=True)
    (root / path).write_text(f"{line}\n", encoding="utf-8")


def test_the_tree_as_it_is_has_no_arrow_that_points_up() -> None:
    assert check(CHECK.parents[1]) == (0, "")


@pytest.mark.parametrize(
    ("path", "line", "reason"),
    [
        ("native/core/a.hpp", '#include "scene/b.hpp"', "the arrow points up"),
        ("native/shading/a.cpp", '#include "render/b.hpp"', "the arrow points up"),
        ("native/render/a.cpp", "#  include <bindings/b.hpp>", "the arrow points up"),
        ("native/image/a.cpp", '#include "volume/b.hpp"', "two parts of one layer never meet"),
        ("native/volume/deep/a.cpp", '#include "image/b.hpp"', "two parts of one layer never meet"),
        ("native/scene/a.cpp", "#include <OpenImageIO/imageio.h>", "which belongs to image/io"),
        ("native/image/a.cpp", "#include <OpenImageIO/imageio.h>", "which belongs to image/io"),
        ("native/render/a.cpp", "#include <openvdb/openvdb.h>", "which belongs to volume/io"),
        ("native/volume/a.cpp", "#include <openvdb/openvdb.h>", "which belongs to volume/io"),
        ("native/volume/io/a.hpp", "#include <boost/any.hpp>", "which belongs to a library"),
        ("native/volume/io/a.cpp", '#include "bindings/paths.hpp"', "the arrow points up"),
        ("native/volume/module.cpp", "#include <pybind11/numpy.h>", "which belongs to bindings"),
        ("native/render/a.cpp", "#include <pybind11/numpy.h>", "which belongs to bindings"),
        ("native/bindings/a.cpp", "#include <Python.h>", "which belongs to a library"),
        ("native/shiny_new_room/a.cpp", "", "has no layer"),
        ("python/tyndall/a.py", "import bpy", "only python/tyndall/blender/ knows Blender"),
        ("python/tyndall/a.py", "from mathutils import Vector", "only python/tyndall/blender/ knows Blender"),
        ("python/tyndall/a.py", "def f():\n    import bpy.types", "only python/tyndall/blender/ knows Blender"),
        ("python/tyndall/a.py", "importlib.import_module('bpy')", "only python/tyndall/blender/ knows Blender"),
        ("python/tyndall/a.py", "from .blender import addon", "may import the add-on"),
        ("python/tyndall/deep/a.py", "from ..blender.addon import engine", "may import the add-on"),
        ("python/tyndall/a.py", "import addon.engine", "may import the add-on"),
        ("addon/a.py", "from addon.engine import b", "imports itself relatively"),
        ("addon/a.py", "import tyndall_blender", "imports itself relatively"),
        ("addon/a.py", "from tyndall.blender import enable", "never the other way round"),
        ("addon/operators/a.py", "from tyndall import Progress", "needs the core, at once"),
        ("addon/panels/a.py", "from ..sync.scene import SceneReader", "needs the core, at once"),
    ],
)
def test_a_planted_violation_is_found_at_its_line(path: str, line: str, reason: str, tmp_path: Path) -> None:
    plant(tmp_path, path, line)
    code, output = check(tmp_path)
    assert code == 1
    assert output.startswith(path)
    assert reason in output
    assert len(output.splitlines()) == 1


@pytest.mark.parametrize(
    ("path", "line"),
    [
        ("native/scene/a.cpp", '#include "core/b.hpp"\n#include "scene/c.hpp"\n#include "image/d.hpp"'),
        ("native/bindings/a.cpp", "#include <pybind11/pybind11.h>"),
        ("native/image/io/a.cpp", "#include <OpenImageIO/imageio.h>"),
        ("native/volume/io/a.hpp", "#include <openvdb/openvdb.h>"),
        ("native/volume/io/module.cpp", '#include "bindings/paths.hpp"\n#include <pybind11/stl.h>'),
        ("native/core/a.cpp", '// #include "scene/b.hpp"'),
        ("python/tyndall/blender/__init__.py", "import bpy\nfrom .addon import register"),
        ("python/tyndall/__main__.py", "from tyndall.blender import enable"),
        ("python/tyndall/a.py", "import bpyish\nfrom .scene_description import Camera"),
        ("addon/operators/a.py", "def f():\n    from tyndall import Progress\n    from ..sync import scene"),
        ("addon/sync/a.py", "import bpy\nimport tyndall\nfrom ..properties import b"),
    ],
)
def test_an_arrow_that_points_down_is_left_alone(path: str, line: str, tmp_path: Path) -> None:
    plant(tmp_path, path, line)
    assert check(tmp_path) == (0, "")


def test_two_rooms_never_meet(tmp_path: Path) -> None:
    """There is one room yet, so the check is given a second one."""
    plant(tmp_path, "native/light_shafts/a.cpp", '#include "voxel_dag/b.hpp"')
    copy = tmp_path / "check_layers.py"
    text = CHECK.read_text(encoding="utf-8")
    copy.write_text(text.replace('"light_shafts": 4,', '"light_shafts": 4, "voxel_dag": 4,'), encoding="utf-8")
    result = subprocess.run([sys.executable, copy, tmp_path], capture_output=True, text=True, check=False)
    assert result.returncode == 1
    assert "two parts of one layer never meet" in result.stdout
