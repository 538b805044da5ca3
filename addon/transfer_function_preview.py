# SPDX-License-Identifier: GPL-3.0-or-later
"""A small picture of each transfer function for the panels, made anew only when the function has changed.

Handlers note which functions may have changed; the picture is made when a panel asks for it.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import bpy
import bpy.utils.previews
from bpy.app.handlers import persistent
from bpy.types import Image, NodeTree

from .availability import why_not

if TYPE_CHECKING:
    import numpy as np
    from bpy.types import Depsgraph, ImagePreview, Scene
    from numpy.typing import NDArray

    from tyndall.transfer_functions import TransferFunction

    from .sync.images import ImageReader

SIZE_PX = 128
_CHECKER_PX = 8
_CHECKERS = 0.12, 0.2  #: Scene-linear greys behind what is transparent.


@dataclass
class _Shown:
    picture: ImagePreview
    images: ImageReader  #: One that has not changed is the same object, and so the function is the same.
    function: TransferFunction | None = None  #: What the picture shows.
    is_stale: bool = True
    why_not: str | None = None  #: There is no picture.


class _Previews:
    """Pictures by the functions' full names."""

    def __init__(self) -> None:
        self._icons = bpy.utils.previews.new()
        self._shown: dict[str, _Shown] = {}

    def of(self, tree: NodeTree, depsgraph: Depsgraph) -> _Shown:
        if tree.name_full not in self._shown:
            from .sync.images import ImageReader

            self._shown[tree.name_full] = _Shown(self._icons.new(tree.name_full), ImageReader())
        shown = self._shown[tree.name_full]
        if shown.is_stale:
            _refresh(shown, tree, depsgraph)
            shown.is_stale = False
        return shown

    def mark_stale(self, *names: str) -> None:
        """All of them, if none is named."""
        for name in names or self._shown:
            if name in self._shown:
                self._shown[name].is_stale = True

    def forget(self) -> None:
        self._icons.clear()
        self._shown.clear()

    def close(self) -> None:
        bpy.utils.previews.remove(self._icons)


_previews: _Previews | None = None


def picture_of(tree: NodeTree, depsgraph: Depsgraph) -> tuple[int, str | None]:
    """An icon for ``template_icon``, and what keeps the function from being drawn, if anything does.

    Headless, icons have no number: all are 0.
    """
    if (reason := why_not()) is not None:
        return 0, reason
    shown = _previews.of(tree, depsgraph)
    return shown.picture.icon_id, shown.why_not


def _refresh(shown: _Shown, tree: NodeTree, depsgraph: Depsgraph) -> None:
    from tyndall import InvalidInput
    from tyndall.native_transfer_functions import compose

    from .sync.reports import Reports
    from .sync.transfer_functions import FunctionReader

    shown.images.start_frame()
    function = FunctionReader(depsgraph, shown.images, Reports(), follows_surfaces=False).read(tree)
    shown.images.end_frame()
    if function == shown.function:
        return
    shown.function, shown.why_not = function, None
    try:
        pixels = displayed(compose(function, SIZE_PX))
    except InvalidInput as error:
        shown.why_not = str(error)
        return
    shown.picture.image_size[:] = SIZE_PX, SIZE_PX
    shown.picture.image_pixels_float.foreach_set(pixels.ravel())


def displayed(picture: NDArray[np.float32]) -> NDArray[np.float32]:
    """(height, width, 4), opaque and encoded as sRGB, of scene-linear colours multiplied with alpha.

    Blender shows the pixels of an icon as they are; what is transparent lies over a checkerboard.
    """
    import numpy as np  # Debian's Blender comes without: the add-on must load, and say so

    rows, columns = np.indices(picture.shape[:2]) // _CHECKER_PX
    checkers = np.where((rows + columns) % 2 == 0, *_CHECKERS)[..., None]
    linear = np.clip(picture[..., :3] + (1.0 - picture[..., 3:]) * checkers, 0.0, 1.0)
    shown = np.ones_like(picture)
    shown[..., :3] = np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)  # noqa: PLR2004
    return shown


@persistent
def _note_updates(_scene: Scene, depsgraph: Depsgraph) -> None:
    for update in depsgraph.updates:
        if isinstance(update.id, NodeTree):
            _previews.mark_stale(update.id.original.name_full)
        elif isinstance(update.id, Image):
            _previews.mark_stale()


@persistent
def _note_frame(_scene: Scene, _depsgraph: Depsgraph) -> None:
    _previews.mark_stale()


@persistent
def _note_other_data(*_: object) -> None:
    """After undo and in another file the same names may mean other functions."""
    _previews.forget()


_HANDLERS = (
    ("depsgraph_update_post", _note_updates),
    ("frame_change_post", _note_frame),
    ("undo_post", _note_other_data),
    ("redo_post", _note_other_data),
    ("load_post", _note_other_data),
)


def register() -> None:
    global _previews  # noqa: PLW0603  one per registration of the add-on
    _previews = _Previews()
    for event, handler in _HANDLERS:
        getattr(bpy.app.handlers, event).append(handler)


def unregister() -> None:
    for event, handler in _HANDLERS:
        getattr(bpy.app.handlers, event).remove(handler)
    _previews.close()
