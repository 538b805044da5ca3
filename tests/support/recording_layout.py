# SPDX-License-Identifier: GPL-3.0-or-later
"""A stand-in for ``UILayout`` that draws nothing and checks everything: headless Blender has no window to draw in."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import bpy

ICONS = frozenset(bpy.types.UILayout.bl_rna.functions["prop"].parameters["icon"].enum_items.keys())

#: Headless, Blender's own scale of the interface is 0.
PREFERENCES = SimpleNamespace(system=SimpleNamespace(ui_scale=1.0))


class RecordingLayout:
    """Records what a panel draws. Fails where Blender would print an error or leave a hole: unknown names and icons."""

    def __init__(self, shown: list[str] | None = None) -> None:
        self.shown: list[str] = [] if shown is None else shown

    def __getattr__(self, name: str) -> Any:
        if name in {"row", "column", "split", "box", "grid_flow"}:
            return lambda **_options: RecordingLayout(self.shown)
        raise AttributeError(name)

    def prop(self, owner: Any, name: str, icon: str = "NONE", **_options: object) -> None:
        assert name in owner.bl_rna.properties, f"{owner} has no property {name}"
        assert icon in ICONS
        self.shown.append(name)

    def label(self, text: str = "", icon: str = "NONE") -> None:
        assert icon in ICONS
        self.shown.append(text)

    def operator(self, idname: str, text: str = "", icon: str = "NONE") -> Any:
        assert icon in ICONS
        module, name = idname.split(".")
        operator = getattr(getattr(bpy.ops, module), name)
        self.shown.append(text or idname)
        return _OperatorProperties(frozenset(operator.get_rna_type().properties.keys()))

    def template_node_view(self, tree: Any, node: Any, socket: Any) -> None:
        assert node.inputs[socket.name] == socket
        assert node.id_data == tree
        self.shown.append(f"node view: {socket.name}")


class _OperatorProperties:
    def __init__(self, names: frozenset[str]) -> None:
        object.__setattr__(self, "_names", names)

    def __setattr__(self, name: str, value: object) -> None:
        assert name in self._names, f"the operator has no property {name}"


class HeadlessContext:
    """``bpy.context`` with the members that only a window has, and whatever a test puts in their place."""

    def __init__(self, **members: Any) -> None:
        window = {"engine": "TYNDALL", "region": SimpleNamespace(width=320), "preferences": PREFERENCES}
        self._members = {**window, **members}

    def __getattr__(self, name: str) -> Any:
        return self._members[name] if name in self._members else getattr(bpy.context, name, None)


def drawn(panel: Any, **members: Any) -> list[str]:
    """What a panel shows, in order: names of properties and operators, and labels."""
    context = HeadlessContext(**members)
    assert panel.poll(context)
    stand_in = type(panel.__name__, (), {"layout": RecordingLayout()})()
    panel.draw(stand_in, context)
    return stand_in.layout.shown
