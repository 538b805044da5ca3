# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's evaluated scene as plain arrays. Needs the tyndall package, so it is imported when a render begins."""
