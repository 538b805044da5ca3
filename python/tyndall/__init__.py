# SPDX-License-Identifier: GPL-3.0-or-later
"""Tyndall: light shafts and global illumination for Blender, on a native core that knows no Blender."""

__version__ = "0.1.0"
