# SPDX-License-Identifier: GPL-3.0-or-later
"""Numbers as panels and messages say them: three digits, and the unit that suits."""

from __future__ import annotations

_UNITS = ("B", "KB", "MB", "GB", "TB")
_KILO, _MILLION, _BILLION = 1e3, 10**6, 10**9


def duration_text(seconds: float) -> str:
    """Three digits of a duration."""
    if seconds < 1.0:
        return f"{seconds * 1e3:.3g} ms"
    minutes, rest = divmod(seconds, 60)
    return f"{int(minutes)} min {rest:.0f} s" if minutes else f"{seconds:.3g} s"


def bytes_text(count: float) -> str:
    """Of bytes, in powers of 1000, as file managers and the documents do."""
    unit = 0
    while round(count) >= _KILO and unit + 1 < len(_UNITS):
        count, unit = count / _KILO, unit + 1
    return f"{count:.3g} {_UNITS[unit]}"


def count_text(count: int) -> str:
    """Whole below a million."""
    if count < _MILLION:
        return f"{count:,}"
    return f"{count / _MILLION:.4g} M" if count < _BILLION else f"{count / _BILLION:.4g} G"
