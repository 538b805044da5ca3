# SPDX-License-Identifier: GPL-3.0-or-later
"""What an artist is told of an exception."""

from __future__ import annotations


def text_of(error: BaseException) -> str:
    """One line that is never empty."""
    if isinstance(error, MemoryError):  # which says "std::bad_alloc", or nothing
        return "There is no memory left for this: try a smaller picture, fewer passes, or smaller meshes and textures"
    return str(error) or type(error).__name__
