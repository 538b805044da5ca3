# SPDX-License-Identifier: GPL-3.0-or-later
"""What does not fit is refused before memory is taken, with what to change; what fits is not."""

from __future__ import annotations

import os
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import pytest

from support.plain_scenes import camera_above, lit_square, unit_cube
from tyndall import InvalidInput, Progress, memory_estimate
from tyndall.memory_estimate import Part, free_bytes, picture_part, require_room, trees_part
from tyndall.renderer import RenderConfig, Session

GIB = 1 << 30


def output_of(script: str) -> str:
    """What a process of its own prints, which finds the modules that this one finds."""
    environment = os.environ | {"PYTHONPATH": os.pathsep.join(sys.path)}
    command = [sys.executable, "-c", script]
    return subprocess.run(command, env=environment, capture_output=True, text=True, check=True, timeout=120).stdout


def test_a_picture_takes_no_less_than_is_said() -> None:
    """Of a process of its own, which takes it. A bound that were too high would refuse what fits."""
    script = """
from pathlib import Path
from dataclasses import replace
from support.plain_scenes import camera_above, lit_square
from tyndall import Progress
from tyndall.memory_estimate import picture_part
from tyndall.renderer import RenderConfig, Session
session = Session()
session.update(lit_square(), Progress())
config = RenderConfig(pixel_samples=1, passes=frozenset({"Normal", "Depth"}))
def peak():
    lines = Path("/proc/self/status").read_text().splitlines()
    return next(int(line.split()[1]) << 10 for line in lines if line.startswith("VmHWM:"))
session.render(camera_above(), config, Progress())
before = peak()
session.render(replace(camera_above(), size_px=(3000, 3000)), config, Progress())
print(peak() - before, picture_part((3000, 3000), config.passes).at_least_bytes)
"""
    measured, said = map(int, output_of(script).split())
    assert 0.25 * measured < said <= measured


def test_a_picture_that_does_not_fit_is_refused_by_name(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(memory_estimate, "free_bytes", lambda: 4 * GIB)
    session = Session()
    session.update(lit_square(), Progress())
    huge = replace(camera_above(), size_px=(65536, 65536))
    with pytest.raises(
        InvalidInput, match=r"65536 x 65536 pixels takes 144\.0 GiB .* 4\.0 GiB are free: lower the res"
    ):
        session.render(huge, RenderConfig(pixel_samples=1), Progress())
    film = session.render(huge, RenderConfig(pixel_samples=1, region_px=(0, 0, 8, 8)), Progress())
    assert film.planes["Combined"].shape == (8, 8, 4)
    assert film.statistics["counts"]["picture's memory, at least, MiB"] == pytest.approx(64 * 36 / (1 << 20))


def test_the_largest_part_is_named() -> None:
    parts = [Part("a", GIB, "less a"), Part("b", 3 * GIB, "less b")]
    require_room(parts, free=4 * GIB)
    with pytest.raises(InvalidInput, match=r"^b takes 3\.0 GiB .* 1\.0 GiB, and 3\.5 GiB are free: less b$"):
        require_room(parts, free=7 * GIB // 2)


def test_what_is_small_asks_nobody(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(memory_estimate, "free_bytes", lambda: pytest.fail("asked"))
    require_room([picture_part((640, 360), {"Normal"}), trees_part([unit_cube()])])


def test_a_mesh_counts_once_however_often_it_is_met() -> None:
    assert trees_part([unit_cube(), unit_cube()]).at_least_bytes == trees_part([unit_cube()]).at_least_bytes > 0


def test_the_least_of_machine_and_limit_is_free() -> None:
    assert (free_bytes() or 0) > 0
    script = """
import resource
from tyndall.memory_estimate import free_bytes
resource.setrlimit(resource.RLIMIT_AS, (3 << 30, 3 << 30))
print(free_bytes())
"""
    assert 0 < int(output_of(script)) < 3 * GIB


def test_a_control_group_leaves_what_it_and_those_above_it_have_left(tmp_path: Path) -> None:
    inner = tmp_path / "outer" / "inner"
    inner.mkdir(parents=True)
    for folder, limit, used, cached in ((inner, "max", 10, 0), (inner.parent, str(4 * GIB), 3 * GIB, GIB // 2)):
        (folder / "memory.max").write_text(f"{limit}\n")
        (folder / "memory.current").write_text(f"{used}\n")
        (folder / "memory.stat").write_text(f"anon 5\ninactive_file {cached}\nactive_file 0\n")
    of_process = tmp_path / "cgroup"
    of_process.write_text("0::/outer/inner\n")
    assert memory_estimate.control_group_bytes(tmp_path, of_process) == 3 * GIB // 2
    of_process.write_text("12:memory:/elsewhere\n")
    assert memory_estimate.control_group_bytes(tmp_path, of_process) is None
