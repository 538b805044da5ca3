# SPDX-License-Identifier: GPL-3.0-or-later
"""What nodes read of a point, its object and the asking ray is what Cycles reads there."""

from __future__ import annotations

import pytest

from support.engine_pictures import cycles_pixels, tyndall_pixels
from support.input_setups import INPUT_SETUPS
from support.patch_nodes import Link, New, Shown, Socket, shown_on_patches
from support.small_scenes import add, empty_scene, material, mesh

#: A picture of Cycles is up to a hundredth of a pixel off its pixels' centres.
BOUND = 2e-3


@pytest.fixture(scope="module")
def shown() -> dict[str, Shown]:
    return shown_on_patches(INPUT_SETUPS)


# Seen to fail with another turn of bits in the hash of an object's name.
@pytest.mark.parametrize("name", INPUT_SETUPS)
def test_a_point_is_read_as_in_cycles(shown: dict[str, Shown], name: str) -> None:
    # A corner of a triangle, at which a tangent bends, or a wire may lie on the other side of a pixel's centre.
    share = 0.97 if any(word in name.lower() for word in ("tangent", "wireframe")) else 1.0
    assert shown[name].off(share) < BOUND, (shown[name].cycles, shown[name].ours)


def test_no_camera_ray_asks_twice(shown: dict[str, Shown]) -> None:
    """The others' answers are 0, which a broken reading would give, too."""
    assert (shown["ray Is Camera Ray"].ours == 1.0).all()
    for name in ("wireframe in metres", "wireframe in pixels"):
        assert 0.05 < shown[name].ours.mean() < 0.95
    for name in ("coordinate Window", "object Random", "geometry Position", "attribute flow"):
        assert shown[name].ours.std() > 0.0 or name.startswith("object")
    assert (shown["object Random"].ours > 0.0).all()


def test_instances_have_random_numbers_of_their_own() -> None:
    """As Cycles' are: each face of a plane shows a copy of a small one."""
    scene = empty_scene(6)
    scene.camera.data.ortho_scale = 6.0
    corners = [(x - 3.0, y - 3.0, 0.0) for y in range(7) for x in range(7)]
    faces = [(i, i + 1, i + 8, i + 7) for row in range(6) for i in range(7 * row, 7 * row + 6)]
    parent = add("Faces", mesh("Faces", corners, faces))
    parent.instance_type = "FACES"
    parent.show_instancer_for_render = False

    def build(new: New, link: Link) -> Socket:
        emission = new("ShaderNodeEmission")
        link(new("ShaderNodeObjectInfo").outputs["Random"], emission.inputs["Color"])
        return emission.outputs[0]

    small = [(-0.5, -0.5, 0), (0.5, -0.5, 0), (0.5, 0.5, 0), (-0.5, 0.5, 0)]
    child = add("Copy", mesh("Copy", small, [(0, 1, 2, 3)], material("Random", build)))
    child.parent = parent
    ours = tyndall_pixels(scene)
    cycles = cycles_pixels(scene, samples=1, seed=1)
    assert ours == pytest.approx(cycles, abs=1e-5)
    assert len({round(float(value), 4) for value in ours[..., 0].ravel()}) > 30
