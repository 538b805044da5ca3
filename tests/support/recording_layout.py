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

    def prop_search(self, owner: Any, name: str, search_in: Any, found: str, text: str = "") -> None:
        assert found in search_in.bl_rna.properties, f"{search_in} has no property {found}"
        self.prop(owner, name)
        if text:
            self.shown.append(text)

    def separator(self, **_options: object) -> None:
        pass

    def template_preview(self, thing: bpy.types.ID) -> None:
        assert isinstance(thing, bpy.types.Material | bpy.types.World | bpy.types.Light)
        self.shown.append("preview")

    def menu(self, name: str, text: str = "", icon: str = "NONE") -> None:
        assert icon in ICONS
        getattr(bpy.types, name).draw(SimpleNamespace(layout=self), bpy.context)
        self.shown.append(text or name)

    def template_list(
        self, kind: str, _list_id: str, owner: Any, items: str, active_owner: Any, active: str, **_options: object
    ) -> None:
        """Rows in the order in which the list shows them."""
        ui_list = getattr(bpy.types, kind)
        assert active in active_owner.bl_rna.properties
        rows = getattr(owner, items)
        places = range(len(rows))
        if hasattr(ui_list, "filter_items"):
            _flags, places = ui_list.filter_items(ui_list, bpy.context, owner, items)
        for index in sorted(range(len(rows)), key=lambda index: places[index]):
            ui_list.draw_item(ui_list, bpy.context, self, owner, rows[index], 0, active_owner, active)
            self.shown.append(f"row: {rows[index].name}")

    def label(self, text: str = "", icon: str = "NONE") -> None:
        assert icon in ICONS
        self.shown.append(text)

    def operator(self, idname: str, text: str = "", icon: str = "NONE", **_options: object) -> Any:
        assert icon in ICONS
        module, name = idname.split(".")
        operator = getattr(getattr(bpy.ops, module), name)
        self.shown.append(text or idname)
        return _OperatorProperties(frozenset(operator.get_rna_type().properties.keys()))

    def operator_menu_enum(self, idname: str, name: str, text: str = "", icon: str = "NONE") -> None:
        self.operator(idname, text, icon).require(name)

    def template_ID(self, owner: Any, name: str, **options: str) -> None:  # noqa: N802  Blender's name
        self.prop(owner, name)
        for kind in options.keys() & {"new", "open"}:
            module, operator = options[kind].split(".")
            getattr(getattr(bpy.ops, module), operator).get_rna_type()

    def template_icon(self, **_options: object) -> None:
        self.shown.append("icon")

    def template_color_ramp(self, owner: Any, name: str, **_options: object) -> None:
        self.prop(owner, name)

    def template_curve_mapping(self, owner: Any, name: str, **_options: object) -> None:
        self.prop(owner, name)

    def template_node_view(self, tree: Any, node: Any, socket: Any) -> None:
        assert node.inputs[socket.name] == socket
        assert node.id_data == tree
        self.shown.append(f"node view: {socket.name}")


class _OperatorProperties:
    def __init__(self, names: frozenset[str]) -> None:
        object.__setattr__(self, "_names", names)

    def require(self, name: str) -> None:
        assert name in self._names, f"the operator has no property {name}"

    def __setattr__(self, name: str, value: object) -> None:
        self.require(name)


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
