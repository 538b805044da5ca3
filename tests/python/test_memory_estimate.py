# SPDX-License-Identifier: GPL-3.0-or-later
"""What does not fit is refused before memory is taken, with what to change; what fits is not."""

from __future__ import annotations

import os
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from support.plain_scenes import camera_above, lit_square, placed, translation, unit_cube
from tyndall import InvalidInput, Progress, memory_estimate
from tyndall.memory_estimate import (
    Part,
    fog_part,
    free_bytes,
    picture_part,
    require_room,
    require_room_for_image,
    scene_parts,
)
from tyndall.renderer import Film, RenderConfig, Session, ShaftConfig
from tyndall.scene_description import Light, LightKind, Medium, ScatterLobe, World

GIB = 1 << 30


def output_of(script: str) -> str:
    """What a process of its own prints, which finds the modules that this one finds."""
    environment = os.environ | {"PYTHONPATH": os.pathsep.join(sys.path)}
    command = [sys.executable, "-c", script]
    return subprocess.run(command, env=environment, capture_output=True, text=True, check=True, timeout=120).stdout


#: What a process of its own takes beyond what it had, and what was said.
MEASURED = """
from dataclasses import replace
from pathlib import Path
import numpy as np
from support.plain_scenes import camera_above, lit_square, placed, square, unit_cube
from tyndall import Progress
from tyndall.memory_estimate import fog_part, picture_part, scene_parts
from tyndall.renderer import DataConfig, RenderConfig, Session, ShaftConfig
from tyndall.scene_description import Material, Medium, Mesh, ScatterLobe, StrandForm, StrandObjects, Strands, World
def peak():
    lines = Path("/proc/self/status").read_text().splitlines()
    return next(int(line.split()[1]) << 10 for line in lines if line.startswith("VmHWM:"))
def begin():
    Path("/proc/self/clear_refs").write_text("5")  # the peak is forgotten: what is there now is all
    return peak()
session = Session()
session.update(lit_square(), Progress())
"""


@pytest.mark.parametrize(
    "settings",
    [
        'passes=frozenset({"Normal", "Depth"})',
        'passes=frozenset({"CryptoObject", "CryptoMaterial", "UV", "Vector", "IndexOB", "Denoising Albedo"})',
        'data=DataConfig(aovs=(("a", True), ("b", False)), matte_ranks=3), passes=frozenset({"CryptoAsset"})',
    ],
)
def test_a_picture_takes_no_less_than_is_said(settings: str) -> None:
    """A bound that were too high would refuse what fits."""
    script = f"""
config = RenderConfig(pixel_samples=1, {settings})
session.render(camera_above(), config, Progress())
before = begin()
session.render(replace(camera_above(), size_px=(1200, 1200)), config, Progress())
print(peak() - before, picture_part((1200, 1200), config.passes, config.data).at_least_bytes)
"""
    measured, said = map(int, output_of(MEASURED + script).split())
    assert 0.25 * measured < said <= measured


@pytest.mark.parametrize("medium", ["lobes=(ScatterLobe(sigma_s_per_m=(0.02,) * 3),)", "sigma_a_per_m=(0.1, 0.1, 0.1)"])
@pytest.mark.parametrize(
    "where",
    [
        "world=World(medium=0)",
        (
            "instances=(placed(square(), np.eye(4)), placed(unit_cube(), 0.2 * np.eye(4), materials=(1,))),"
            "materials=(Material(name='grey'), Material(name='box', has_surface=False, medium=0))"
        ),
    ],
)
def test_fog_takes_no_less_than_is_said(medium: str, where: str) -> None:
    """Of a box in a hundredth of the picture as much waits as of a world, and of fog that scatters nothing."""
    script = f"""
session.update(lit_square(media=(Medium(name="fog", {medium}),), {where}), Progress())
config, size_px = RenderConfig(pixel_samples=1, shafts=ShaftConfig(resolution=64)), (1200, 1200)
session.render(camera_above(), config, Progress())
before = begin()
session.render(replace(camera_above(), size_px=size_px), config, Progress())
print(peak() - before, picture_part(size_px, ()).at_least_bytes + fog_part(size_px).at_least_bytes)
"""
    measured, said = map(int, output_of(MEASURED + script).split())
    assert 0.25 * measured < said <= measured


@pytest.mark.parametrize(
    "parts",
    [
        "instances=(placed(unit_cube(), *places),)",
        "strand_objects=(StrandObjects(strands=hair, world_from_object=np.eye(4)[None], object_names=('hair',)),)",
        "strand_objects=(StrandObjects(strands=points, world_from_object=np.eye(4)[None], object_names=('dust',)),)",
        "instances=(placed(hill, np.eye(4)),)",
    ],
)
def test_a_scene_takes_no_less_than_is_said(parts: str) -> None:
    script = f"""
random = np.random.default_rng(1)
places = np.tile(np.eye(4), (200_000, 1, 1))
places[:, :3, 3] = random.uniform(-100, 100, (len(places), 3))
roots = np.repeat(random.uniform(-1, 1, (50_000, 3)), 8, axis=0)
roots[:, 2] += np.tile(np.linspace(0, 0.1, 8), 50_000)
lines = np.column_stack([roots, np.full(len(roots), 1e-3)]).astype(np.float32)
firsts = np.arange(0, len(lines), 8, dtype=np.uint32)
hair = Strands(key="hair", name="hair", form=StrandForm.RIBBON, points=lines, first_points=firsts)
points = Strands(key="dust", name="dust", form=StrandForm.SPHERES, points=lines, first_points=firsts[:0])
x, y = np.meshgrid(np.arange(600, dtype=np.float32), np.arange(600, dtype=np.float32))
first = (np.arange(599)[:, None] * 600 + np.arange(599)).reshape(-1)
hill = Mesh(
    key="hill",
    name="hill",
    positions=np.stack([x, y, np.sin(x) * np.cos(y)], axis=-1).reshape(-1, 3),
    triangles=np.stack([first, first + 1, first + 600, first + 1, first + 601, first + 600], -1)
    .reshape(-1, 3)
    .astype(np.uint32),
)
scene = lit_square({parts})
before = begin()
session.update(scene, Progress())
print(peak() - before, sum(part.at_least_bytes for part in scene_parts(scene, ())))
"""
    measured, said = map(int, output_of(MEASURED + script).split())
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


def test_fog_that_does_not_fit_is_refused_where_the_picture_alone_fits(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(memory_estimate, "free_bytes", lambda: 180 * GIB)
    session = Session()
    session.update(lit_square(media=(Medium(name="fog", sigma_a_per_m=(1.0,) * 3),), world=World(medium=0)), Progress())
    huge = replace(camera_above(), size_px=(65536, 65536))
    with pytest.raises(InvalidInput, match=r"^the fog in 65536 x 65536 pixels takes .*: lower the resolution"):
        session.render(huge, RenderConfig(pixel_samples=1), Progress())


@pytest.mark.parametrize("method", ["EPIPOLAR", "SHADOW_MAP"])
@pytest.mark.parametrize("radius_m", [0.0, 0.1])
def test_shafts_take_the_room_of_their_maps_and_rows_and_no_more(
    method: str, radius_m: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The statistics count the rows of one of a lamp's strata; each has maps of six faces beside them."""
    strata, lines = (4, 256) if radius_m else (1, 512)
    lamp = Light(
        name="Lamp",
        kind=LightKind.POINT,
        strength=(1.0,) * 3,
        world_from_light=translation(0.3, 0.2, 2),
        radius_m=radius_m,
    )
    fog = Medium(name="fog", lobes=(ScatterLobe(sigma_s_per_m=(0.02,) * 3),))
    session = Session()
    session.update(lit_square(lights=(lamp,), media=(fog,), world=World(medium=0)), Progress())
    shafts = ShaftConfig(method=method, resolution=512, light_samples=4)
    config, size_px = RenderConfig(pixel_samples=1, shafts=shafts), camera_above().size_px
    taken_before = picture_part(size_px, ()).at_least_bytes + fog_part(size_px).at_least_bytes

    def picture(room_bytes: int) -> Film:
        monkeypatch.setattr(memory_estimate, "free_bytes", lambda: taken_before + room_bytes)
        return session.render(camera_above(), config, Progress())

    ample = picture(GIB)
    rows_bytes = int(ample.statistics["counts"]["slope rows: bytes"])
    maps_bytes = 6 * lines * lines * 9 // 2 if method == "SHADOW_MAP" else 0
    with pytest.raises(InvalidInput, match=r"maps and rows of light shafts take .* GiB .*: render a region"):
        picture(rows_bytes - 1)
    again = picture(strata * int(1.1 * (rows_bytes + maps_bytes)))
    assert np.array_equal(ample.planes["Combined"], again.planes["Combined"])


def test_the_largest_part_is_named() -> None:
    parts = [Part("a", GIB, "less a"), Part("b", 3 * GIB, "less b")]
    require_room(parts, free=4 * GIB)
    with pytest.raises(InvalidInput, match=r"^b takes 3\.0 GiB .* 1\.0 GiB, and 3\.5 GiB are free: less b$"):
        require_room(parts, free=7 * GIB // 2)


def test_what_is_small_asks_nobody(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(memory_estimate, "free_bytes", lambda: pytest.fail("asked"))
    require_room([picture_part((640, 360), {"Normal"}), *scene_parts(lit_square(), ())])


def test_a_mesh_counts_once_however_often_it_is_met() -> None:
    once, twice = (lit_square(instances=(placed(unit_cube(), np.eye(4)),) * count) for count in (1, 2))
    assert scene_parts(twice, ())[0] == scene_parts(once, ())[0]
    assert scene_parts(once, ())[0].at_least_bytes > scene_parts(once, {"cube"})[0].at_least_bytes == 0


def test_an_image_is_named() -> None:
    with pytest.raises(InvalidInput, match=r'^image "wall.png" of 9000000 x 9000000 pixels takes .* scale it down$'):
        require_room_for_image("wall.png", (9_000_000, 9_000_000), 4)


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
