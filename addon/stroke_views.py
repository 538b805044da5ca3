# SPDX-License-Identifier: GPL-3.0-or-later
"""Painting over a camera: an image for its strokes in an Image Editor, with what the camera shows drawn behind them.

The editor draws the strokes alone; a handler draws the backdrop over that, and the strokes once more. Backdrops are
kept in memory only.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import bpy
from bpy.app.handlers import persistent
from bpy.types import SpaceImageEditor

from .frame_size import frame_size_px

if TYPE_CHECKING:
    import numpy as np
    from bpy.types import Area, Context, Image, Object
    from numpy.typing import NDArray

    from .item_lists import ItemList
    from .properties.light_map_fit import TyndallFitView

#: A mark on the images of strokes.
_IS_STROKES = "tyndall_is_strokes"
_BACKDROP_SAMPLES = 4
#: What cameras show, (height, width, 4), encoded for a display, by the name of the strokes' image.
_backdrops: dict[str, NDArray[np.float32]] = {}
_textures: dict[str, Any] = {}


def view_of(views: ItemList, camera: Object) -> TyndallFitView:
    """The view of a camera, the active one from now on; a new one where there is none."""
    for index, view in enumerate(views.items):
        if view.camera == camera:
            views.activate(index)
            return view  # type: ignore[no-any-return]
    view = views.add(camera.name)
    view.camera = camera
    return view  # type: ignore[no-any-return]


def begin_painting(context: Context, view: TyndallFitView) -> bool:
    """Make what is missing of a view, and show it. False: no Image Editor could be had."""
    size_px = frame_size_px(context.scene)
    if view.strokes is None:
        view.strokes = _new_strokes(f"Strokes {view.camera.name}", size_px)
    _backdrops[view.strokes.name_full] = _picture_of(context, view.camera, size_px)
    _textures.pop(view.strokes.name_full, None)
    return _show(context, view.strokes)


def _new_strokes(name: str, size_px: tuple[int, int]) -> Image:
    image = bpy.data.images.new(name, *size_px, alpha=True, float_buffer=True)
    image.generated_color[:] = 0.0, 0.0, 0.0, 0.0
    image.alpha_mode = "PREMUL"  # what float images hold; else a reload would multiply once more
    image[_IS_STROKES] = True
    image.pack()  # what is painted is in the file from now on
    return image


def _picture_of(context: Context, camera: Object, size_px: tuple[int, int]) -> NDArray[np.float32]:
    """What the camera shows, encoded as sRGB. Raises ValueError and InvalidInput."""
    import numpy as np  # Debian's Blender comes without: the add-on must load, and say so

    from tyndall import Progress
    from tyndall.renderer import RenderConfig

    from .engine.sessions import session_of
    from .engine.settings import shaft_config
    from .sync.cameras import read_camera
    from .sync.reports import Reports
    from .transfer_function_preview import displayed

    depsgraph, scene = context.evaluated_depsgraph_get(), context.scene
    config = RenderConfig(
        pixel_samples=_BACKDROP_SAMPLES,
        shafts=shaft_config(scene),
        seed=scene.tyndall.seed,
        thread_count=scene.tyndall.thread_count,
    )
    seen = read_camera(camera.evaluated_get(depsgraph), scene.render, size_px, Reports())
    combined = session_of(depsgraph).render(seen, config, Progress()).planes["Combined"]
    exposed = combined * np.array([2.0**scene.view_settings.exposure] * 3 + [1.0], np.float32)
    return np.ascontiguousarray(displayed(exposed))


def _show(context: Context, image: Image) -> bool:
    area = _image_editor(context)
    if area is None:
        return False
    space = area.spaces.active
    space.image = image
    space.mode = "PAINT"
    return True


def _image_editor(context: Context) -> Area | None:
    """One of this window's; where there is none, half of the largest area becomes one."""
    areas = list(context.screen.areas) if context.screen is not None else []
    for area in areas:
        if area.type == "IMAGE_EDITOR" and area.ui_type == "IMAGE_EDITOR":
            return area
    if not areas or bpy.app.background:
        return None
    largest = max(areas, key=lambda area: area.width * area.height)
    with context.temp_override(area=largest):
        if bpy.ops.screen.area_split(direction="VERTICAL", factor=0.5) != {"FINISHED"}:
            return None
    new = next(area for area in context.screen.areas if area not in areas)
    new.ui_type = "IMAGE_EDITOR"
    return new


_VERTEX = "void main() { place = position; gl_Position = matrix * vec4(position, 0.0, 1.0); }"
#: Strokes are scene-linear and multiplied with alpha, backdrops are as a display wants them.
_FRAGMENT = """
vec3 encoded(vec3 c) { return mix(12.92 * c, 1.055 * pow(max(c, 1e-6), vec3(1.0 / 2.4)) - 0.055, step(0.0031308, c)); }
void main() {
  vec4 texel = texture(picture, place);
  if (isLinear == 0) { colour = vec4(texel.rgb, 1.0); return; }
  colour = vec4(encoded(clamp(texel.rgb / max(texel.a, 1e-6), 0.0, 1.0)), texel.a);
}
"""


def _make_shader() -> Any:  # noqa: ANN401  gpu has no types
    import gpu

    interface = gpu.types.GPUStageInterfaceInfo("tyndall_strokes")
    interface.smooth("VEC2", "place")
    info = gpu.types.GPUShaderCreateInfo()
    info.push_constant("MAT4", "matrix")
    info.push_constant("INT", "isLinear")
    info.sampler(0, "FLOAT_2D", "picture")
    info.vertex_in(0, "VEC2", "position")
    info.vertex_out(interface)
    info.fragment_out(0, "VEC4", "colour")
    info.vertex_source(_VERTEX)
    info.fragment_source(_FRAGMENT)
    return gpu.shader.create_from_info(info)


def _draw() -> None:
    image = bpy.context.space_data.image
    if image is None or image.name_full not in _backdrops:
        return
    import gpu
    from gpu_extras.batch import batch_for_shader

    if "shader" not in _textures:
        _textures["shader"] = _make_shader()
    if image.name_full not in _textures:
        backdrop = _backdrops[image.name_full]
        height, width = backdrop.shape[:2]
        buffer = gpu.types.Buffer("FLOAT", backdrop.size, backdrop.ravel())
        _textures[image.name_full] = gpu.types.GPUTexture((width, height), format="RGBA16F", data=buffer)
    shader = _textures["shader"]
    corners = ((0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 0.0), (1.0, 1.0), (0.0, 1.0))
    batch = batch_for_shader(shader, "TRIS", {"position": corners})
    shader.bind()
    shader.uniform_float("matrix", gpu.matrix.get_projection_matrix() @ gpu.matrix.get_model_view_matrix())
    for is_linear, texture in ((0, _textures[image.name_full]), (1, gpu.texture.from_image(image))):
        gpu.state.blend_set("ALPHA" if is_linear else "NONE")
        shader.uniform_int("isLinear", is_linear)
        shader.uniform_sampler("picture", texture)
        batch.draw(shader)
    gpu.state.blend_set("NONE")


@persistent
def _pack_strokes(*_: object) -> None:
    """Before a file is saved: Blender saves what was painted into a packed image only where that is packed again."""
    for image in bpy.data.images:
        if image.get(_IS_STROKES) and image.is_dirty and image.library is None:
            image.pack()


@persistent
def _forget(*_: object) -> None:
    _backdrops.clear()
    _textures.clear()


_handles: list[Any] = []


def register() -> None:
    bpy.app.handlers.save_pre.append(_pack_strokes)
    bpy.app.handlers.load_pre.append(_forget)
    _handles.append(SpaceImageEditor.draw_handler_add(_draw, (), "WINDOW", "POST_VIEW"))


def unregister() -> None:
    while _handles:
        SpaceImageEditor.draw_handler_remove(_handles.pop(), "WINDOW")
    bpy.app.handlers.load_pre.remove(_forget)
    bpy.app.handlers.save_pre.remove(_pack_strokes)
    _forget()
