#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Holds the arrows between the layers: reads C++ includes and Python imports, and fails on one that points up.

    core <- image, volume <- shading <- scene <- rooms <- render <- bindings

Two parts of one layer (image and volume; two rooms) never meet. python/ knows Blender only in tyndall/blender/, the
one seam, which is also the only place that may import the add-on; the add-on imports itself relatively, because it
runs under three names, and needs the native core only where it computes.

    scripts/check_layers.py [ROOT]
"""

import ast
import re
import sys
from collections.abc import Iterator
from pathlib import Path

LAYER_OF_PART = {
    "core": 0,
    "image": 1,
    "volume": 1,
    "shading": 2,
    "scene": 3,
    "light_shafts": 4,
    "transfer_functions": 4,
    "voxel_dag": 4,
    "render": 5,
    "bindings": 6,
}
#: The modules apart from _native: what a module of Python is made of belongs to the bindings, wherever it lies.
MODULE_OF_ITS_OWN = re.compile(r"(image|volume)/io/module\.cpp")
#: Headers which carry a library that the others must not depend on, and the parts or folders that may include them.
OWNERS_OF_LIBRARY = {
    "OpenImageIO/": {"image/io"},
    "openvdb/": {"volume/io"},
    "nanovdb/": set[str](),
    "boost/": set[str](),  # OpenVDB's own headers include it
    "pybind11/": {"bindings"},
    "Python.h": set[str](),
}
BLENDER_MODULES = {
    "bpy",
    "bpy_extras",
    "bpy_types",
    "_bpy",
    "bl_ui",
    "bl_operators",
    "bmesh",
    "mathutils",
    "gpu",
    "blf",
}
NAMES_OF_ADDON = ("addon", "tyndall_blender", "bl_ext", "tyndall.blender.addon")
SEAM = "tyndall.blender"
#: Parts of the add-on that need the native core; where that does not load, all others register nevertheless.
PARTS_WITH_CORE = {"engine", "sync"}
NAMES_WITH_CORE = ("tyndall", "addon.engine", "addon.sync")

INCLUDE = re.compile(r'^\s*#\s*include\s*[<"]([^>"]+)[>"]')


def native_violations(root: Path) -> Iterator[str]:
    """Includes in native/ that point up, sideways, or into a library of another part."""
    native = root / "native"
    for path in sorted(p for p in native.rglob("*") if p.suffix in {".hpp", ".cpp", ".h"}):
        place = path.relative_to(native).as_posix()
        part = "bindings" if MODULE_OF_ITS_OWN.fullmatch(place) else place.split("/", maxsplit=1)[0]
        if part not in LAYER_OF_PART:
            yield f"{path.relative_to(root)}: {part} has no layer; give it one in scripts/check_layers.py"
            continue
        for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), start=1):
            if match := INCLUDE.match(line):
                for reason in include_violations(part, place, match[1]):
                    yield f"{path.relative_to(root)}:{number}: {reason}"


def include_violations(part: str, place: str, included: str) -> Iterator[str]:
    """What is wrong with one include of a file of part, which lies at place below native/."""
    for library, owners in OWNERS_OF_LIBRARY.items():
        is_owner = part in owners or any(place.startswith(f"{owner}/") for owner in owners)
        if included.startswith(library) and not is_owner:
            yield f"{part} includes {included}, which belongs to {' and '.join(sorted(owners)) or 'a library'}"
    target = included.split("/", maxsplit=1)[0]
    if target == part or target not in LAYER_OF_PART:
        return
    if LAYER_OF_PART[target] == LAYER_OF_PART[part]:
        yield f"{part} includes {included}: two parts of one layer never meet"
    elif LAYER_OF_PART[target] > LAYER_OF_PART[part]:
        yield f"{part} includes {included}: the arrow points up"


def imported_names(tree: ast.Module, package: str) -> Iterator[tuple[int, str]]:
    """Line and absolute dotted name of each import in a module of package, those by import_module included."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            for alias in node.names:
                yield node.lineno, alias.name
        elif isinstance(node, ast.ImportFrom):
            parents = package.split(".")[: len(package.split(".")) - node.level + 1] if node.level else []
            base = ".".join([*parents, *([node.module] if node.module else [])])
            for alias in node.names:
                yield node.lineno, f"{base}.{alias.name}"
        elif (
            isinstance(node, ast.Call)
            and ast.unparse(node.func).split(".")[-1] in {"import_module", "__import__"}
            and node.args
            and isinstance(node.args[0], ast.Constant)
        ):
            yield node.lineno, str(node.args[0].value)


def is_within(name: str, packages: tuple[str, ...] | set[str]) -> bool:
    """Whether a dotted name is one of packages or lies in one."""
    return any(name == package or name.startswith(f"{package}.") for package in packages)


def python_violations(root: Path) -> Iterator[str]:
    """Imports in python/ of Blender or of the add-on outside the seam."""
    base = root / "python"
    for path in sorted(base.rglob("*.py")):
        package = ".".join(path.relative_to(base).parent.parts)
        if is_within(package, (SEAM,)):
            continue
        for number, name in imported_names(ast.parse(path.read_text(encoding="utf-8")), package):
            where = f"{path.relative_to(root)}:{number}"
            if is_within(name, BLENDER_MODULES):
                yield f"{where}: imports {name}; only python/tyndall/blender/ knows Blender"
            elif is_within(name, NAMES_OF_ADDON):
                yield f"{where}: imports {name}; only python/tyndall/blender/ may import the add-on"


def addon_violations(root: Path) -> Iterator[str]:
    """Imports in addon/ that name it absolutely, point back at the seam, or need the core while it registers."""
    base = root / "addon"
    for path in sorted(base.rglob("*.py")):
        package = ".".join(("addon", *path.relative_to(base).parent.parts))
        tree = ast.parse(path.read_text(encoding="utf-8"))
        relative = {node.lineno for node in ast.walk(tree) if isinstance(node, ast.ImportFrom) and node.level}
        for number, name in imported_names(tree, package):
            if number in relative:
                continue
            where = f"{path.relative_to(root)}:{number}"
            if is_within(name, NAMES_OF_ADDON):
                yield f"{where}: imports {name}; the add-on runs under three names, so it imports itself relatively"
            elif is_within(name, (SEAM,)):
                yield f"{where}: imports {name}; the seam registers the add-on, and never the other way round"
        if not PARTS_WITH_CORE & set(path.relative_to(base).parts):
            at_once = ast.Module([node for node in tree.body if isinstance(node, ast.Import | ast.ImportFrom)], [])
            for number, name in imported_names(at_once, package):
                is_named_above = number not in relative and is_within(name, (*NAMES_OF_ADDON, SEAM))
                if is_within(name, NAMES_WITH_CORE) and not is_named_above:
                    yield f"{path.relative_to(root)}:{number}: imports {name}, which needs the core, at once"


def main() -> int:
    """Print every violation; 1 if there is one."""
    root = Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).resolve().parent.parent
    violations = [*native_violations(root), *python_violations(root), *addon_violations(root)]
    for violation in violations:
        print(violation)
    return 1 if violations else 0


if __name__ == "__main__":
    sys.exit(main())
