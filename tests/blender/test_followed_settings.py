# SPDX-License-Identifier: GPL-3.0-or-later
"""Whatever is set in a scene, it is followed as what is read at once; and most of it reads no object."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace

import bpy
import pytest

from addon.sync import scene as sync_scene
from support.followed_scene import Followed
from support.particle_scenes import emitter
from support.small_scenes import add, cube, empty_scene, light, material, node, plane, read
from tyndall.fingerprints import fingerprint
from tyndall.scene_description import SceneDescription

PLAIN = {"BOOLEAN", "INT", "FLOAT", "ENUM"}
LEFT_ALONE = {"engine"}


@pytest.fixture
def scene() -> bpy.types.Scene:
    """With what settings are read for: collections, hair, glass, lamps, an override, adaptive subdivision."""
    scene = empty_scene(size_px=16)
    glass = material("Glass", lambda new, _: node(new, "ShaderNodeBsdfGlass").outputs[0])
    occluded = material("Occluded", lambda new, _: node(new, "ShaderNodeAmbientOcclusion").outputs[0])
    ball = cube("Ball", glass)
    modifier = ball.modifiers.new("Smooth", "SUBSURF")
    (modifier if bpy.app.version >= (5, 0, 0) else ball.cycles).use_adaptive_subdivision = True
    plane(material=occluded)
    emitter("Furry", "HAIR", 3, 4.0)
    for name in ("Shown", "Inner"):
        collection = bpy.data.collections.new(name)
        (bpy.data.collections.get("Shown") if name == "Inner" else scene.collection).children.link(collection)
        collection.objects.link(bpy.data.objects.new(f"In {name}", ball.data))
    copies = add("Copies", None)
    copies.instance_type, copies.instance_collection = "COLLECTION", bpy.data.collections["Inner"]
    light("SUN", (0, 0, 5))
    light("POINT", (1, 1, 3)).lightgroup = "Key"
    scene.tyndall.indirect.has_mirrors = scene.tyndall.indirect.has_refraction = True
    scene.view_layers[0].update()
    return scene


def places_of_settings(scene: bpy.types.Scene) -> Iterator[str]:
    """Paths to all that has plain properties of a scene, and is no datablock of its own."""
    layer = "view_layers[0]"
    shown = f'{layer}.layer_collection.children["Shown"]'
    yield from ("render", "view_settings", "unit_settings", "cycles", "cycles_curves")
    yield from (layer, shown, f'{shown}.children["Inner"]')
    waiting = ["tyndall", f"{layer}.tyndall"]
    while waiting:
        place = waiting.pop()
        yield place
        owner = scene.path_resolve(place)
        waiting += [
            f"{place}.{entry.identifier}"
            for entry in owner.bl_rna.properties
            if isinstance(getattr(owner, entry.identifier, None), bpy.types.PropertyGroup)
        ]


def another_value(owner: bpy.types.bpy_struct, entry: bpy.types.Property) -> object:
    """None where there is none that may be set."""
    value = getattr(owner, entry.identifier, None)
    if entry.type not in PLAIN or entry.is_readonly or getattr(entry, "is_enum_flag", False) or value is None:
        return None
    if getattr(entry, "is_array", False):
        return [0 if one else 1 for one in value]
    if entry.type == "ENUM":
        return next((item.identifier for item in entry.enum_items if item.identifier != value), None)
    if entry.type == "BOOLEAN":
        return not value
    return value + 1 if value + 1 <= entry.soft_max else value - 1


def described(description: SceneDescription) -> bytes:
    return fingerprint(replace(description, reports=()))


def test_every_setting_is_followed_as_what_is_read_at_once(scene: bpy.types.Scene) -> None:
    """Each changed in turn, and back. Seen to fail without each part of the state that has plain settings."""
    followed, count = Followed(), 0
    with followed.hears():
        scene.view_layers[0].update()
        followed.read()
        for place in list(places_of_settings(scene)):
            for name in scene.path_resolve(place).bl_rna.properties.keys():  # noqa: SIM118  no dictionary
                owner = scene.path_resolve(place)
                value = another_value(owner, owner.bl_rna.properties[name])
                if name in LEFT_ALONE or value is None:
                    continue
                before = getattr(owner, name)
                before = tuple(before) if isinstance(value, list) else before
                for given in (value, before):
                    try:
                        setattr(scene.path_resolve(place), name, given)
                    except TypeError:  # enumerated, but not in this build
                        break
                    scene.update_tag()
                    scene.view_layers[0].update()
                    description, expected = followed.read(), read()
                    assert described(description) == described(expected), (place, name)
                    assert description.reports == expected.reports, (place, name)
                    count += 1
    assert count > 400


def hides(name: str) -> Callable[[bpy.types.Scene, bool], None]:
    return lambda _, is_hidden: bpy.data.objects[name].hide_set(is_hidden)


def has_no_world(scene: bpy.types.Scene, is_so: bool) -> None:  # noqa: FBT001
    scene.world = None if is_so else bpy.data.worlds["World"]


def is_overridden(scene: bpy.types.Scene, is_so: bool) -> None:  # noqa: FBT001
    scene.view_layers[0].material_override = bpy.data.materials["Occluded"] if is_so else None


def has_a_light_group(scene: bpy.types.Scene, is_so: bool) -> None:  # noqa: FBT001
    groups = scene.view_layers[0].lightgroups
    if is_so:
        groups.add(name="Key")
    else:
        bpy.ops.scene.view_layer_remove_lightgroup()
    scene.update_tag()


@pytest.mark.parametrize(
    "switch",
    [
        *(pytest.param(hides(name), id=f"{name} is hidden") for name in ("Ball", "In Inner", "Copies", "Point")),
        *(pytest.param(one, id=one.__name__) for one in (has_no_world, is_overridden, has_a_light_group)),
    ],
)
def test_what_a_scene_says_of_its_datablocks_is_followed(
    scene: bpy.types.Scene, switch: Callable[[bpy.types.Scene, bool], None]
) -> None:
    """To and fro. Blender tells of a scene that changed."""
    followed, seen = Followed(), []
    with followed.hears():
        scene.view_layers[0].update()
        before = described(followed.read())
        for is_so in (True, False):
            switch(scene, is_so)
            scene.view_layers[0].update()
            seen.append(described(followed.read()))
            assert seen[-1] == described(read()), is_so
    assert seen[0] != seen[1] == before


@pytest.mark.parametrize("change", ["a click", "a slider", "the film", "a click and a lamp"])
def test_what_leaves_all_as_it_was_reads_no_object(
    scene: bpy.types.Scene, monkeypatch: pytest.MonkeyPatch, change: str
) -> None:
    """Of a scene whose materials ask objects for nothing."""
    followed = Followed()
    with followed.hears():
        scene.view_layers[0].update()
        before = followed.read()
        for step in range(1, 4):
            if change == "a slider":
                scene.tyndall.shafts.error_target = 0.01 * step
                scene.update_tag()  # as Blender's own buttons do
            elif change == "the film":
                scene.view_settings.exposure = step
            else:
                bpy.data.objects["Ball"].select_set(step % 2 == 0)
            if change == "a click and a lamp":
                bpy.data.objects["Point"].data.energy = 10.0 * step
            scene.view_layers[0].update()
            with monkeypatch.context() as alone:
                alone.setattr(sync_scene, "read_placements", lambda *_: pytest.fail("objects are read"))
                after = followed.read()
            assert after.instances is before.instances
            assert described(after) == described(read())
