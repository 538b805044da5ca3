# SPDX-License-Identifier: GPL-3.0-or-later
"""``python -m tyndall render`` with a stand-in for Blender: frames, resume, statistics and exit codes."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tyndall.command_line import BAD_OUTPUT, BAD_USAGE, INTERRUPTED, RENDER_FAILED, SUCCESS, Settings, main
from tyndall.voxel_dag import load


class StandIn:
    """Writes its frame's number; ``errors`` says what happens instead, by frame."""

    frames = (5,)

    def __init__(self, errors: dict[int, BaseException] | None = None) -> None:
        self.rendered: list[int] = []
        self.settings = Settings()
        self._errors = errors or {}

    def open(self, _path: Path, settings: Settings) -> StandIn:
        self.settings = settings
        return self

    def render(self, frame: int, path: Path) -> dict[str, Any]:
        self.rendered.append(frame)
        path.write_text(f"half of {frame}")
        if frame in self._errors:
            raise self._errors[frame]
        path.write_text(str(frame))
        return {"counts": {"triangles": 12}}


@pytest.fixture
def blend(tmp_path: Path) -> Path:
    path = tmp_path / "scene.blend"
    path.touch()
    return path


def run(blend: Path, stand_in: StandIn, *arguments: str) -> int:
    return main(["render", str(blend), "--output", str(blend.parent / "out" / "f.exr"), *arguments], stand_in.open)


def files(blend: Path) -> list[str]:
    return sorted(path.name for path in (blend.parent / "out").iterdir())


def test_a_still_has_exactly_the_name_that_was_asked_for(blend: Path) -> None:
    """Without --frames it is the frame that the file was saved at."""
    stand_in = StandIn()
    assert run(blend, stand_in, "--samples", "4", "--method", "EXACT") == SUCCESS
    assert stand_in.rendered == [5]
    assert (stand_in.settings.samples, stand_in.settings.method) == (4, "EXACT")
    assert files(blend) == ["f.exr"]


def test_the_same_command_resumes(blend: Path) -> None:
    """Frames whose file is there are skipped, unless all are wanted anew."""
    first, second, third = StandIn({3: RuntimeError("no light")}), StandIn(), StandIn()
    assert run(blend, first, "--frames", "1-4") == RENDER_FAILED
    assert first.rendered == [1, 2, 3, 4], "the frames after a failed one render, too"
    assert files(blend) == ["f_0001.exr", "f_0002.exr", "f_0004.exr"]
    assert run(blend, second, "--frames", "1-4") == SUCCESS
    assert second.rendered == [3]
    assert run(blend, third, "--frames", "1-4", "--overwrite") == SUCCESS
    assert third.rendered == [1, 2, 3, 4]


def test_statistics_tell_each_frame(blend: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = blend.parent / "statistics.json"
    run(blend, StandIn(), "--frames", "1")
    run(blend, StandIn({3: RuntimeError("no light")}), "--frames", "1-3", "--statistics", str(path))
    told = {entry["frame"]: entry for entry in json.loads(path.read_text())["frames"]}
    assert [told[frame]["status"] for frame in (1, 2, 3)] == ["rendered", "rendered", "failed"]
    assert told[2]["statistics"]["counts"]["triangles"] == 12
    assert "no light" in told[3]["error"]
    assert "frame 3: no light" in capsys.readouterr().err


def test_ctrl_c_ends_at_once_and_leaves_whole_files(blend: Path) -> None:
    stand_in = StandIn({2: KeyboardInterrupt()})
    assert run(blend, stand_in, "--frames", "1-9") == INTERRUPTED
    assert stand_in.rendered == [1, 2]
    assert files(blend) == ["f_0001.exr"]


def test_an_output_that_cannot_be_written_is_told_before_anything_renders(blend: Path) -> None:
    (blend.parent / "out").touch()  # a file where the folder should be
    stand_in = StandIn()
    assert run(blend, stand_in) == BAD_OUTPUT
    assert stand_in.rendered == []


@pytest.mark.parametrize(
    "arguments", [["--frames", "4-1"], ["--samples", "0"], ["--samples", "x"], ["--method", "MAGIC"]]
)
def test_wrong_arguments_are_named(blend: Path, arguments: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as ended:
        run(blend, StandIn(), *arguments)
    assert ended.value.code == BAD_USAGE
    assert arguments[1] in capsys.readouterr().err


def test_a_wrong_file_or_suffix_is_named(blend: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["render", "missing.blend", "--output", "x.exr"], StandIn().open) == BAD_USAGE
    assert main(["render", str(blend), "--output", "x.mp4"], StandIn().open) == BAD_USAGE
    told = capsys.readouterr().err
    assert "missing.blend" in told
    assert "x.mp4" in told


def test_a_file_that_blender_cannot_read_is_told_in_one_line(blend: Path, capsys: pytest.CaptureFixture[str]) -> None:
    def refuse(_path: Path, _settings: Settings) -> StandIn:
        raise RuntimeError("not a blend file")

    assert main(["render", str(blend), "--output", str(blend.parent / "x.exr")], refuse) == BAD_USAGE
    assert capsys.readouterr().err == "tyndall: not a blend file\n"


def test_without_bpy_the_message_says_what_to_install(blend: Path) -> None:
    """As a module, in a Python that has no bpy: isolated, so that none is found."""
    package = Path(__file__).parents[2] / "python"
    code = f"import sys; sys.path.insert(0, {str(package)!r}); from tyndall.command_line import main; sys.exit(main())"
    command = [sys.executable, "-I", "-c", code, "render", str(blend), "--output", str(blend.parent / "x.exr")]
    done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=60)
    assert done.returncode == BAD_USAGE
    assert "pip install bpy" in done.stderr


CUBE = "".join(f"v {x} {y} {z}\n" for x in (0, 1) for y in (0, 1) for z in (0, 1))
CUBE += "f 1 2 4 3\nf 5 6 8 7\nf 1 5 6 2\nf 3 4 8 7\nf 1 3 7 5\nf 2 6 8 4\n"


@pytest.fixture
def cube(tmp_path: Path) -> Path:
    path = tmp_path / "cube.obj"
    path.write_text(CUBE)
    return path


def voxelize(cube: Path, *arguments: str) -> int:
    return main(["voxelize", str(cube), "--out", str(cube.with_suffix(".tdag")), *arguments])


def test_a_mesh_becomes_a_voxel_dag(cube: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A shell of one voxel, whoever makes its parts."""
    sizes = set()
    for more in ([], ["--processes", "2"]):
        assert voxelize(cube, "--resolution", "64", "--rule", "conservative", "--budget", "1GiB", *more) == SUCCESS
        dag = load(cube.with_suffix(".tdag"))
        assert dag.voxel_count == 64**3 - 62**3
        sizes.add(cube.with_suffix(".tdag").stat().st_size)
    assert len(sizes) == 1
    told = capsys.readouterr().out
    assert "12 triangles" in told
    assert f"{64**3 - 62**3:,} voxels" in told
    assert sorted(path.name for path in cube.parent.iterdir()) == ["cube.obj", "cube.tdag"]


def test_a_meshs_colours_and_normals_go_along_when_they_are_asked_for(tmp_path: Path) -> None:
    positions_m, triangles = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]], np.float32), np.array([[0, 1, 2]])
    colors, normals = np.array([[250, 10, 60]] * 3, np.uint8), np.array([[0, 0, 1.0]] * 3)
    np.savez(tmp_path / "a.npz", positions_m=positions_m, triangles=triangles, colors=colors, normals=normals)
    arguments = ["voxelize", str(tmp_path / "a.npz"), "--resolution", "64", "--out", str(tmp_path / "a.tdag")]
    assert main([*arguments, "--colors", "--normals", "--normal-bits", "16"]) == SUCCESS
    dag = load(tmp_path / "a.tdag")
    voxels = np.concatenate(list(dag.coordinates()))
    assert (dag.colors_at(voxels) == [250, 10, 60]).all()
    assert np.allclose(dag.normals_at(voxels), [0, 0, 1], atol=0.02)
    assert main(arguments) == SUCCESS
    assert load(tmp_path / "a.tdag").attribute_bytes == 0


def test_colours_that_a_file_does_not_have_are_told(cube: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert voxelize(cube, "--resolution", "64", "--colors") == BAD_USAGE
    assert "cube.obj: its vertices have no colors" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("arguments", "culprit"),
    [
        (["--resolution", "100"], "100"),
        (["--resolution", "64", "--out", "a.vdb"], "a.vdb"),
        (["--resolution", "64", "--processes", "0"], "0 processes"),
        (["--resolution", "131072", "--budget", "64KiB"], "would fit"),
    ],
)
def test_what_cannot_become_voxels_is_named(
    cube: Path, arguments: list[str], culprit: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert voxelize(cube, *arguments) == BAD_USAGE
    assert culprit in capsys.readouterr().err


def test_an_amount_of_memory_is_a_number_and_its_unit(cube: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        voxelize(cube, "--resolution", "64", "--budget", "much")
    assert "much" in capsys.readouterr().err


def test_files_that_are_no_meshes_are_told_in_one_line(cube: Path, capsys: pytest.CaptureFixture[str]) -> None:
    cube.write_text("v 0 0 zero\n")
    assert voxelize(cube, "--resolution", "64") == BAD_OUTPUT
    assert main(["voxelize", "missing.ply", "--resolution", "64", "--out", "a.tdag"]) == BAD_USAGE
    wrong = cube.with_suffix(".stl")
    wrong.touch()
    assert voxelize(wrong, "--resolution", "64") == BAD_USAGE
    told = capsys.readouterr().err.splitlines()
    assert len(told) == 3
    assert all(name in line for name, line in zip(("cube.obj", "missing.ply", "cube.stl"), told, strict=True))
