# SPDX-License-Identifier: GPL-3.0-or-later
"""Jobs with files in and files out: each is done once, and what died is run again, wherever they run."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

import tyndall
from support.job_functions import die, do_nothing, refuse, write, write_or_die
from support.large_triangles import large_triangles
from tyndall import jobs
from tyndall.jobs import Job
from tyndall.voxel_dag import Config, voxelize, voxelize_to_file
from tyndall.voxel_dag.parts import part_jobs


def writing(folder: Path, count: int) -> list[Job]:
    return [Job(write, (folder / f"{i}.txt", str(i)), folder / f"{i}.txt") for i in range(count)]


def texts(folder: Path) -> list[str]:
    return sorted(path.read_text() for path in folder.glob("*.txt"))


@pytest.fixture(scope="module")
def scheduler() -> Iterator[str]:
    """The address of a cluster of two processes on this machine."""
    distributed = pytest.importorskip("distributed")
    with distributed.LocalCluster(
        n_workers=2, threads_per_worker=1, processes=True, host="127.0.0.1", dashboard_address=":0", silence_logs=50
    ) as cluster:
        yield cluster.scheduler_address


def test_what_is_done_is_not_done_again(tmp_path: Path) -> None:
    (tmp_path / "1.txt").write_text("was there")
    progress = tyndall.Progress()
    jobs.run(writing(tmp_path, 3), None, progress, share=0.75)
    assert texts(tmp_path) == ["0", "2", "was there"]
    assert progress.fraction == pytest.approx(0.75)


def test_processes_do_all_and_a_killed_one_is_replaced(tmp_path: Path) -> None:
    dying = Job(write_or_die, (tmp_path / "x.txt", "x", tmp_path / "marker"), tmp_path / "x.txt")
    jobs.run([*writing(tmp_path, 4), dying], 2)
    assert texts(tmp_path) == ["0", "1", "2", "3", "x"]


def test_a_job_that_kills_each_process_ends_with_its_name_and_the_others_stay(tmp_path: Path) -> None:
    deadly = Job(die, (tmp_path / "never.txt",), tmp_path / "never.txt")
    with pytest.raises(tyndall.IoError, match=r"never\.txt.*memory"):
        jobs.run([*writing(tmp_path, 2), deadly], 1)
    assert texts(tmp_path) == ["0", "1"]


@pytest.mark.parametrize("workers", [None, 1])
def test_what_a_job_raises_is_raised_and_one_without_a_file_is_named(tmp_path: Path, workers: int | None) -> None:
    with pytest.raises(ValueError, match="no such photon"):
        jobs.run([Job(refuse, (tmp_path / "a",), tmp_path / "a")], workers)
    with pytest.raises(tyndall.IoError, match=r"a: .*wrote no file"):
        jobs.run([Job(do_nothing, (tmp_path / "a",), tmp_path / "a")], workers)


def test_a_cancelled_run_starts_nothing(tmp_path: Path) -> None:
    progress = tyndall.Progress()
    progress.cancel()
    with pytest.raises(tyndall.Cancelled):
        jobs.run(writing(tmp_path, 3), None, progress)
    assert texts(tmp_path) == []


def test_without_dask_the_message_says_what_to_install(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(tyndall.InvalidInput, match="pip install distributed"):
        jobs.run(writing(tmp_path, 1), "tcp://127.0.0.1:1")


def test_a_cluster_that_loses_a_worker_loses_nothing(tmp_path: Path, scheduler: str) -> None:
    """Parts of a voxel DAG, and between them a job that kills its worker: the file is that of one process."""
    positions, triangles = large_triangles()
    config = Config(resolution=1024, memory_budget_bytes=8 << 20)
    voxelize(positions, triangles, Config(resolution=1024)).save(tmp_path / "at_once.tdag")
    parts = part_jobs(positions, triangles, config, tmp_path)
    assert len(parts) > 8
    dying = Job(write_or_die, (tmp_path / "x.txt", "x", tmp_path / "marker"), tmp_path / "x.txt")
    jobs.run([*parts[:4], dying, *parts[4:]], scheduler)
    assert (tmp_path / "marker").exists()
    assert texts(tmp_path) == ["x"]
    assert all(part.output.exists() for part in parts)
    voxelize_to_file(positions, triangles, tmp_path / "in_parts.tdag", config, workers=scheduler)
    assert (tmp_path / "in_parts.tdag").read_bytes() == (tmp_path / "at_once.tdag").read_bytes()
    assert {path.name for path in tmp_path.iterdir()} == {"at_once.tdag", "in_parts.tdag", "marker", "x.txt"}


def test_who_imports_jobs_can_be_a_script_of_blender() -> None:
    """Multiprocessing keeps ``__main__``, which Blender frees when a script has run: 3.4 crashed when it was left."""
    code = "import sys, tyndall.voxel_dag; sys.exit('__mp_main__' in sys.modules)"
    subprocess.run([sys.executable, "-c", code], env={"PYTHONPATH": os.pathsep.join(sys.path)}, check=True)
