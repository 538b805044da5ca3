# SPDX-License-Identifier: GPL-3.0-or-later
"""Lines of points on two logarithmic axes, as SVG."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from html import escape

WIDTH_PX, HEIGHT_PX, MARGIN_PX = 760, 480, 64
MOST_ZEROS = 3  #: Of a number that is written out.
COLOURS = ("#0b6e99", "#c0392b", "#2e7d32", "#8e44ad", "#b9770e", "#34495e", "#d81b60", "#00897b")


@dataclass(frozen=True)
class Point:
    """Two positive numbers, and what is written beside them."""

    label: str
    x: float
    y: float


@dataclass(frozen=True)
class Line:
    """Points by rising x, in a colour of COLOURS, or in black if the line is the one to compare with."""

    name: str
    points: Sequence[Point]
    is_reference: bool = False


def _decades(values: Sequence[float]) -> tuple[int, int]:
    """Powers of ten that enclose the values."""
    low, high = math.floor(math.log10(min(values))), math.ceil(math.log10(max(values)))
    return low, max(high, low + 1)


def _tick(decade: int) -> str:
    return f"1e{decade}" if abs(decade) > MOST_ZEROS else f"{10.0**decade:g}"


def draw(title: str, lines: Sequence[Line]) -> str:
    """Draw an SVG of WIDTH_PX x HEIGHT_PX. There has to be a point."""
    return svg(WIDTH_PX, HEIGHT_PX, [panel(title, lines)])


def draw_side_by_side(columns: int, panels: Sequence[tuple[str, Sequence[Line]]]) -> str:
    """Draw an SVG of panels of that size, row by row."""
    drawn = [
        f'<g transform="translate({index % columns * WIDTH_PX} {index // columns * HEIGHT_PX})">{panel(*what)}</g>'
        for index, what in enumerate(panels)
    ]
    return svg(WIDTH_PX * columns, HEIGHT_PX * -(-len(panels) // columns), drawn)


def svg(width_px: int, height_px: int, content: Sequence[str]) -> str:
    """Wrap drawings on white ground."""
    head = (
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{width_px}" height="{height_px}" '
        f'viewBox="0 0 {width_px} {height_px}" font-family="sans-serif" font-size="12">'
        '<rect width="100%" height="100%" fill="white"/>'
    )
    return "\n".join([head, *content, "</svg>\n"])


def panel(title: str, lines: Sequence[Line]) -> str:
    """Draw axes, lines and their names."""
    points = [point for line in lines for point in line.points]
    x_low, x_high = _decades([point.x for point in points])
    y_low, y_high = _decades([point.y for point in points])

    def x_px(x: float) -> float:
        return MARGIN_PX + (math.log10(x) - x_low) / (x_high - x_low) * (WIDTH_PX - 2 * MARGIN_PX)

    def y_px(y: float) -> float:
        return HEIGHT_PX - MARGIN_PX - (math.log10(y) - y_low) / (y_high - y_low) * (HEIGHT_PX - 2 * MARGIN_PX)

    drawn = [f'<text x="{MARGIN_PX}" y="28" font-size="15">{escape(title)}</text>']
    for decade in range(x_low, x_high + 1):
        x = x_px(10.0**decade)
        drawn.append(f'<path d="M{x:.1f} {MARGIN_PX}V{HEIGHT_PX - MARGIN_PX}" stroke="#ddd"/>')
        drawn.append(f'<text x="{x:.1f}" y="{HEIGHT_PX - MARGIN_PX + 18}" text-anchor="middle">{_tick(decade)}</text>')
    for decade in range(y_low, y_high + 1):
        y = y_px(10.0**decade)
        drawn.append(f'<path d="M{MARGIN_PX} {y:.1f}H{WIDTH_PX - MARGIN_PX}" stroke="#ddd"/>')
        drawn.append(f'<text x="{MARGIN_PX - 6}" y="{y + 4:.1f}" text-anchor="end">{_tick(decade)}</text>')
    for index, line in enumerate(lines):
        colour = "#000000" if line.is_reference else COLOURS[index % len(COLOURS)]
        dashes = ' stroke-dasharray="5 4"' if line.is_reference else ""
        track = " ".join(f"{x_px(point.x):.1f},{y_px(point.y):.1f}" for point in line.points)
        drawn.append(f'<polyline points="{track}" fill="none" stroke="{colour}"{dashes}/>')
        for point in line.points:
            x, y = x_px(point.x), y_px(point.y)
            hint = escape(f"{line.name} {point.label}: {point.x:.3g}, {point.y:.3g}")
            drawn.append(f'<circle cx="{x:.1f}" cy="{y:.1f}" r="4" fill="{colour}"><title>{hint}</title></circle>')
            drawn.append(f'<text x="{x + 6:.1f}" y="{y - 6:.1f}" fill="{colour}">{escape(point.label)}</text>')
        legend_y = MARGIN_PX + 16 * index
        place = f'x="{WIDTH_PX - MARGIN_PX}" y="{legend_y}" fill="{colour}" text-anchor="end"'
        drawn.append(f"<text {place}>{escape(line.name)}</text>")
    return "\n".join(drawn)
