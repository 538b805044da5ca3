# SPDX-License-Identifier: GPL-3.0-or-later
"""Motion blur, and shafts behind a lens: moments that Blender evaluates, places on the lens, few renders of both.

Based on: Haeberli and Akeley, The Accumulation Buffer, SIGGRAPH 1990.
Differs:  from Cycles, which gives each ray a time of its own: slope rows of light shafts are laid out for one scene.
          All that Blender can animate blurs, lights, lenses, media and edits, too; what a moment shows is exact, and
          few moments show as many copies of what moves fast.
          Where shafts blur by a lens, too, each moment sees them through a place of its own.
Skipped:  moments that look alike are one render. Where all do, it is the render without blur, bit for bit.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

from tyndall.film_means import FilmMean, passes_of_parts
from tyndall.lens_points import has_lens_points, lens_point, seen_through
from tyndall.renderer import Film
from tyndall.shutter_times import Moment, moments

if TYPE_CHECKING:
    from bpy.types import RenderEngine

    from tyndall.renderer import RenderConfig

    from .frame_looks import Look, LookReader
    from .shutters import Shutter


@dataclass(frozen=True, kw_only=True)
class Exposure:
    """Samples that all see the same."""

    look: Look
    first_sample: int
    sample_count: int
    pixel_samples: int  #: Of the whole picture.
    pictures: int  #: That it is made of, or fewer.

    @classmethod
    def whole(cls, look: Look, pixel_samples: int) -> Exposure:
        """All samples see the same."""
        return cls(look=look, first_sample=0, sample_count=pixel_samples, pixel_samples=pixel_samples, pictures=1)

    @property
    def is_whole(self) -> bool:
        return self.sample_count == self.pixel_samples

    @property
    def has_middle(self) -> bool:
        """Whether the sample in the middle of all is one of these."""
        return self.first_sample <= self.pixel_samples // 2 < self.first_sample + self.sample_count

    def config(self, whole: RenderConfig) -> RenderConfig:
        """Of so many samples the noise is larger than that of all, and so is what may be left of it.

        Lights' strata are dealt out to moments, and to places on a lens: together they have those of one picture. So
        may slope rows err more that are laid out anew around each place.
        """
        config = replace(whole, transfer_functions=self.look.functions, heterogeneity=self.look.heterogeneity)
        if self.is_whole:
            return config
        more = (self.pixel_samples / self.sample_count) ** 0.5
        end = self.first_sample + self.sample_count
        lens = self.look.camera.lens
        shafts = replace(
            whole.shafts,
            part=(self.first_sample, end, self.pixel_samples, self.pictures),
            part_has_own_view=lens is not None and lens.air_place is not None,
        )
        return replace(
            config,
            shafts=shafts,
            first_sample=self.first_sample,
            sample_count=self.sample_count,
            noise_threshold=min(more * whole.noise_threshold, 1.0),
            passes=passes_of_parts(whole.passes),
        )


def lens_step_count(look: Look, pixel_samples: int, most: int) -> int:
    """Through how many places on its camera's lens the shafts of a picture are seen; 1: the middle alone."""
    has_shafts = bool(look.description.media) and has_lens_points(look.camera)
    return min(pixel_samples, most) if has_shafts else 1


def lens_exposures(look: Look, pixel_samples: int, count: int) -> Iterator[Exposure]:
    """One scene through so many places of the lens."""
    parts = moments(pixel_samples, count)
    for index, part in enumerate(parts):
        yield _exposure(_through_lens(look, index), part, pixel_samples, len(parts))


def exposures(
    engine: RenderEngine,
    reader: LookReader,
    of_frame: Look,
    shutter: Shutter,
    pixel_samples: int,
    most: int,
    *,
    sees_through_lens: bool,
) -> Iterator[Exposure]:
    """One after another, each as soon as the next moment is known to differ. Blender's frame is left anywhere."""
    waiting: Exposure | None = None
    look = of_frame
    all_moments = shutter.moments(pixel_samples, most)
    for index, moment in enumerate(all_moments):
        reader.poll()
        engine.frame_set(*shutter.frame_of(moment))
        look = reader.read_moment(look)
        seen = _through_lens(look, index) if sees_through_lens else look
        if waiting is not None and waiting.look is seen:
            waiting = replace(waiting, sample_count=waiting.sample_count + moment.sample_count)
            continue
        if waiting is not None:
            yield waiting
        waiting = _exposure(seen, moment, pixel_samples, len(all_moments))
    if waiting is not None:
        yield waiting


def _through_lens(look: Look, index: int) -> Look:
    """Of the place with that number; as it is, where the lens of the moment does not blur."""
    if not has_lens_points(look.camera):
        return look
    return replace(look, camera=seen_through(look.camera, lens_point(index)))


def _exposure(look: Look, part: Moment, pixel_samples: int, pictures: int) -> Exposure:
    return Exposure(
        look=look,
        first_sample=part.first_sample,
        sample_count=part.sample_count,
        pixel_samples=pixel_samples,
        pictures=pictures,
    )


class ExposedFilm:
    """The films of exposures, put together."""

    def __init__(self) -> None:
        self._mean = FilmMean()
        self._only: Film | None = None
        self._statistics: list[dict[str, Any]] = []

    def add(self, film: Film, exposure: Exposure) -> None:
        self._statistics.append(film.statistics)
        if exposure.is_whole:
            self._only = film
        else:
            self._mean.add(film.planes, exposure.sample_count, is_middle=exposure.has_middle)

    def with_part(self, film: Film, exposure: Exposure, fraction: float) -> Film | None:
        """The picture so far while an exposure renders; None while a part of its pixels has no sample."""
        if self._mean.is_empty:
            return film
        sample_count = fraction * exposure.sample_count
        return Film(planes=self._mean.mean_with(film.planes, sample_count)) if sample_count >= 1.0 else None

    def finished(self, *, moment_count: int | None, lens_step_count: int) -> Film:
        """Of so many moments, if a shutter was open, and places on a lens."""
        statistics = _statistics_of_all(self._statistics)
        if moment_count is not None:
            statistics["counts"]["motion blur: moments"] = float(moment_count)
            statistics["counts"]["motion blur: renders"] = float(len(self._statistics))
        if lens_step_count > 1:
            statistics["counts"]["light shafts: places on the lens"] = float(lens_step_count)
        if self._only is not None:
            reason = "nothing that the picture shows changes while the shutter is open"
            statistics["skipped"].append({"what": "motion blur", "reason": reason})
            return replace(self._only, statistics=statistics)
        return Film(planes=self._mean.mean(), statistics=statistics)


def _statistics_of_all(parts: list[dict[str, Any]]) -> dict[str, Any]:
    """Times are sums, and so is what was done; other counts are of the last render."""
    seconds: dict[str, float] = {}
    counts: dict[str, float] = {}
    for part in parts:
        for stage in part["stages"]:
            seconds[stage["name"]] = seconds.get(stage["name"], 0.0) + stage["seconds"]
        for name, number in part["counts"].items():
            counts[name] = counts.get(name, 0.0) + number if _is_added(name) else number
    return {
        "stages": [{"name": name, "seconds": of_stage} for name, of_stage in seconds.items()],
        "skipped": list({tuple(entry.items()): entry for part in parts for entry in part["skipped"]}.values()),
        "counts": counts,
        "reports": list(dict.fromkeys(line for part in parts for line in part["reports"])),
    }


def _is_added(name: str) -> bool:
    return name in {"samples per pixel", "light shafts: rays"} or name.endswith(
        (" sent", " rebuilt", " relit", " moved")
    )
