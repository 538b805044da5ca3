# SPDX-License-Identifier: GPL-3.0-or-later
"""Keys and drivers that stay with their items when an item of a collection is removed.

F-Curves find an item by its index: what comes after a removed one moves up, so its paths are counted down. 4.4 put
F-Curves into the layers of an action, per slot; before, an action had one list of them.
"""

from __future__ import annotations

import re
from itertools import chain
from typing import TYPE_CHECKING, Any

import bpy

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from bpy.types import ID, Action, AnimData, DriverTarget, FCurve, NlaStrip


def forget_item(owner: ID, collection_path: str, index: int) -> None:
    """Call before item ``index`` of ``owner``'s collection is removed: its keys and drivers go, later ones count down.

    An action that other datablocks share, or that is linked, becomes the owner's own copy first.
    """

    def renumbered(path: str) -> str | None:
        return path_without_item(path, collection_path, index)

    animation = owner.animation_data
    if animation is not None:
        for user in _users_of_actions(animation):
            if any(renumbered(curve.data_path) != curve.data_path for curve in chain(*_curve_lists(user))):
                _make_own(user)
                for curves in _curve_lists(user):
                    _renumber(curves, renumbered)
        _renumber(animation.drivers, renumbered)
    for target in _targets_at(owner):
        target.data_path = renumbered(target.data_path) or target.data_path


def make_actions_own(owner: ID) -> None:
    """Call after ``copy()``: an action that other datablocks share, or that is linked, becomes the owner's own."""
    if owner.animation_data is not None:
        for user in _users_of_actions(owner.animation_data):
            _make_own(user)


def curves_at(owner: ID, path: str) -> list[FCurve]:
    """F-Curves of the owner's present action that animate exactly this property."""
    animation = owner.animation_data
    if animation is None or animation.action is None:
        return []
    return [curve for curve in chain(*_curve_lists(animation)) if curve.data_path == path]


def animated_paths(owner: ID) -> tuple[dict[str, list[FCurve]], set[str]]:
    """By path, the F-Curves of the owner's present action that animate it; and the paths that drivers do."""
    animation = owner.animation_data
    if animation is None:
        return {}, set()
    keyed: dict[str, list[FCurve]] = {}
    for curve in chain(*_curve_lists(animation)) if animation.action is not None else ():
        keyed.setdefault(curve.data_path, []).append(curve)
    return keyed, {curve.data_path for curve in animation.drivers}


def animates_by_other_means(owner: ID, path: str) -> bool:
    """Whether a driver or a strip of the NLA editor sets this property, whatever ``curves_at`` finds."""
    animation = owner.animation_data
    if animation is None:
        return False
    strips = [strip for track in animation.nla_tracks if not track.mute for strip in track.strips if strip.action]
    by_strips = chain.from_iterable(chain(*_curve_lists(strip)) for strip in strips if animation.use_nla)
    return any(curve.data_path == path for curve in chain(animation.drivers, by_strips))


def path_without_item(path: str, collection_path: str, index: int) -> str | None:
    """The path once item ``index`` of the collection is gone; None for a path into that item."""
    match = re.match(rf"{re.escape(collection_path)}\[(\d+)\]", path)
    if match is None or int(match[1]) < index:
        return path
    if int(match[1]) == index:
        return None
    return f"{collection_path}[{int(match[1]) - 1}]{path[match.end() :]}"


def _renumber(curves: Any, renumbered: Callable[[str], str | None]) -> None:  # noqa: ANN401 - a collection of F-Curves
    for curve in list(curves):
        path = renumbered(curve.data_path)
        if path is None:
            curves.remove(curve)
        elif path != curve.data_path:
            curve.data_path = path


def _users_of_actions(animation: AnimData) -> Iterator[AnimData | NlaStrip]:
    if animation.action is not None:
        yield animation
    for track in animation.nla_tracks:
        yield from (strip for strip in track.strips if strip.action is not None)


def _is_layered(action: Action) -> bool:
    return bool(getattr(action, "is_action_layered", False))


def _curve_lists(user: AnimData | NlaStrip) -> Iterator[Any]:
    """The F-Curves of an action that animate what uses it there."""
    if not _is_layered(user.action):
        yield user.action.fcurves
    elif user.action_slot is not None:
        for layer in user.action.layers:
            for strip in layer.strips:
                channels = strip.channelbag(user.action_slot)
                if channels is not None:
                    yield channels.fcurves


def _make_own(user: AnimData | NlaStrip) -> None:
    action = user.action
    if _is_layered(action):
        slot = user.action_slot
        if len(slot.users()) > 1 or action.library is not None:
            user.action = action.copy()
            user.action_slot = user.action.slots[slot.identifier]
    elif action.users - action.use_fake_user > 1 or action.library is not None:
        user.action = action.copy()


def _targets_at(owner: ID) -> Iterator[DriverTarget]:
    """Inputs of drivers, of any datablock, that read a property of the owner."""
    for other in {owner, *bpy.data.user_map(subset={owner})[owner]}:
        for driven in (other, getattr(other, "node_tree", None), getattr(other, "shape_keys", None)):
            animation = getattr(driven, "animation_data", None)
            for curve in _drivers(animation):
                for variable in curve.driver.variables:
                    yield from (target for target in variable.targets if target.id == owner)


def _drivers(animation: AnimData | None) -> tuple[FCurve, ...]:
    return tuple(animation.drivers) if animation is not None else ()
