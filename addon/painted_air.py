# SPDX-License-Identifier: GPL-3.0-or-later
"""Painted air as arrays, read from and written to the tiles of an Empty.

Arrays are kept by the revision of the tiles that they came from. Undo, redo, another file, a duplicate or an override
bring another revision, or a known one: nothing has to be told that it is out of date.
"""

from __future__ import annotations

from collections import OrderedDict
from typing import TYPE_CHECKING
from uuid import uuid4

if TYPE_CHECKING:
    from collections.abc import Iterable

    import numpy as np
    from bpy.types import Context, Object
    from mathutils import Matrix
    from numpy.typing import NDArray

    from tyndall.air_tiles import VolumeKind
    from tyndall.heterogeneity import PaintedAir

    from .properties.painted_air import TyndallAirTile, TyndallAirVolume, TyndallPaintedAir

    FloatArray = NDArray[np.float32]

#: Of arrays that are kept beside the latest: enough for the undo steps of a volume of 256^3.
_KEPT_BYTES = 512 << 20
#: Without NumPy this must load, too: the same as ``tyndall.air_tiles.VOLUME_KINDS``.
VOLUMES = ("amount", "level", "intensity")

#: Read-only, (nz, ny, nx), by the tiles' revision and the resolution; the latest used last.
_kept: OrderedDict[tuple[object, ...], FloatArray] = OrderedDict()
_is_writing = False


def is_box(thing: Object | None) -> bool:
    """Whether it may hold painted air: an Empty."""
    return thing is not None and thing.type == "EMPTY"


def why_not_editable(thing: Object | None) -> str | None:
    """What a button says that paints; None: it may."""
    if thing is None:
        return "Add a box to paint in, or choose an Empty"
    if not is_box(thing):
        return f'"{thing.name}" is no Empty: paint needs the cube of one'
    if thing.library is not None:
        return f'"{thing.name}" is linked: make it local, or a library override of it'
    return why_no_space(thing)


def edited_box(context: Context) -> Object | None:
    """The box of the scene's texture; where there is none in the scene, an Empty that is active and has a cube."""
    scene = context.scene
    box: Object | None = scene.tyndall.heterogeneity.painted
    if box is not None and scene.objects.get(box.name) == box:
        return box
    active: Object | None = context.view_layer.objects.active
    return active if is_box(active) and active.empty_display_type == "CUBE" else None


def why_no_space(thing: Object) -> str | None:
    """What to say of a box without a volume; None: it has one."""
    if abs(thing.matrix_world.determinant()) * thing.empty_display_size**3 > 0.0:
        return None
    return f'"{thing.name}" has a scale or a size of 0: there is no space in it'


def local_from_unit(thing: Object) -> Matrix:
    """[0, 1]^3 of it is the Empty's cube, whatever shape it is shown in."""
    from mathutils import Matrix

    size = thing.empty_display_size
    return Matrix.Translation((-size,) * 3) @ Matrix.Diagonal((2 * size,) * 3).to_4x4()


def world_from_unit(thing: Object) -> tuple[tuple[float, float, float, float], ...]:
    """(4, 4), metres."""
    return tuple(tuple(row) for row in thing.matrix_world @ local_from_unit(thing))


def read_volume(thing: Object, name: str) -> FloatArray | None:
    """One of VOLUMES at the box's resolution, (nz, ny, nx), read-only; None: nothing is painted in it."""
    settings = thing.original.tyndall.painted_air
    if not getattr(settings, name).tiles:
        return None
    key = _key(settings, name)
    if key not in _kept:
        from tyndall.air_tiles import VOLUME_KINDS, as_kept, resampled

        values = _read_tiles(thing, settings, name)
        resolution = tuple(settings.resolution)
        if resolution != tuple(settings.kept_resolution):
            values = as_kept(resampled(values, resolution), VOLUME_KINDS[name])
        _keep(key, values)
    _kept.move_to_end(key)
    return _kept[key]


def write_volume(thing: Object, name: str, values: FloatArray | None, touched: Iterable[int] | None = None) -> None:
    """Replace a volume, None: by nothing; where ``touched`` is given, only those tiles.

    ``values`` has the box's resolution; what a tile cannot hold is rounded and clamped. With ``touched`` the array
    itself is: it is the box's from then on.
    """
    global _is_writing  # noqa: PLW0603  the tiles' own callbacks ask
    settings = thing.tyndall.painted_air
    _is_writing = True
    try:
        if tuple(settings.kept_resolution) != tuple(settings.resolution):
            others = {other: read_volume(thing, other) for other in VOLUMES if other != name}
            settings.kept_resolution = settings.resolution
            for other, other_values in others.items():
                _write_tiles(thing, other, other_values, None)
            touched = None
        _write_tiles(thing, name, values, touched)
    finally:
        _is_writing = False
    thing.update_tag()


def painted_air(thing: Object) -> PaintedAir:
    """All of an Empty, evaluated or not. Raises ValueError, which names it: it has no space, or a damaged tile."""
    from tyndall.heterogeneity import PaintedAir

    if (reason := why_no_space(thing)) is not None:
        raise ValueError(reason)
    volumes = {name: read_volume(thing, name) for name in VOLUMES}
    return PaintedAir(key=content_key(thing), world_from_unit=world_from_unit(thing), **volumes)


def content_key(thing: Object) -> str:
    """Another one whenever what is painted, or its resolution, has changed."""
    settings = thing.original.tyndall.painted_air
    painted = [_key(settings, name) for name in VOLUMES if getattr(settings, name).tiles]
    return repr((tuple(settings.resolution), painted))


def _key(settings: TyndallPaintedAir, name: str) -> tuple[object, ...]:
    """Of a volume at the box's resolution. The count of tiles notices a script that adds or removes some."""
    volume = getattr(settings, name)
    return name, volume.revision, len(volume.tiles), tuple(settings.kept_resolution), tuple(settings.resolution)


def _keep(key: tuple[object, ...], values: FloatArray) -> None:
    values.flags.writeable = False
    _kept[key] = values
    while len(_kept) > len(VOLUMES) and sum(one.nbytes for one in _kept.values()) > _KEPT_BYTES:
        _kept.popitem(last=False)


def _read_tiles(thing: Object, settings: TyndallPaintedAir, name: str) -> FloatArray:
    import numpy as np

    from tyndall.air_tiles import VOLUME_KINDS, tile_block, tile_count, unpacked

    shape = tuple(reversed(settings.kept_resolution))
    values = np.full(shape, VOLUME_KINDS[name].neutral, np.float32)
    for tile in getattr(settings, name).tiles:
        if not tile.halves:
            continue
        if tile.index >= tile_count(shape):
            raise ValueError(f'"{thing.name}", painted {name}: there is no tile {tile.index} in it')
        block = values[tile_block(tile.index, shape)]
        try:
            block[...] = unpacked(tile.halves, block.shape)
        except ValueError as error:
            raise ValueError(f'"{thing.name}", painted {name}: {error}') from error
    return values


def _write_tiles(thing: Object, name: str, values: FloatArray | None, touched: Iterable[int] | None) -> None:
    from tyndall.air_tiles import VOLUME_KINDS, as_kept, tile_count

    settings = thing.tyndall.painted_air
    volume, kind = getattr(settings, name), VOLUME_KINDS[name]
    if values is not None:
        if touched is None:
            values = as_kept(values, kind)
        tiles = _Tiles(volume, is_override=thing.override_library is not None)
        for index in range(tile_count(values.shape)) if touched is None else touched:
            tiles.put(index, values, kind)
        tiles.end(keeps_others=touched is not None)
    elif thing.override_library is None:
        volume.tiles.clear()
    else:
        _Tiles(volume, is_override=True).end(keeps_others=False)
    volume.revision = uuid4().hex if volume.tiles else ""
    if volume.tiles and values is not None:
        _keep(_key(settings, name), values)


class _Tiles:
    """Those of a volume, while they are written."""

    def __init__(self, volume: TyndallAirVolume, *, is_override: bool) -> None:
        self._tiles = volume.tiles
        self._is_override = is_override
        self._place_of = {tile.index: place for place, tile in enumerate(volume.tiles) if tile.halves}
        self._unused = [place for place, tile in enumerate(volume.tiles) if not tile.halves]
        self._written: set[int] = set()
        self._emptied: set[int] = set()

    def put(self, index: int, values: FloatArray, kind: VolumeKind) -> None:
        """Round a tile of ``values`` to what is kept, and keep it."""
        from tyndall.air_tiles import as_kept, packed, tile_block

        block = values[tile_block(index, values.shape)]
        block[...] = as_kept(block, kind)
        place = self._place_of.get(index)
        if (block == kind.neutral).all():
            if place is not None:
                self._emptied.add(place)
            return
        if place is None:
            tile = self._tiles[self._unused.pop()] if self._unused else self._tiles.add()
            tile.index = index
        else:
            tile = self._tiles[place]
            self._written.add(place)
        tile.halves = packed(block)

    def end(self, *, keeps_others: bool) -> None:
        """Drop the tiles that became neutral, and, unless they are kept, all that were not written.

        An override cannot remove what it inherits: a tile without voxels is as good as none.
        """
        dropped = self._emptied if keeps_others else set(self._place_of.values()) - self._written
        for place in sorted(dropped, reverse=True):
            if self._is_override:
                self._tiles[place].halves = b""
            else:
                self._tiles.remove(place)


def note_other_tiles(tile: TyndallAirTile, _context: Context) -> None:
    """What the ``update`` of a tile's properties does: where a script writes them, the volume is another one."""
    if not _is_writing:
        path = tile.path_from_id()
        tile.id_data.path_resolve(path[: path.rindex(".tiles[")]).revision = uuid4().hex


def forget() -> None:
    """Drop all arrays that are kept."""
    _kept.clear()
