# SPDX-License-Identifier: GPL-3.0-or-later
"""What Linux says of this process's memory. Its getrusage also counts what started it, before it was itself."""

from __future__ import annotations

from pathlib import Path


def memory_bytes() -> int:
    """Now."""
    return _status("VmRSS:")


def most_memory_bytes() -> int:
    """Since it began, or since forget_most_memory()."""
    return _status("VmHWM:")


def forget_most_memory() -> None:
    """The most is what it is now."""
    Path("/proc/self/clear_refs").write_text("5", encoding="ascii")


def _status(name: str) -> int:
    words = Path("/proc/self/status").read_text(encoding="utf-8").split()
    return int(words[words.index(name) + 1]) << 10
