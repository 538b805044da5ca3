# SPDX-License-Identifier: GPL-3.0-or-later
"""A mesh and what its voxels are to be, in one ``.npz`` file: what workers are given of a job."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .config import Config
from .textures import Material, Textures, pixels_of

_SETTINGS = ("resolution", "rule", "solid", "symmetry", "color_count", "most_color_difference", "normal_bits")


def save_mesh(path: Path, positions_m: ArrayLike, triangles: ArrayLike, config: Config) -> None:
    """All but the budget. Pictures are written as pixels, so that who reads the file needs none of theirs.

    Raises IoError, which names a picture's file, InvalidInput and OSError.
    """
    arrays: dict[str, ArrayLike] = {"positions_m": positions_m, "triangles": triangles}
    for name in (*_SETTINGS, "bounds_m", "colors", "normals"):
        if (value := getattr(config, name)) is not None:
            arrays[name] = value
    for name, values in (config.channels or {}).items():
        arrays[f"channel {name}"] = values
    if config.textures is not None:
        arrays |= _of_textures(config.textures)
    contents: dict[str, Any] = {name: np.asarray(value) for name, value in arrays.items()}
    np.savez(path, **contents)


def load_mesh(path: Path) -> tuple[NDArray[Any], NDArray[np.uint32], Config]:
    """What ``save_mesh`` wrote. Raises OSError."""
    with np.load(path) as kept:
        arrays = {name: kept[name] for name in kept.files}
    settings: dict[str, Any] = {name: arrays[name].item() for name in _SETTINGS if name in arrays}
    for name in ("bounds_m", "colors", "normals"):
        if name in arrays:
            settings[name] = arrays[name] if arrays[name].ndim else str(arrays[name])
    channels = {name.removeprefix("channel "): values for name, values in arrays.items() if name.startswith("channel ")}
    config = replace(Config(), **settings, channels=channels or None, textures=_textures(arrays))
    return arrays["positions_m"], arrays["triangles"], config


def _of_textures(textures: Textures) -> dict[str, ArrayLike]:
    arrays: dict[str, ArrayLike] = {}
    for name in ("corner_uvs", "material_of_triangle"):
        if (value := getattr(textures, name)) is not None:
            arrays[name] = value
    for index, material in enumerate(textures.materials):
        arrays[f"material {index} outside"] = material.outside
        for name, value in material.channels.items():
            arrays[f"material {index} channel {name}"] = value
        if material.color is not None:
            arrays[f"material {index} color"] = np.asarray(material.color)
        elif material.picture is not None:
            pixels, is_srgb = pixels_of(material, index)
            arrays[f"material {index} pixels"] = pixels
            arrays[f"material {index} is_srgb"] = is_srgb
    return arrays


def _textures(arrays: Mapping[str, NDArray[Any]]) -> Textures | None:
    materials: list[Material] = []
    while (name := f"material {len(materials)}") and any(key.startswith(f"{name} ") for key in arrays):
        look: dict[str, Any] = {"outside": str(arrays[f"{name} outside"])}
        if f"{name} color" in arrays:
            look["color"] = tuple(arrays[f"{name} color"].tolist())
        elif f"{name} pixels" in arrays:
            look |= {"picture": arrays[f"{name} pixels"], "is_srgb": bool(arrays[f"{name} is_srgb"])}
        mark = f"{name} channel "
        channels = {key.removeprefix(mark): value for key, value in arrays.items() if key.startswith(mark)}
        materials.append(Material(**look, channels=channels))
    if not materials:
        return None
    return Textures(
        materials=materials,
        corner_uvs=arrays.get("corner_uvs"),
        material_of_triangle=arrays.get("material_of_triangle"),
    )
