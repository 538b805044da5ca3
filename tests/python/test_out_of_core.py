# SPDX-License-Identifier: GPL-3.0-or-later
"""Voxel DAGs in parts: the bytes of one made at once, whatever happened on the way; and what is known before."""

from __future__ import annotations

import re
import subprocess
import sys
import threading
import time
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import tyndall
from support.full_disk import largest_file
from support.large_triangles import large_triangles
from tyndall import _image_io
from tyndall.voxel_dag import Config, Material, Textures, forecast, from_coordinates, voxelize, voxelize_to_file
from tyndall.voxel_dag.parts import parts_of

CONFIG = Config(resolution=1024, memory_budget_bytes=8 << 20)


@pytest.fixture(scope="module")
def at_once(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    path = tmp_path_factory.mktemp("at_once") / "a.tdag"
    voxelize(*large_triangles(), Config(resolution=1024)).save(path)
    return path.read_bytes()


def has_come_to_part(progress: tyndall.Progress, number: int) -> bool:
    """Or beyond: a part may come and go while who waits for it sleeps."""
    at_work = re.match(r"Voxels: part (\d+) ", progress.message)
    return at_work is not None and int(at_work[1]) >= number


def stop_at_part(progress: tyndall.Progress, number: int) -> threading.Thread:
    """Cancels when a later part is at work."""

    def watch() -> None:
        while not has_come_to_part(progress, number):
            if progress.fraction > 0.7:
                return
            time.sleep(0.001)
        progress.cancel()

    thread = threading.Thread(target=watch)
    thread.start()
    return thread


@pytest.mark.parametrize("workers", [None, 2])
def test_the_file_is_that_of_a_mesh_made_at_once(tmp_path: Path, at_once: bytes, workers: int | None) -> None:
    progress, scratch = tyndall.Progress(), tmp_path / "scratch"
    dag = voxelize_to_file(
        *large_triangles(), tmp_path / "a.tdag", CONFIG, scratch=scratch, progress=progress, workers=workers
    )
    assert (tmp_path / "a.tdag").read_bytes() == at_once
    assert dag.voxel_count == voxelize(*large_triangles(), Config(resolution=1024)).voxel_count
    assert progress.fraction == 1.0
    assert list(scratch.iterdir()) == []


def test_a_cancelled_call_goes_on_from_what_it_has_finished(tmp_path: Path, at_once: bytes) -> None:
    progress = tyndall.Progress()
    watcher = stop_at_part(progress, 4)
    with pytest.raises(tyndall.Cancelled):
        parts_of(*large_triangles(), CONFIG, tmp_path / "scratch", progress).finish(tmp_path / "a.tdag", progress)
    watcher.join()
    assert not (tmp_path / "a.tdag").exists()
    statistics = parts_of(*large_triangles(), CONFIG, tmp_path / "scratch", tyndall.Progress()).finish(
        tmp_path / "a.tdag", tyndall.Progress()
    )
    assert 3 <= statistics.kept_part_count < statistics.part_count
    assert statistics.damaged_parts == []
    assert (tmp_path / "a.tdag").read_bytes() == at_once


def test_a_killed_process_loses_only_the_part_at_work(tmp_path: Path, at_once: bytes) -> None:
    code = f"""
import os, signal, sys, threading, time
sys.path[:0] = {sys.path!r}
from support.large_triangles import large_triangles
from test_out_of_core import CONFIG, has_come_to_part
from tyndall import Progress
from tyndall.voxel_dag.parts import parts_of
progress = Progress()
def kill():
    while not has_come_to_part(progress, 4):
        time.sleep(0.001)
    os.kill(os.getpid(), signal.SIGKILL)
threading.Thread(target=kill, daemon=True).start()
parts = parts_of(*large_triangles(), CONFIG, {str(tmp_path / "scratch")!r}, progress)
parts.finish("/never.tdag", progress)
"""
    command = [sys.executable, "-c", f"import sys; sys.path.insert(0, {str(Path(__file__).parent)!r})\n{code}"]
    assert subprocess.run(command, check=False, timeout=300).returncode == -9
    parts = parts_of(*large_triangles(), CONFIG, tmp_path / "scratch", tyndall.Progress())
    statistics = parts.finish(tmp_path / "a.tdag", tyndall.Progress())
    assert statistics.kept_part_count >= 3
    assert (tmp_path / "a.tdag").read_bytes() == at_once
    assert list((tmp_path / "scratch").iterdir()) == []


def test_a_full_disk_keeps_finished_parts_and_says_where(tmp_path: Path, at_once: bytes) -> None:
    """Full in the middle of the parts, and full when the file itself is written."""
    scratch = tmp_path / "scratch"
    parts = parts_of(*large_triangles(), CONFIG, scratch, tyndall.Progress())
    assert parts.part_count > 8
    for part in range(parts.part_count):
        parts.make_part(part, tyndall.Progress())
    sizes = [Path(parts.part_path(part)).stat().st_size for part in range(parts.part_count)]
    largest = int(np.argmax(sizes))
    Path(parts.part_path(largest)).unlink()
    with largest_file(sizes[largest] - 1), pytest.raises(tyndall.IoError, match=r"room.*parts are kept in .*scratch"):
        voxelize_to_file(*large_triangles(), tmp_path / "a.tdag", CONFIG, scratch=scratch)
    parts.make_part(largest, tyndall.Progress())
    with largest_file(len(at_once) - 1), pytest.raises(tyndall.IoError, match=r"a\.tdag: .*room.*kept in .*scratch"):
        voxelize_to_file(*large_triangles(), tmp_path / "a.tdag", CONFIG, scratch=scratch)
    assert not (tmp_path / "a.tdag").exists()
    statistics = parts.finish(tmp_path / "a.tdag", tyndall.Progress())
    assert statistics.kept_part_count == statistics.part_count
    assert (tmp_path / "a.tdag").read_bytes() == at_once


def test_a_job_at_work_in_another_process_is_left_alone(tmp_path: Path) -> None:
    """As a lock that this process holds, on a file that every such job opens."""
    import fcntl  # noqa: PLC0415 - of this one test

    parts = parts_of(*large_triangles(), CONFIG, tmp_path, tyndall.Progress())
    folder = Path(parts.part_path(0)).parent
    folder.mkdir()
    with (folder / "lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        with pytest.raises(tyndall.IoError, match="another process"):
            parts.finish(tmp_path / "a.tdag", tyndall.Progress())
    parts.finish(tmp_path / "a.tdag", tyndall.Progress())


def carrying(folder: Path, kind: str) -> dict[str, Any]:
    """Settings of the large triangles' 36 vertices, by kind; the picture is a file."""
    random = np.random.default_rng(3)
    colors, normals = random.integers(0, 256, (36, 3)).astype(np.uint8), random.normal(size=(36, 3))
    if kind == "pictures":
        pixels = random.integers(0, 256, (32, 32, 3)).astype(np.uint8)
        _image_io.write_png(folder / "checks.png", pixels)
        uvs = random.uniform(0, 2, (12, 3, 2))
        materials = [Material(picture=folder / "checks.png", outside="mirror"), Material(color=(0.9, 0.3, 0.2))]
        return {
            "textures": Textures(materials=materials, corner_uvs=uvs, material_of_triangle=np.arange(12) % 2),
            "normals": "faces",
        }
    all_kinds = {"colors": colors, "normals": normals, "channels": {"wet": random.integers(0, 4, 36)}}
    few = {"colors": colors, "most_color_difference": 4.0, "bounds_m": ((-0.2, -0.2, -0.2), (1.3, 1.3, 1.3))}
    return {"all": all_kinds | {"normal_bits": 8}, "few": few}[kind]


@pytest.mark.parametrize("kind", ["all", "few", "pictures"])
@pytest.mark.parametrize("workers", [None, 2])
def test_what_voxels_carry_is_that_of_a_mesh_made_at_once(tmp_path: Path, kind: str, workers: int | None) -> None:
    """Interrupted once on the way; workers are given pictures as they were when the job began."""
    config = Config(resolution=512, memory_budget_bytes=160 << 20, **carrying(tmp_path, kind))
    voxelize(*large_triangles(), replace(config, memory_budget_bytes=None)).save(tmp_path / "at_once.tdag")
    scratch = tmp_path / "scratch"
    parts = parts_of(*large_triangles(), config, scratch, tyndall.Progress(), worker_count=64)  # small ones
    assert parts.part_count > 8
    progress = tyndall.Progress()
    watcher = stop_at_part(progress, 3)
    with pytest.raises(tyndall.Cancelled):
        parts.finish(tmp_path / "a.tdag", progress)
    watcher.join()
    dag = voxelize_to_file(*large_triangles(), tmp_path / "a.tdag", config, scratch=scratch, workers=workers)
    assert (tmp_path / "a.tdag").read_bytes() == (tmp_path / "at_once.tdag").read_bytes()
    assert list((tmp_path / "scratch").iterdir()) == []
    assert dag.attribute_bytes > 0


def test_a_disk_that_is_full_while_attributes_are_joined_keeps_the_parts(tmp_path: Path) -> None:
    config = Config(resolution=512, memory_budget_bytes=160 << 20, **carrying(tmp_path, "all"))
    parts = parts_of(*large_triangles(), config, tmp_path / "scratch", tyndall.Progress(), worker_count=64)
    for part in range(parts.part_count):
        parts.make_part(part, tyndall.Progress())
    largest = max(Path(parts.part_path(part)).stat().st_size for part in range(parts.part_count))
    voxelize(*large_triangles(), replace(config, memory_budget_bytes=None)).save(tmp_path / "at_once.tdag")
    wanted = (tmp_path / "at_once.tdag").read_bytes()
    assert largest < len(wanted) // 2
    with largest_file(largest), pytest.raises(tyndall.IoError, match=r"room.*parts are kept in .*scratch"):
        parts.finish(tmp_path / "a.tdag", tyndall.Progress())
    assert parts.finish(tmp_path / "a.tdag", tyndall.Progress()).kept_part_count == parts.part_count
    assert (tmp_path / "a.tdag").read_bytes() == wanted


def test_in_memory_a_budget_counts_what_voxels_carry() -> None:
    """Of a full cube, whose graph is next to nothing."""
    voxels = np.argwhere(np.ones((128, 128, 128), bool))
    bare = Config(resolution=128, memory_budget_bytes=16 << 20)
    from_coordinates(voxels, bare)
    colored = replace(bare, colors=np.zeros_like(voxels, np.uint8))
    with pytest.raises(tyndall.InvalidInput, match=r"2097152 voxels take about 24 MiB.*budget is 16 MiB"):
        from_coordinates(voxels, colored)
    from_coordinates(voxels, replace(colored, memory_budget_bytes=24 << 20))


@pytest.mark.parametrize("workers", [None, 2])
def test_a_solid_in_parts_is_that_made_at_once(tmp_path: Path, workers: int | None) -> None:
    corners = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], float)
    sides = ((0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3))
    triangles = np.array([part for a, b, c, d in sides for part in ((a, b, c), (a, c, d))])
    turned = corners @ np.linalg.qr(np.arange(9.0).reshape(3, 3) ** 2 + np.eye(3))[0]
    config = Config(resolution=512, solid=True, memory_budget_bytes=24 << 20)
    voxelize(turned, triangles, replace(config, memory_budget_bytes=None)).save(tmp_path / "at_once.tdag")
    voxelize_to_file(turned, triangles, tmp_path / "parts.tdag", config, workers=workers)
    assert (tmp_path / "parts.tdag").read_bytes() == (tmp_path / "at_once.tdag").read_bytes()


def test_a_forecast_is_the_truth_within_a_factor_of_two() -> None:
    mesh = large_triangles(8, 2)
    before, dag = forecast(*mesh, Config(resolution=4096)), voxelize(*mesh, Config(resolution=4096))
    assert 0.5 < before.voxel_count / dag.voxel_count < 2
    assert 0.5 < before.file_bytes / dag.geometry_bytes < 2
    assert "million voxels" in str(before)
    small = forecast(*mesh, Config(resolution=64))
    assert small.voxel_count == voxelize(*mesh, Config(resolution=64)).voxel_count


def test_what_has_no_room_is_refused_with_what_would_fit(tmp_path: Path) -> None:
    wanted = Config(resolution=131072, memory_budget_bytes=256 << 20)
    with pytest.raises(
        tyndall.InvalidInput, match=r"131072: there are 256 MiB of memory.*resolution of (\d+) would fit"
    ):
        voxelize_to_file(*large_triangles(60), tmp_path / "a.tdag", wanted)
    with pytest.raises(tyndall.InvalidInput, match="does not close"):
        voxelize_to_file(*large_triangles(), tmp_path / "a.tdag", Config(solid=True))
    with pytest.raises(tyndall.InvalidInput, match="262144"):
        voxelize_to_file(*large_triangles(), tmp_path / "a.tdag", Config(resolution=262144))
    assert list(tmp_path.iterdir()) == []
