# SPDX-License-Identifier: GPL-3.0-or-later
"""The same scene in Cycles and in ours, as arrays, and a verdict that knows how noisy Cycles is.

Cycles is asked for what this engine computes: direct light and single scattering, that is
``max_bounces = volume_bounces = 0``, through any number of transparent surfaces, at the pixels' centres. Its noise is
measured, not guessed: two renders with different seeds differ by nothing else, so their difference says how far their
mean may lie from the truth.
"""

from __future__ import annotations

import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import bpy
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

#: What is allowed beyond noise, of the reference's value: of the whole picture, of the median block and of any block.
MEAN_BOUND, MEDIAN_BOUND, BLOCK_BOUND = 0.001, 0.002, 0.002
NOISE_SIGMAS = 3.0
BLOCK_PX = 9
#: Of a pixel's value; a weaker edge moves its block by less than BLOCK_BOUND.
EDGE_CONTRAST = 0.08
#: Per pixel: blocks are then less noisy than what is asked of ours, but for light from everywhere.
CYCLES_SAMPLES = 256
#: In a picture of a thousand block values three are beyond 3 sigma by chance, and Cycles' noise has longer tails than a
#: Gaussian: the rest must be within 3 sigma, and all within twice that.
STRAY_SHARE = 0.03


def rendered_pixels(scene: bpy.types.Scene) -> FloatArray:
    """Render Combined and read it back, scene-linear (height, width, 3), rows bottom to top."""
    settings = scene.render
    if bpy.app.version >= (5, 0, 0):
        settings.image_settings.media_type = "IMAGE"  # files of others may write films
    settings.image_settings.file_format = "OPEN_EXR"
    settings.image_settings.color_mode = "RGB"
    settings.image_settings.color_depth = "32"
    settings.use_compositing = settings.use_sequencer = False
    with tempfile.TemporaryDirectory() as folder:
        settings.filepath = str(Path(folder) / "frame.exr")
        bpy.ops.render.render(write_still=True, scene=scene.name)
        image = bpy.data.images.load(settings.filepath)
        width, height = image.size
        pixels = np.empty(width * height * image.channels, np.float32)
        image.pixels.foreach_get(pixels)
        channels = image.channels
        bpy.data.images.remove(image)
    return pixels.reshape(height, width, channels)[..., :3].astype(np.float64)


def prepare_cycles(
    scene: bpy.types.Scene, samples: int, seed: int, diffuse_bounces: int = 0, glossy_bounces: int = 0
) -> None:
    """Ask Cycles for direct light and single scattering, and for so many bounces, at the pixels' centres."""
    scene.render.engine = "CYCLES"
    cycles = scene.cycles
    cycles.device = "CPU"
    cycles.samples, cycles.seed = samples, seed
    cycles.use_denoising = cycles.use_adaptive_sampling = cycles.use_auto_tile = False
    cycles.diffuse_bounces, cycles.glossy_bounces = diffuse_bounces, glossy_bounces
    cycles.max_bounces = diffuse_bounces + glossy_bounces
    cycles.transmission_bounces = cycles.volume_bounces = 0
    cycles.transparent_max_bounces = 1024
    cycles.sample_clamp_direct = cycles.sample_clamp_indirect = 0.0
    cycles.light_sampling_threshold = 0.0  # no light is dropped for being weak
    cycles.caustics_reflective = cycles.caustics_refractive = glossy_bounces == 0  # else mirrors throw light
    # Cycles' box filter is one pixel wide whatever its setting says; this one is a point.
    cycles.pixel_filter_type, cycles.filter_width = "BLACKMAN_HARRIS", 0.01
    if scene.world is not None:  # chosen by itself, the map of a small image has 8 million texels and takes 2 s
        scene.world.cycles.sampling_method, scene.world.cycles.sample_map_resolution = "MANUAL", 512
    if hasattr(cycles, "use_light_tree"):
        cycles.use_light_tree = False


def cycles_pixels(
    scene: bpy.types.Scene,
    samples: int = CYCLES_SAMPLES,
    seed: int = 1,
    *,
    diffuse_bounces: int = 0,
    glossy_bounces: int = 0,
) -> FloatArray:
    """Render Combined in Cycles."""
    prepare_cycles(scene, samples, seed, diffuse_bounces, glossy_bounces)
    return rendered_pixels(scene)


def _prepare_tyndall(scene: bpy.types.Scene, samples: int, seed: int) -> None:
    scene.render.engine = "TYNDALL"
    ours = scene.tyndall
    ours.pixel_samples, ours.seed, ours.noise_threshold = samples, seed, 0.0
    ours.pixel_filter, ours.filter_width_px = "BOX", 0.01


def _without_scattered_light(scene: bpy.types.Scene, samples: int, seed: int) -> FloatArray:
    """Render with media that only take light away."""
    lights = [light for light in bpy.data.lights if light.tyndall.scatters_in_media]
    for light in lights:
        light.tyndall.scatters_in_media = False
    _prepare_tyndall(scene, samples, seed)
    scene.tyndall.shafts.world_samples = 0
    pixels = rendered_pixels(scene)
    for light in lights:
        light.tyndall.scatters_in_media = True
    return pixels


def tyndall_pixels(
    scene: bpy.types.Scene,
    methods: Sequence[str],
    *,
    surface_samples: int = 1,
    light_samples: int = 256,
    world_samples: int = 512,
    seed: int = 0,
) -> list[FloatArray]:
    """Render in ours, once per method, at the pixels' centres.

    Light on surfaces is sampled per ray, light in media per light: with few rays of many light samples for the media,
    and many rays for the surfaces, both converge in seconds. No method changes anything on surfaces.
    """
    pictures = []
    for method in methods:
        scene.tyndall.shafts.method = method
        _prepare_tyndall(scene, 1, seed)
        scene.tyndall.shafts.light_samples, scene.tyndall.shafts.world_samples = light_samples, world_samples
        scene.tyndall.shafts.adapts_strata = False
        scene.tyndall.shafts.shares_strata = False  # every pixel asks for all of them: nothing is blurred
        pictures.append(rendered_pixels(scene))
    if surface_samples == 1:
        return pictures
    converged = _without_scattered_light(scene, surface_samples, seed) - _without_scattered_light(scene, 1, seed)
    return [picture + converged for picture in pictures]


def pixels_on_edges(scene: bpy.types.Scene, margin_px: float = 0.03) -> NDArray[np.bool_]:
    """Find the pixels, (height, width), whose centre lies within a margin of an edge of something seen.

    On which side such a centre lies is rounding, and Cycles' narrowest filter is 0.01 px wide: no verdict there. Found
    by four pictures of ours from a camera shifted by the margin, with few samples of lights: edges need no more.
    """
    _prepare_tyndall(scene, 1, 0)
    scene.tyndall.shafts.light_samples, scene.tyndall.shafts.world_samples = 1, 4
    # The finest takes 20 s a picture.
    resolution, scene.tyndall.shafts.resolution = scene.tyndall.shafts.resolution, 2048
    lens = scene.camera.data
    shift = lens.shift_x, lens.shift_y
    step = margin_px / max(scene.render.resolution_x, scene.render.resolution_y)
    seen = []
    for x, y in ((-1, -1), (1, -1), (-1, 1), (1, 1)):
        lens.shift_x, lens.shift_y = shift[0] + x * step, shift[1] + y * step
        seen.append(rendered_pixels(scene))
    lens.shift_x, lens.shift_y = shift
    scene.tyndall.shafts.resolution = resolution
    stacked = np.stack(seen)
    spread, level = stacked.max(axis=0) - stacked.min(axis=0), stacked.max(axis=0)
    found: NDArray[np.bool_] = (spread > EDGE_CONTRAST * level + 0.002 * level.mean()).any(axis=2)
    return found


@dataclass(frozen=True)
class Agreement:
    """How far a picture is from Cycles' and how much of that Cycles' own noise explains; relative values."""

    mean_error: float  #: Signed, of the picture's sum.
    mean_sigma: float  #: Standard deviation of that, of both engines.
    median_error: float  #: Median over blocks and channels of the absolute error.
    median_sigma: float  #: What noise alone would make of that median.
    block_count: int  #: Whose channels err together.
    stray_share: float  #: Share of block values beyond BLOCK_BOUND and 3 sigma.
    worst_sigmas: float  #: Of the worst block value: its error beyond BLOCK_BOUND, in sigmas.
    noise: float  #: Median of the blocks' sigmas: what this comparison can see at all.

    @property
    def holds(self) -> bool:
        """The issue's bounds."""
        # The median of n values |z| of noise is itself uncertain: by 1 / (2 f sqrt(n)), with their density f there;
        # relative to the median, 0.6745, that is 1.17 / sqrt(n).
        of_median = 1.0 + NOISE_SIGMAS * 1.17 / self.block_count**0.5
        return (
            abs(self.mean_error) <= MEAN_BOUND + NOISE_SIGMAS * self.mean_sigma
            and self.median_error <= MEDIAN_BOUND + of_median * self.median_sigma
            and self.stray_share <= STRAY_SHARE
            and self.worst_sigmas <= 2 * NOISE_SIGMAS
        )

    def __str__(self) -> str:
        """One line of a report."""
        return (
            f"mean {self.mean_error:+.3%} (sigma {self.mean_sigma:.3%}), "
            f"median block {self.median_error:.3%} (noise {self.median_sigma:.3%}), "
            f"{self.stray_share:.2%} of blocks stray, worst {self.worst_sigmas:.1f} sigma, noise {self.noise:.2%}"
        )


def block_means(picture: FloatArray, block_px: int = BLOCK_PX) -> FloatArray:
    """Means of whole blocks, (rows, columns, channels); what does not fill a block at the upper right is left out."""
    rows, columns = picture.shape[0] // block_px, picture.shape[1] // block_px
    whole = picture[: rows * block_px, : columns * block_px]
    return whole.reshape(rows, block_px, columns, block_px, -1).mean(axis=(1, 3))


def _contrast(picture: FloatArray) -> FloatArray:
    """Largest minus smallest value of each pixel's 3 x 3 neighbours."""
    height, width = picture.shape[:2]
    padded = np.pad(picture, ((1, 1), (1, 1), (0, 0)), mode="edge")
    near = np.stack([padded[y : y + height, x : x + width] for y in range(3) for x in range(3)])
    result: FloatArray = near.max(axis=0) - near.min(axis=0)
    return result


Pair = tuple[FloatArray, FloatArray]  #: Two renders that differ by their seed alone.


def agreement(
    ours: Pair, cycles: Pair, left_out: NDArray[np.bool_] | None = None, cycles_samples: int = CYCLES_SAMPLES
) -> Agreement:
    """Compare the means of two renders each; ``left_out`` is (height, width).

    A pixel's two values differ by a variance of 2 s^2, where s^2 is that of one render; the mean of both has s^2 / 2.
    Cycles' pixels are independent: a block's mean has that over its number of pixels. Ours share a light's samples:
    there the blocks' own differences count, each no less than is usual in the picture.
    """
    if left_out is not None:
        ours = tuple(np.where(left_out[..., None], 0.0, picture) for picture in ours)
        cycles = tuple(np.where(left_out[..., None], 0.0, picture) for picture in cycles)
    reference, mine = (cycles[0] + cycles[1]) / 2, (ours[0] + ours[1]) / 2
    # Of a pixel's samples Cycles places one, the same with each seed, far outside its narrow filter (measured: an edge
    # up to half a pixel away shows with the weight of one sample).
    variance = (cycles[0] - cycles[1]) ** 2 / 4 + (_contrast(reference) / cycles_samples) ** 2
    blocks, mine_in_blocks = block_means(reference), block_means(mine)
    # A block that Cycles left black by chance has no measured noise: the picture's level keeps it from dividing by 0.
    scale = np.maximum(blocks, 1e-3 * blocks.mean())
    own = np.abs(block_means(ours[0]) - block_means(ours[1])) / 2 / scale
    own = np.maximum(own, np.sqrt((own**2).mean()))
    sigma = np.hypot(np.sqrt(block_means(variance) / BLOCK_PX**2) / scale, own)
    error = np.abs(mine_in_blocks - blocks) / scale
    sigmas = np.maximum(error - BLOCK_BOUND, 0.0) / np.maximum(sigma, 1e-6)
    total = reference.sum()
    # Two sums of ours tell little of their spread, and a light's colours err in opposite directions: the channels are
    # three witnesses, taken as if they erred together.
    of_channels = np.abs(ours[0].sum(axis=(0, 1)) - ours[1].sum(axis=(0, 1))) / 2
    own_total = float(np.sqrt(((of_channels / reference.sum(axis=(0, 1))) ** 2).mean())) * total
    return Agreement(
        mean_error=float((mine.sum() - total) / total),
        mean_sigma=float(np.hypot(np.sqrt(variance.sum()), own_total) / total),
        median_error=float(np.median(error)),
        median_sigma=float(0.6745 * np.median(sigma)),
        block_count=error.shape[0] * error.shape[1],
        stray_share=float((sigmas > NOISE_SIGMAS).mean()),
        worst_sigmas=float(sigmas.max()),
        noise=float(np.median(sigma)),
    )


def save_side_by_side(path: Path, ours: FloatArray, reference: FloatArray) -> None:
    """Write a PNG to look at: ours, Cycles', and their difference, red where ours is brighter, blue where darker."""
    level = max(float(np.percentile(reference, 99)), 1e-9)
    difference = (ours - reference).mean(axis=2) / level * 10
    signed = np.stack(
        [
            np.clip(difference, 0, 1),
            np.zeros_like(difference),
            np.clip(-difference, 0, 1),
        ],
        axis=2,
    )
    shown = np.concatenate([ours / level, reference / level, signed], axis=1)
    encoded = np.clip(shown, 0, 1) ** (1 / 2.2)
    height, width = encoded.shape[:2]
    image = bpy.data.images.new("side by side", width, height)
    image.pixels.foreach_set(np.dstack([encoded, np.ones((height, width))]).astype(np.float32).ravel())
    image.filepath_raw, image.file_format = str(path), "PNG"
    path.parent.mkdir(parents=True, exist_ok=True)
    image.save()
    bpy.data.images.remove(image)
