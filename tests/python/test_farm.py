# SPDX-License-Identifier: GPL-3.0-or-later
"""Frames as jobs on a cluster of this machine: nothing is lost, and every bit is that of one process."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from support.exr import read_channels, read_stamps
from tyndall.command_line import BAD_USAGE, RENDER_FAILED, SUCCESS, main
from tyndall.farm_tasks import TaskError, run_task

REPOSITORY = Path(__file__).parents[2]
BPY_PYTHON = Path(os.environ.get("TYNDALL_BPY_PYTHON") or REPOSITORY / ".deps/bpy45/bin/python")
distributed = pytest.importorskip("distributed")
pytestmark = pytest.mark.skipif(not BPY_PYTHON.is_file(), reason="needs a Python that has bpy")

SCENE = """
import sys, bpy, tyndall.blender
tyndall.blender.enable()
from support.beam_scene import build_beam_scene
scene = build_beam_scene()
scene.render.resolution_x, scene.render.resolution_y = 70, 42
scene.render.image_settings.exr_codec = "NONE"
bpy.data.lights["Lamp"].shadow_soft_size = 0.2
scene.tyndall.pixel_samples, scene.tyndall.noise_threshold = 8, 0.02
scene.world.node_tree.nodes["Background"].inputs["Color"].default_value = (0.3, 0.3, 0.4, 1)
scene.view_layers[0].use_pass_z = scene.view_layers[0].use_pass_normal = True
scene.view_layers[0].use_pass_cryptomatte_object = True
other = scene.view_layers.new("Other")
other.use_pass_shadow = other.use_pass_mist = other.use_pass_cryptomatte_material = True
for frame in (1, 2):
    scene.camera.location.x = 6 + 0.2 * frame
    scene.camera.keyframe_insert("location", frame=frame)
bpy.ops.wm.save_as_mainfile(filepath=sys.argv[1])
"""


def folders() -> str:
    return os.pathsep.join(str(REPOSITORY / folder) for folder in ("python", "build/release/python", "tests"))


@pytest.fixture(scope="module")
def blend(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("farm") / "scene.blend"
    environment = os.environ | {"PYTHONPATH": folders()}
    subprocess.run([BPY_PYTHON, "-c", SCENE, str(path)], check=True, env=environment, capture_output=True, timeout=180)
    return path


@pytest.fixture(scope="module")
def cluster() -> Iterator[distributed.LocalCluster]:
    with distributed.LocalCluster(
        n_workers=2, threads_per_worker=1, processes=True, host="127.0.0.1", dashboard_address=":0", silence_logs=50
    ) as cluster:
        yield cluster


@pytest.fixture(autouse=True)
def bpy_python(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("TYNDALL_BPY_PYTHON", str(BPY_PYTHON))


@pytest.fixture(scope="module", autouse=True)
def python_of_workers() -> Iterator[None]:
    """Before the cluster's processes begin."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("TYNDALL_BPY_PYTHON", str(BPY_PYTHON))
        patch.setenv("PYTHONPATH", os.pathsep.join([folders(), *sys.path]))
        yield


def render(blend: Path, folder: Path, *arguments: str) -> int:
    return main(["render", str(blend), "--output", str(folder / "f_####.exr"), "--multilayer", *arguments])


def one_process(blend: Path, folder: Path, simd: str) -> dict[str, dict[str, bytes]]:
    """All frames by a session that keeps what stays from frame to frame."""
    code = (
        "import sys; from tyndall import _native; from tyndall.command_line import main\n"
        f"forced = _native.ForcedSimdTarget({simd!r}); sys.exit(main(sys.argv[1:]))"
    )
    arguments = ["render", str(blend), "--output", str(folder / "f_####.exr"), "--frames", "1-2", "--multilayer"]
    environment = os.environ | {"PYTHONPATH": folders()}
    subprocess.run([BPY_PYTHON, "-c", code, *arguments], check=True, env=environment, capture_output=True, timeout=300)
    return pictures(folder)


def pictures(folder: Path) -> dict[str, dict[str, bytes]]:
    """The pixels of the files: what Blender stamps beside them has the time of day."""
    return {
        path.name: {name: plane.tobytes() for name, plane in read_channels(path).items()}
        | {name: text.encode() for name, text in read_stamps(path).items()}
        for path in folder.glob("*.exr")
    }


def test_a_cluster_that_loses_a_worker_renders_the_frames_of_one_process(
    blend: Path, tmp_path: Path, cluster: distributed.LocalCluster
) -> None:
    """Tiles, view layers, frames; a worker is killed while it renders, and a frame that was there stays."""
    simd = "SSE4"
    wanted = one_process(blend, tmp_path / "one", simd)
    assert len(wanted) == 2
    assert sum(name.startswith("cryptomatte/") for name in wanted["f_0001.exr"]) == 2 * 4

    def kill_one() -> None:
        deadline = time.monotonic() + 60.0
        while not list((tmp_path / "farm").glob(".f*.parts/*.npz")) and time.monotonic() < deadline:
            time.sleep(0.02)
        os.kill(cluster.workers[0].process.process.pid, signal.SIGKILL)

    killer = threading.Thread(target=kill_one)
    killer.start()
    arguments = ("--scheduler", cluster.scheduler_address, "--simd", simd)
    first = tmp_path / "farm" / "f_0001.exr"
    assert render(blend, first.parent, *arguments, "--frames", "1", "--tiles", "2x2", "--view-layers") == SUCCESS
    killer.join()
    assert pictures(first.parent) == {first.name: wanted[first.name]}
    assert list(first.parent.iterdir()) == [first], "no part is left"
    kept = first.stat().st_mtime_ns
    assert render(blend, first.parent, *arguments, "--frames", "1-2") == SUCCESS
    assert pictures(first.parent) == wanted
    assert first.stat().st_mtime_ns == kept


def test_a_job_that_fails_is_tried_again_and_named(
    blend: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    arguments = ["render", str(blend), "--output", str(tmp_path / "f.png"), "--multilayer"]
    assert main([*arguments, "--processes", "1", "--retries", "1"]) == RENDER_FAILED
    told = capsys.readouterr().out
    assert told.count("only an .exr holds several layers") == 2
    assert told.count("it is tried again") == 1
    assert list(tmp_path.iterdir()) == []


def test_what_keeps_workers_from_rendering_is_told_in_one_line(
    blend: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    assert render(blend, tmp_path, "--scheduler", "tcp://127.0.0.1:1") == BAD_USAGE
    monkeypatch.setenv("TYNDALL_BPY_PYTHON", sys.executable)
    assert render(blend, tmp_path, "--processes", "1") == BAD_USAGE
    told = capsys.readouterr().err.splitlines()
    assert "no Dask scheduler at tcp://127.0.0.1:1" in told[0]
    assert "has no bpy" in told[-1]


def test_tasks_name_what_a_machine_lacks(blend: Path) -> None:
    task = {"kind": "probe", "file": str(blend), "simd": None, "versions": {}}
    versions = run_task(task)
    assert set(versions) == {"Tyndall", "Blender"}
    with pytest.raises(TaskError, match=r"has Blender .*, not 9\.9: all machines"):
        run_task(task | {"versions": {"Blender": "9.9"}})
    with pytest.raises(TaskError, match=r"does not see .*gone\.blend"):
        run_task(task | {"file": str(blend.with_name("gone.blend"))})
