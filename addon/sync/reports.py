# SPDX-License-Identifier: GPL-3.0-or-later
"""What the sync replaced or left out: one line per culprit, in the order in which they were met."""

from __future__ import annotations


class Reports:
    """Notes collect under their culprit, so that a material with five unknown nodes is still one line."""

    def __init__(self) -> None:
        self._notes: dict[str, list[str]] = {}

    def add(self, culprit: str, note: str) -> None:
        """``culprit`` names the datablock, as in ``Material "Oak"``; the same note is kept once."""
        notes = self._notes.setdefault(culprit, [])
        if note not in notes:
            notes.append(note)

    def include(self, other: Reports) -> None:
        """What the other was told, too."""
        for culprit, notes in other._notes.items():
            for note in notes:
                self.add(culprit, note)

    def lines(self) -> tuple[str, ...]:
        return tuple(f"{culprit}: {'; '.join(notes)}" for culprit, notes in self._notes.items())
