# SPDX-License-Identifier: GPL-3.0-or-later
"""What Cryptomatte's files say about their planes, so that a matte is picked by its name.

Based on: Friedman and Jones, Cryptomatte specification 1.2.0, 2016, with the manifest inside the file.
"""

from __future__ import annotations

import json
from collections.abc import Iterable

from . import _native

#: What Cycles calls the grey of an empty slot.
MATTE_NAMES = dict.fromkeys(("(no material)", "no material"), "default_surface")


def matte_stamps(layer_name: str, names: Iterable[str]) -> dict[str, str]:
    """Fields for the header of a file, of the planes whose names are ``layer_name`` and two digits."""
    prefix = f"cryptomatte/{_hash_of(layer_name)[:7]}"
    manifest = {name: _hash_of(name) for name in names}
    return {
        f"{prefix}/name": layer_name,
        f"{prefix}/hash": "MurmurHash3_32",
        f"{prefix}/conversion": "uint32_to_float32",
        f"{prefix}/manifest": json.dumps(manifest, ensure_ascii=False, separators=(",", ":")),
    }


def _hash_of(name: str) -> str:
    return f"{_native.matte_hash(name):08x}"
