# SPDX-License-Identifier: GPL-3.0-or-later
"""Install, render, update, disable and remove the zip, in each Blender, each time with an empty user folder."""

import zipfile
from pathlib import Path

import pytest

from support.blenders import Blender, Bpy, Executable

RENDER = """
def engine_is_there():
    try:
        bpy.context.scene.render.engine = "TYNDALL"
    except TypeError:
        return False
    return True

def render(path):
    scene = bpy.context.scene
    scene.render.engine = "TYNDALL"
    scene.render.resolution_x = scene.render.resolution_y = 32
    scene.render.resolution_percentage = 100
    scene.render.image_settings.file_format = "OPEN_EXR"
    scene.render.filepath = path
    bpy.ops.render.render(write_still=True)
    picture = bpy.data.images.load(path)
    print("brightest:", max(picture.pixels))
    bpy.data.images.remove(picture)

def reason():
    import importlib
    return importlib.import_module(module + ".availability").why_not()
"""


def files_below(folder: Path) -> list[Path]:
    """Files that belong to us."""
    return [path for path in folder.rglob("*tyndall*") if path.is_file() and path.suffix != ".pyc"]


def with_version(zip_path: Path, version: str, folder: Path) -> Path:
    """Copy the zip, with another version in the add-on, in the wheel's name and in the package."""
    old_version = zip_path.name.split("-")[1]
    new_path = folder / zip_path.name.replace(old_version, version)

    def replaced(name: str, content: bytes) -> bytes:
        if name.endswith(("__init__.py", "blender_manifest.toml", "METADATA", "RECORD")):
            old_tuple, new_tuple = (", ".join(v.split(".")) for v in (old_version, version))
            content = content.replace(f"({old_tuple})".encode(), f"({new_tuple})".encode())
            content = content.replace(old_version.encode(), version.encode())
        return content

    def copy(source: zipfile.ZipFile, target: zipfile.ZipFile) -> None:
        for entry in source.infolist():
            name = entry.filename.replace(old_version, version)
            content = source.read(entry)
            if name.endswith(".whl"):
                inner = folder / Path(name).name
                with zipfile.ZipFile(source.open(entry)) as old, zipfile.ZipFile(inner, "w") as new:
                    copy(old, new)
                content = inner.read_bytes()
            target.writestr(zipfile.ZipInfo(name), replaced(name, content), entry.compress_type)

    with zipfile.ZipFile(zip_path) as old, zipfile.ZipFile(new_path, "w") as new:
        copy(old, new)
    return new_path


@pytest.fixture(scope="module")
def newer_zip(zip_path: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    return with_version(zip_path, "99.1.2", tmp_path_factory.mktemp("newer"))


def test_the_zip_installs_renders_and_leaves_nothing_behind(blender: Blender, zip_path: Path) -> None:
    picture = blender.user_folder / "picture.exr"
    begin = blender.install + RENDER
    first = blender.run(
        f"{begin}\ninstall({str(zip_path)!r})\nenable()\nprint('reason:', reason())\nassert engine_is_there()\n"
        f"render({str(picture)!r})"
    ).succeeded()
    assert first.says("reason:") == "None"
    assert float(first.says("brightest:")) > 0.01
    assert files_below(blender.user_folder)

    # A process that finds it enabled in the user's preferences, and takes it away.
    second = blender.run(
        f"{begin}\nassert engine_is_there()\nrender({str(picture)!r})\n"
        "disable()\nassert not engine_is_there()\nenable()\nassert engine_is_there()\nremove()\n"
        "assert not engine_is_there()\nbpy.ops.wm.save_userpref()"
    ).succeeded()
    assert second.says("brightest:") == first.says("brightest:")
    blender.run(f"{begin}\nassert not engine_is_there()").succeeded()
    assert files_below(blender.user_folder) == []


def test_an_update_over_the_loaded_add_on_asks_for_a_restart(blender: Blender, zip_path: Path, newer_zip: Path) -> None:
    """Seen to die (3.4, signal 11) with the wheel unpacked over the mapped one, and no entry for the zip's folder."""
    picture = blender.user_folder / "picture.exr"
    begin = blender.install + RENDER
    updated = blender.run(
        f"{begin}\ninstall({str(zip_path)!r})\nenable()\nrender({str(picture)!r})\n"
        f"install({str(newer_zip)!r})\nenable()\nprint('reason:', reason())"
    ).succeeded()
    assert "restart Blender" in updated.says("reason:")
    assert "99.1.2" in updated.says("reason:")

    restarted = blender.run(
        f"{begin}\nimport tyndall\nprint('version:', tyndall.__version__)\nprint('reason:', reason())\n"
        f"render({str(picture)!r})"
    ).succeeded()
    assert restarted.says("version:") == "99.1.2"
    assert restarted.says("reason:") == "None"
    assert restarted.says("brightest:") == updated.says("brightest:")


def test_the_same_zip_over_itself_goes_on_rendering(blender: Blender, zip_path: Path) -> None:
    picture = blender.user_folder / "picture.exr"
    again = f"install({str(zip_path)!r})\nenable()\nassert reason() is None\nrender({str(picture)!r})\n"
    result = blender.run(f"{blender.install}{RENDER}\n{again}{again}").succeeded()
    assert result.output.count("brightest:") == 2


def test_a_wheel_for_another_python_is_named(blender_34: Executable, zip_path: Path) -> None:
    """Blender 3.4 to 4.0 as Blender's makers ship them run Python 3.10."""
    other = blender_34.user_folder / zip_path.name
    with zipfile.ZipFile(zip_path) as old, zipfile.ZipFile(other, "w") as new:
        for entry in old.infolist():
            name = entry.filename.replace("-cp311-cp311-", "-cp310-cp310-")
            new.writestr(zipfile.ZipInfo(name), old.read(entry))
    result = blender_34.run(
        f"{blender_34.install}{RENDER}\ninstall({str(other)!r})\nenable()\nprint('reason:', reason())"
    ).succeeded()
    assert "This zip is for Python 3.10" in result.says("reason:")


def test_a_missing_numpy_gets_the_line_that_installs_it(blender_34: Executable, zip_path: Path) -> None:
    """Debian's Blender neither depends on nor recommends it."""
    hide_numpy = "import sys\nsys.modules['numpy'] = None\n"
    result = blender_34.run(
        f"{hide_numpy}{blender_34.install}{RENDER}\ninstall({str(zip_path)!r})\nenable()\nprint('reason:', reason())"
    ).succeeded()
    assert "apt install python3-numpy" in result.says("reason:")


FAIL_IN_RENDER = """
import tyndall.renderer
def fail(*arguments, **names):
    raise RuntimeError("planted failure")
tyndall.renderer.Session.update = fail
tyndall.renderer.Session.render = fail
try:
    render({picture!r})
except RuntimeError as error:
    print("error:", str(error).splitlines()[0])
"""


def test_a_failure_in_the_render_is_an_error_and_no_crash(blender: Blender, zip_path: Path) -> None:
    """An exception before begin_result, with EXR as output, is a segmentation fault in all of them (139)."""
    picture = str(blender.user_folder / "picture.exr")
    result = blender.run(
        f"{blender.install}{RENDER}\ninstall({str(zip_path)!r})\nenable()\n{FAIL_IN_RENDER.format(picture=picture)}"
    )
    assert result.exit_code in {0, 1}, result.output
    assert "planted failure" in result.says("error:")


def test_the_engine_may_be_registered_at_exit(blender: Blender, zip_path: Path) -> None:
    """In its end bpy 4.5 hangs when a RenderEngine class is still registered, and 4.2 crashes."""
    blender.run(f"{blender.install}\ninstall({str(zip_path)!r})\nenable()").succeeded()


@pytest.mark.parametrize("version", ["4.5", "5.0"])
def test_a_script_renders_with_the_wheel_alone(version: str, site_packages: Path, tmp_path: Path) -> None:
    """The wheel carries the one add-on, which ``enable`` registers; nothing has to be undone before the script ends."""
    picture = str(tmp_path / "picture.exr")
    result = Bpy(version, tmp_path).run(
        f"import sys\nsys.path.append({str(site_packages)!r})\nimport tyndall.blender\ntyndall.blender.enable()\n"
        f"{RENDER}\nrender({picture!r})"
    )
    assert float(result.succeeded().says("brightest:")) > 0.01


@pytest.mark.long
def test_blender_4_2_installs_and_renders_as_well(zip_path: Path, tmp_path: Path) -> None:
    blender = Bpy("4.2", tmp_path)
    picture = str(tmp_path / "picture.exr")
    result = blender.run(f"{blender.install}{RENDER}\ninstall({str(zip_path)!r})\nenable()\nrender({picture!r})")
    assert float(result.succeeded().says("brightest:")) > 0.01
