# SPDX-License-Identifier: GPL-3.0-or-later
"""A painted volume as a picture for who paints it: what a plane cuts is strong, what is before and behind it is faint.

Of each pixel's ray the strongest paint shows, as in a maximum projection. Colours are premultiplied and for a display.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .air_tiles import VOLUME_KINDS
from .scene_description import FloatArray

#: Looks along each ray, evenly over its way through the box.
LOOKS = 48
ABOVE, BELOW = (1.0, 0.55, 0.1), (0.2, 0.5, 1.0)
_FAINT, _STRONG = 0.3, 0.75


def strength(values: FloatArray, name: str) -> FloatArray:
    """How far painted values of a volume are from neutral, [-1, 1], as the eye would have it."""
    if name == "intensity":
        return (values - 1.0) / (values + 1.0)
    ratio = values / np.float32(VOLUME_KINDS[name].highest)
    return np.sign(ratio) * np.sqrt(np.abs(ratio)) if name == "level" else ratio


def picture(
    values: FloatArray,
    name: str,
    unit_from_clip: NDArray[np.float64],
    plane: NDArray[np.float64],
    size_px: tuple[int, int],
) -> FloatArray:
    """(height, width, 4), rows from below, of the volume (nz, ny, nx) of this name.

    ``unit_from_clip``: (4, 4), from [-1, 1]^3 of what is seen to the box's unit cube. ``plane``: (4,) of the unit
    cube's points p, with ``plane[:3] @ p + plane[3] == 0``.
    """
    width, height = size_px
    near, far = (_on_plane_of_view(unit_from_clip, depth, size_px) for depth in (-1.0, 1.0))
    way = far - near
    enters, leaves = _in_unit_cube(near, way)
    rgba = np.zeros((height * width, 4), np.float32)
    rays = np.nonzero(enters < leaves)[0]
    if not len(rays):
        return rgba.reshape(height, width, 4)
    near, way, enters, leaves = near[rays], way[rays], enters[rays], leaves[rays]
    shares = (np.arange(LOOKS, dtype=np.float32) + np.float32(0.5)) / np.float32(LOOKS)
    along = enters[:, None] + (leaves - enters)[:, None] * shares
    seen = strength(_nearest(values, near[:, None] + way[:, None] * along[..., None]), name)
    strongest = np.take_along_axis(seen, np.abs(seen).argmax(1)[:, None], 1)[:, 0]
    fall = way @ plane[:3].astype(np.float32)
    cut = -(near @ plane[:3].astype(np.float32) + np.float32(plane[3])) / np.where(
        fall == 0.0, np.float32(np.inf), fall
    )
    is_cut = (cut >= enters) & (cut <= leaves)
    on_plane = strength(_nearest(values, near + way * np.where(is_cut, cut, enters)[:, None]), name) * is_cut
    rgba[rays] = _over(_coloured(on_plane, _STRONG), _coloured(strongest, _FAINT))
    return rgba.reshape(height, width, 4)


def _on_plane_of_view(unit_from_clip: NDArray[np.float64], depth: float, size_px: tuple[int, int]) -> FloatArray:
    """(pixels, 3): points of the pixels' centres at a depth of clip space."""
    x, y = ((np.arange(count) + 0.5) / count * 2.0 - 1.0 for count in size_px)
    across, up = np.meshgrid(x, y)
    clip = np.stack([across.ravel(), up.ravel(), np.full(across.size, depth), np.ones(across.size)])
    points = unit_from_clip @ clip
    return np.ascontiguousarray((points[:3] / points[3]).T, np.float32)


def _in_unit_cube(origins: FloatArray, ways: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Where on their ways, [0, 1], rays enter it and leave it; behind each other where they miss it."""
    with np.errstate(divide="ignore", invalid="ignore"):
        to_low, to_high = (0.0 - origins) / ways, (1.0 - origins) / ways
    enters = np.nan_to_num(np.minimum(to_low, to_high), nan=-np.inf).max(1)
    leaves = np.nan_to_num(np.maximum(to_low, to_high), nan=np.inf).min(1)
    return np.maximum(enters, 0.0).astype(np.float32), np.minimum(leaves, 1.0).astype(np.float32)


def _nearest(values: FloatArray, points: FloatArray) -> FloatArray:
    """The voxels at points (..., 3) of the unit cube."""
    nz, ny, nx = values.shape
    x, y, z = (
        np.clip((points[..., axis] * np.float32(count)).astype(np.int32), 0, count - 1)
        for axis, count in enumerate((nx, ny, nz))
    )
    found: FloatArray = values.reshape(-1)[(z * ny + y) * nx + x]
    return found


def _coloured(strengths: FloatArray, opacity: float) -> FloatArray:
    """(n, 4), premultiplied."""
    alpha = np.abs(strengths) * np.float32(opacity)
    colour = np.where(strengths[:, None] > 0.0, np.array(ABOVE, np.float32), np.array(BELOW, np.float32))
    return np.concatenate([colour * alpha[:, None], alpha[:, None]], axis=1).astype(np.float32)


def _over(front: FloatArray, back: FloatArray) -> FloatArray:
    return front + back * (np.float32(1.0) - front[:, 3:])
