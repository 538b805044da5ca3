# SPDX-License-Identifier: GPL-3.0-or-later
"""What artists see: each panel draws only what exists, and where it means something."""

from __future__ import annotations

from pathlib import Path

import bpy
import pytest

import addon
from addon import availability, last_render, panels
from addon.panels.panorama import TYNDALL_PT_panorama
from addon.panels.presets import ShippedPresetPanel
from addon.panels.standard import standard_panels
from addon.panoramas import panorama_settings
from addon.shader_nodes import use_nodes
from addon.shutter_position import position_settings
from support.recording_layout import HeadlessContext, drawn
from tyndall.voxel_dag import Config, from_coordinates

STATISTICS = {
    "stages": [{"name": "embree", "seconds": 0.0123}, {"name": "light shafts", "seconds": 75.0}],
    "skipped": [{"what": "world", "reason": "it is black"}],
    "counts": {"triangles": 1_000_000.0, "lit share": 0.25},
    "reports": [f"material {index}: Glossy is rendered as Diffuse" for index in range(20)],
}
PANELS = [cls for cls in panels.CLASSES if issubclass(cls, bpy.types.Panel)]
#: Each has a test of its own.
ELSEWHERE = {
    "TYNDALL_PT_unavailable",
    "TYNDALL_PT_beam_shape",
    "TYNDALL_PT_panorama",
    "TYNDALL_PT_viewport_render_pass",
}
LIGHT_TYPES = ("SUN", "POINT", "SPOT", "AREA")


def new_material(name: str = "Material") -> bpy.types.Material:
    material = bpy.data.materials.new(name)
    use_nodes(material)
    return material


def test_every_panel_draws_in_the_factory_scene(scene: bpy.types.Scene, tmp_path: Path) -> None:
    """No panel names a property, an operator or an icon that this version of Blender lacks."""
    last_render.record(scene.name, STATISTICS)
    bpy.ops.tyndall.transfer_function_preset(preset="SUNRISE")
    bpy.ops.tyndall.add_painted_box()
    path = tmp_path / "voxels.tdag"
    from_coordinates([[1, 2, 3]], Config(resolution=4)).save(path)
    bpy.ops.tyndall.import_tdag(filepath=str(path))
    for cls in PANELS:
        if cls.__name__ in ELSEWHERE or issubclass(cls, ShippedPresetPanel):
            continue  # each has a test of its own below
        if "over_engine" in cls.__name__:
            continue  # of other engines: test_over_engine.py
        light = bpy.data.objects["Light"].data
        assert drawn(cls, light=light, material=new_material(), world=scene.world), cls.__name__


def test_panels_hide_under_another_engine(scene: bpy.types.Scene) -> None:
    """Cycles users do not meet our settings."""
    for cls in PANELS:
        if not issubclass(cls, ShippedPresetPanel) and "over_engine" not in cls.__name__:
            with pytest.raises(AssertionError):
                drawn(cls, engine="CYCLES", light=bpy.data.lights[0], material=new_material(), world=scene.world)


@pytest.mark.parametrize("kind", LIGHT_TYPES)
def test_light_panel_fits_each_type(scene: bpy.types.Scene, kind: str) -> None:
    """A sun has an angle, other lights have a radius or a shape."""
    light = bpy.data.lights.new("light", kind)
    shown = drawn(panels.light.TYNDALL_PT_light, light=light)
    assert ("angle" in shown) == (kind == "SUN")
    assert ("shadow_soft_size" in shown) == (kind in {"POINT", "SPOT"})
    assert ("shape" in shown) == (kind == "AREA")
    assert "scatters_in_media" in shown
    if kind == "SPOT":
        assert drawn(panels.light.TYNDALL_PT_beam_shape, light=light)[:2] == ["spot_size", "spot_blend"]
    if kind == "AREA":
        assert "size_y" not in shown
        light.shape = "ELLIPSE"
        assert "size_y" in drawn(panels.light.TYNDALL_PT_light, light=light)
        assert drawn(panels.light.TYNDALL_PT_beam_shape, light=light) == ["spread"]


def test_world_without_bounds_names_the_remedy(scene: bpy.types.Scene) -> None:
    """The sun of a world filled with fog is infinitely attenuated; the panel offers a fog box."""
    assert not any("fog box" in line.lower() for line in drawn(panels.world.TYNDALL_PT_world_volume, world=scene.world))
    tree = scene.world.node_tree
    medium = tree.nodes.new("ShaderNodeVolumeScatter")
    tree.links.new(medium.outputs[0], tree.get_output_node("CYCLES").inputs["Volume"])
    assert "Turn into a Fog Box" in drawn(panels.world.TYNDALL_PT_world_volume, world=scene.world)


def test_a_material_shows_its_surface_and_its_medium(scene: bpy.types.Scene) -> None:
    """Both sockets of the output node can be edited in place."""
    material = new_material()
    assert drawn(panels.material.TYNDALL_PT_material_surface, material=material) == ["node view: Surface"]
    assert drawn(panels.material.TYNDALL_PT_material_volume, material=material) == ["node view: Volume"]
    material.node_tree.nodes.clear()
    assert drawn(panels.material.TYNDALL_PT_material_surface, material=material) == ["No output node"]


def test_last_render_shows_what_was_done_skipped_and_replaced(scene: bpy.types.Scene) -> None:
    """Nothing before a render; then stages with times, reasons, and at most a dozen reports, for the panel's speed."""
    with pytest.raises(AssertionError):
        drawn(panels.statistics.TYNDALL_PT_statistics)
    last_render.record(scene.name, STATISTICS)
    shown = " ".join(drawn(panels.statistics.TYNDALL_PT_statistics))
    for text in ("Embree 12.3 ms", "Light shafts 1 min 15 s", "Skipped world: it is black", "... and 8 more"):
        assert text in shown
    assert drawn(panels.statistics.TYNDALL_PT_counts) == ["Lit share", "0.25", "Triangles", "1,000,000"]


def test_last_render_says_once_what_many_lights_and_materials_share(scene: bpy.types.Scene) -> None:
    """A stage of lamps passes through the same steps, and its lenses lack the same: a page of it helps nobody."""
    stages = [{"name": "slope rows: raster", "seconds": 0.25}, {"name": "scatter", "seconds": 3.0}] * 4
    reports = [f'Material "Lens.{index:03}" glows' for index in range(16)] + ['Object "Fog": hidden', "no camera"]
    last_render.record(scene.name, {"stages": stages, "reports": reports})
    shown = drawn(panels.statistics.TYNDALL_PT_statistics)
    assert shown[:4] == ["Slope rows: raster (4)", "1 s", "Scatter (4)", "12 s"]
    assert shown[4:7] == ['Material "Lens.000" and 15 more glows', 'Object "Fog": hidden', "no camera"]


def test_statistics_of_another_file_are_forgotten(scene: bpy.types.Scene) -> None:
    """Scenes of different files often have the same name."""
    last_render.record(scene.name, STATISTICS)
    bpy.ops.wm.read_factory_settings()
    assert last_render.statistics_of(bpy.context.scene.name) is None


@pytest.mark.parametrize(
    ("error", "advice"),
    [
        (ModuleNotFoundError("No module named 'numpy'", name="numpy"), "apt install python3-numpy"),
        (ImportError("/lib/libc.so.6: version `GLIBC_2.34' not found (required by x.so)"), "lacks GLIBC_2.34"),
        (
            ImportError("libfoo.so.3: cannot open shared object file"),
            "libfoo.so.3 is missing",
        ),
        (ModuleNotFoundError("No module named 'tyndall'", name="tyndall"), "zip for this version of Blender"),
    ],
)
def test_a_core_that_does_not_load_says_what_to_do(
    scene: bpy.types.Scene, monkeypatch: pytest.MonkeyPatch, error: ImportError, advice: str
) -> None:
    """The reason stands in the Render properties, in words for an artist."""
    monkeypatch.setattr(availability, "_why_not", availability.explained(error))
    assert advice in " ".join(drawn(panels.unavailable.TYNDALL_PT_unavailable))


def test_blenders_own_panels_stay(scene: bpy.types.Scene) -> None:
    """Lens, transform of the output, colour management, material slots; not those of settings that nothing reads."""
    names = {panel.__name__ for panel in standard_panels()}
    assert names >= {
        "DATA_PT_lens",
        "DATA_PT_camera",
        "DATA_PT_context_light",
        "EEVEE_MATERIAL_PT_context_material",
        "OBJECT_PT_visibility",
        *(("OBJECT_PT_shading",) if bpy.app.version >= (4, 0, 0) else ()),  # of which Light Linking is a part
        "RENDER_PT_color_management",
        "RENDER_PT_format",
        "RENDER_PT_output",
        "VIEWLAYER_PT_layer",
        "WORLD_PT_context_world",
    }
    assert names.isdisjoint({"DATA_PT_light", "RENDER_PT_freestyle", "RENDER_PT_stereoscopy"})
    for panel in standard_panels():
        assert "TYNDALL" in panel.COMPAT_ENGINES


def test_unregister_leaves_no_trace(scene: bpy.types.Scene) -> None:
    """Disabling the add-on takes all that it added away; enabling works again."""
    addon.unregister()
    try:
        assert not hasattr(bpy.types.Scene, "tyndall")
        assert not hasattr(bpy.types.View3DShading, "tyndall")
        assert not any("TYNDALL" in getattr(panel, "COMPAT_ENGINES", ()) for panel in standard_panels())
        assert not hasattr(bpy.types, "TYNDALL_PT_sampling")
    finally:
        addon.register()
    assert bpy.context.scene.tyndall.pixel_samples == 16


def test_values_set_by_python_reach_the_dependency_graph(scene: bpy.types.Scene) -> None:
    """A property without an update callback would tag nothing, and the viewport would not react."""
    seen: list[bool] = []

    def note(_scene: bpy.types.Scene, depsgraph: bpy.types.Depsgraph) -> None:
        seen.append(depsgraph.id_type_updated("SCENE"))

    settings = scene.tyndall
    groups = (
        *(settings, settings.shafts, settings.indirect, settings.voxelize),
        *(bpy.data.lights[0].tyndall, bpy.context.view_layer.tyndall, bpy.data.objects["Cube"].tyndall_voxels),
    )
    bpy.app.handlers.depsgraph_update_post.append(note)
    try:
        for group in groups:
            for name, rna in group.bl_rna.properties.items():
                if rna.type in {"POINTER", "STRING", "COLLECTION"}:
                    continue
                bpy.context.view_layer.update()
                seen.clear()
                setattr(group, name, getattr(group, name))
                bpy.context.view_layer.update()
                assert seen, f"{group.bl_rna.identifier}.{name} tags nothing"
    finally:
        bpy.app.handlers.depsgraph_update_post.remove(note)


def test_a_panorama_shows_its_own_settings(scene: bpy.types.Scene) -> None:
    """Only of a panoramic camera; and each kind's own, all of those that Blender has."""
    camera = scene.camera.data
    assert not TYNDALL_PT_panorama.poll(HeadlessContext(camera=camera))
    camera.type = "PANO"
    settings = panorama_settings(camera)
    owned = {
        name
        for name in settings.bl_rna.properties.keys()  # noqa: SIM118  it is no dictionary
        if name.startswith(("latitude", "longitude", "fisheye", "central_cylindrical"))
    }
    shown = {}
    for kind in settings.bl_rna.properties["panorama_type"].enum_items:
        settings.panorama_type = kind.identifier
        shown[kind.identifier] = set(drawn(TYNDALL_PT_panorama, camera=camera)) & owned
    assert shown["EQUIRECTANGULAR"] == {"latitude_min", "latitude_max", "longitude_min", "longitude_max"}
    assert shown["FISHEYE_EQUIDISTANT"] == {"fisheye_fov"}
    assert shown["FISHEYE_EQUISOLID"] == {"fisheye_fov", "fisheye_lens"}
    assert not shown["MIRRORBALL"]
    assert set.union(*shown.values()) == owned


def test_the_shading_menu_offers_passes_where_ours_are_shown(scene: bpy.types.Scene) -> None:
    screens = (area for screen in bpy.data.screens for area in screen.areas if area.type == "VIEW_3D")
    space = next(screens).spaces[0]
    menu = panels.viewport_shading.TYNDALL_PT_viewport_render_pass
    space.shading.type = "RENDERED"
    assert drawn(menu, space_data=space) == ["render_pass"]
    space.shading.type = "SOLID"
    assert not menu.poll(HeadlessContext(space_data=space))
    assert not menu.poll(HeadlessContext(space_data=None))


def test_motion_blur_has_its_panel(scene: bpy.types.Scene) -> None:
    """Blender's own settings and our steps, of which there are no more than samples."""
    panel = panels.motion_blur.TYNDALL_PT_motion_blur
    scene.tyndall.motion_steps = scene.tyndall.pixel_samples = 16
    shown = drawn(panel)
    assert {"motion_blur_shutter", "motion_steps"} <= set(shown)
    assert ("motion_blur_position" in shown) == (position_settings(scene) is not None)
    scene.tyndall.motion_steps = 17
    assert "16 steps: as many as samples" in drawn(panel)
    assert panel.bl_label == "Motion Blur"
    scene.render.use_motion_blur = True
    assert "motion_blur_shutter_curve" in drawn(panels.motion_blur.TYNDALL_PT_motion_blur_curve)
