# SPDX-License-Identifier: GPL-3.0-or-later
"""Writes addon/sync/hosek_sky_table.py: the coefficients of Hosek's and Wilkie's sky, measured from pictures of it.

Based on: Hosek and Wilkie 2012, An Analytic Model for Full Spectral Sky-Dome Radiance: its formula, and that every
          coefficient is a quintic Bezier function of the cube root of the sun's elevation.
Differs:  their coefficients are not read from anywhere: Cycles renders skies of known sun, turbidity and albedo, and
          the coefficients are those that draw the same pictures.

Run it with Blender as a Python module (``python tests/support/fit_hosek_sky.py``); some minutes.

Per turbidity, albedo and channel of XYZ there are 60 unknowns: 6 control values of each of 9 shape coefficients and of
the radiance. Those that the formula is not linear in are found by damped least squares, the others by linear least
squares within (variable projection). First the shape's linear ones are free at each elevation; from there, all are
Bezier functions. What stays open is a factor between shape and radiance: it does not change the sky of a whole
turbidity and albedo 0 or 1, but that of those between, whose pictures give it.
"""

from __future__ import annotations

import math
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path

import bpy
import numpy as np
from mathutils import Color
from numpy.typing import NDArray

Array = NDArray[np.float64]

REPOSITORY = Path(__file__).resolve().parents[2]
sys.path[:0] = [str(REPOSITORY), str(REPOSITORY / "python")]

from addon.sync.hosek_sky import NAMES, bezier_weights, coefficients, control_values, sky_xyz  # noqa: E402

TARGET = REPOSITORY / "addon" / "sync" / "hosek_sky_table.py"
SIZE_PX = 40
FIT_DIRECTIONS = 400
#: Spread evenly over the Bezier parameter, but for the lowest.
FIT_ELEVATIONS_DEG = 90.0 * np.array([0.0, 0.14, 0.2, 0.3, 0.42, 0.53, 0.63, 0.72, 0.8, 0.88, 0.95, 1.0]) ** 3
BETWEEN_ELEVATIONS_DEG = (1.0, 8.0, 25.0, 60.0)
#: A, B, E and H: what the shape is not linear in.
BENT = ("A", "B", "E", "H")
STARTS = [(-1.1, -0.4, -1.0, 0.4), (-1.1, -0.4, -3.0, 0.6), (-1.3, -0.5, -0.3, 0.6), (-1.2, -0.3, 0.2, 0.5)]
GOOD_RMS = 3e-6
ENOUGH_RMS = 2e-5
LEAST_ITERATIONS = 4
TURBIDITIES = 10
_HEADER = '''# SPDX-License-Identifier: GPL-3.0-or-later
"""Made by tests/support/fit_hosek_sky.py, which says how: measured from pictures, not from the authors' files.

Per turbidity 1 to 10, ground albedo 0 and 1, channel of XYZ, and coefficient A to I and L: six control values.
"""

'''


class Camera:
    """Half the upper half of all directions: the other is its mirror image, the sun being between them."""

    def __init__(self) -> None:
        bpy.ops.wm.read_factory_settings(use_empty=True)
        self.scene = scene = bpy.context.scene
        scene.world = bpy.data.worlds.new("World")
        scene.world.use_nodes = True
        scene.world.cycles.sampling_method = "NONE"
        lens = bpy.data.cameras.new("Camera")
        scene.camera = bpy.data.objects.new("Camera", lens)
        scene.collection.objects.link(scene.camera)
        scene.camera.rotation_euler = (0.5 * math.pi, 0.0, 0.0)
        lens.type = "PANO"
        lens.panorama_type = "EQUIRECTANGULAR"
        lens.latitude_min, lens.latitude_max = 0.0, 0.5 * math.pi
        lens.longitude_min, lens.longitude_max = 0.0, math.pi
        render, cycles = scene.render, scene.cycles
        render.engine, render.threads_mode, render.threads = "CYCLES", "FIXED", 1
        render.resolution_x = render.resolution_y = SIZE_PX
        render.resolution_percentage, render.use_persistent_data = 100, True
        image = render.image_settings
        image.file_format, image.color_mode, image.color_depth, image.exr_codec = "OPEN_EXR", "RGB", "32", "NONE"
        cycles.device, cycles.samples, cycles.seed, cycles.max_bounces = "CPU", 1, 1, 0
        cycles.use_denoising = cycles.use_adaptive_sampling = False
        cycles.pixel_filter_type, cycles.filter_width = "BLACKMAN_HARRIS", 0.01
        self.directions = self._directions()
        tree = scene.world.node_tree
        self.sky = tree.nodes.new("ShaderNodeTexSky")
        self.sky.sky_type = "HOSEK_WILKIE"
        tree.links.new(self.sky.outputs[0], tree.nodes["Background"].inputs[0])
        units = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
        self.xyz_from_rgb = np.linalg.inv(np.array([tuple(Color(one).from_xyz_d65_to_scene_linear()) for one in units]))

    def _directions(self) -> Array:
        """As Cycles has them: a sample is not exactly at its pixel's centre."""
        tree = self.scene.world.node_tree
        place, shift = tree.nodes.new("ShaderNodeTexCoord"), tree.nodes.new("ShaderNodeVectorMath")
        shift.operation = "MULTIPLY_ADD"
        shift.inputs[1].default_value = shift.inputs[2].default_value = (0.5, 0.5, 0.5)
        tree.links.new(place.outputs["Generated"], shift.inputs[0])
        tree.links.new(shift.outputs[0], tree.nodes["Background"].inputs[0])
        directions = 2.0 * self._picture() - 1.0
        return directions / np.linalg.norm(directions, axis=1, keepdims=True)

    def _picture(self) -> Array:
        with tempfile.TemporaryDirectory() as folder:
            self.scene.render.filepath = str(Path(folder) / "sky.exr")
            bpy.ops.render.render(write_still=True)
            image = bpy.data.images.load(self.scene.render.filepath)
            pixels = np.empty(SIZE_PX * SIZE_PX * image.channels, np.float32)
            image.pixels.foreach_get(pixels)
            picture = pixels.reshape(-1, image.channels)[:, :3].astype(np.float64)
            bpy.data.images.remove(image)
        return picture

    def xyz(self, turbidity: float, albedo: float, elevation_deg: float) -> Array:
        """(directions, 3)."""
        self.sky.turbidity, self.sky.ground_albedo = turbidity, albedo
        self.sky.sun_direction = towards(elevation_deg)
        picture = self._picture()
        if picture.min() <= 0.0:
            message = f"clipped colours at turbidity {turbidity}, albedo {albedo}, elevation {elevation_deg}"
            raise ValueError(message)
        return picture @ self.xyz_from_rgb


def towards(elevation_deg: float) -> tuple[float, float, float]:
    """Where the sun is."""
    angle = math.radians(elevation_deg)
    return 0.0, math.cos(angle), math.sin(angle)


def damped_least_squares(residuals: Callable[[Array], Array], start: Array, iterations: int) -> tuple[Array, float]:
    """Levenberg's and Marquardt's, derivatives by differences: the best and its root mean square."""
    best, damping = start.copy(), 1e-3
    values = residuals(best)
    cost = float(values @ values)
    for iteration in range(iterations):
        slopes = np.empty((len(values), len(best)))
        for column in range(len(best)):
            moved = best.copy()
            step = 1e-6 * max(1.0, abs(moved[column]))
            moved[column] += step
            slopes[:, column] = (residuals(moved) - values) / step
        normal, gradient = slopes.T @ slopes, slopes.T @ values
        scale = np.diag(normal) + 1e-12 * np.trace(normal)
        before = cost
        for _ in range(10):
            proposed = best - np.linalg.solve(normal + damping * np.diag(scale), gradient)
            its_values = residuals(proposed)
            its_cost = float(its_values @ its_values)
            if its_cost < cost:
                best, values, cost, damping = proposed, its_values, its_cost, max(0.2 * damping, 1e-13)
                break
            damping *= 5.0
        if before - cost <= 1e-6 * before and iteration >= LEAST_ITERATIONS:
            break
    return best, math.sqrt(cost / len(values))


class Fit:
    """Of one turbidity, albedo and channel."""

    def __init__(self, directions: Array, pictures: list[Array]) -> None:
        """Pictures: one per elevation of the fit."""
        self.weights = bezier_weights(FIT_ELEVATIONS_DEG)
        self.means = np.array([picture.mean() for picture in pictures])
        self.wanted = np.concatenate([picture / picture.mean() for picture in pictures])
        self.up = np.maximum(directions[:, 2], math.sin(0.001))
        self.angles = [_angles(directions, elevation) for elevation in FIT_ELEVATIONS_DEG]

    def _columns(self, bent: Array, index: int) -> Array:
        """What C, D, F, G and I are multiplied by, at one elevation, per mean radiance there."""
        a, b, e, h = self.weights[index] @ bent.reshape(4, 6).T
        angle = self.angles[index]
        square = np.cos(angle) ** 2
        ones = np.ones_like(angle)
        glow = (1.0 + square) / np.abs(1.0 + h * h - 2.0 * h * np.cos(angle)) ** 1.5
        columns = np.stack([ones, np.exp(e * angle), square, glow, np.sqrt(self.up)], axis=-1)
        return columns * ((1.0 + a * np.exp(b / (self.up + 0.01))) / self.means[index])[:, None]

    def _free(self, bent: Array) -> Array:
        """Residuals when C, D, F, G and I are free at each elevation."""
        parts = []
        for index in range(len(self.means)):
            columns = self._columns(bent, index)
            parts.append(columns @ _solved(columns, self._of(index)) - self._of(index))
        return _finite(np.concatenate(parts))

    def _of(self, index: int) -> Array:
        return self.wanted.reshape(len(self.means), -1)[index]

    def _design(self, bent: Array, radiance: Array) -> Array:
        """What the control values of C, D, F, G and I are multiplied by."""
        parts = [
            np.einsum("dk,j->dkj", self._columns(bent, index) * (weights @ radiance), weights).reshape(-1, 30)
            for index, weights in enumerate(self.weights)
        ]
        return np.concatenate(parts)

    def _all(self, unknown: Array) -> Array:
        design = self._design(unknown[:24], unknown[24:])
        return _finite(design @ _solved(design, self.wanted) - self.wanted)

    def _radiances(self, bent: Array) -> list[Array]:
        """Where to begin: the mean radiances, and what makes Bezier functions of the free coefficients.

        The latter is linear in the radiances' inverses and the functions' control values, and as close to 0 as can be.
        """
        count = len(self.means)
        rows = np.zeros((count * 5, count + 30))
        for index, weights in enumerate(self.weights):
            columns = self._columns(bent, index) * self.means[index]
            triangle = np.linalg.qr(columns)[1]
            free = _solved(columns, self._of(index))
            rows[5 * index : 5 * index + 5, index] = triangle @ free
            rows[5 * index : 5 * index + 5, count:] = -np.einsum("rk,j->rkj", triangle, weights).reshape(5, 30)
        size = np.linalg.norm(rows, axis=0)
        inverses = (np.linalg.svd(rows / size)[2][-1] / size)[:count]
        exact = np.linalg.lstsq(self.weights * (inverses / self.means)[:, None], np.ones(count), rcond=None)[0]
        return [np.linalg.lstsq(self.weights, self.means, rcond=None)[0], exact]

    def run(self, starts: list[Array]) -> tuple[Array, float]:
        """(10, 6) control values and the root mean square of what is left, per mean radiance.

        Starts: control values of A, B, E and H, 24 each.
        """
        tries: list[tuple[float, Array]] = []
        for start in starts:
            bent, rms = damped_least_squares(self._free, start, 60)
            tries.append((rms, bent))
            if rms < GOOD_RMS:
                break
        free, bent = min(tries, key=lambda one: one[0])
        begin = min(
            (np.concatenate([bent, radiance]) for radiance in self._radiances(bent)),
            key=lambda one: float(np.sum(self._all(one) ** 2)),
        )
        unknown, rms = damped_least_squares(self._all, begin, 60)
        scale = np.sum(self.means**2) / np.sum(self.means * (self.weights @ unknown[24:]))
        unknown[24:] *= scale
        linear = _solved(self._design(unknown[:24], unknown[24:]), self.wanted).reshape(5, 6)
        values = dict(zip(BENT, unknown[:24].reshape(4, 6), strict=True))
        values |= dict(zip(("C", "D", "F", "G", "I"), linear, strict=True))
        values["L"] = unknown[24:]
        print(f"    free {free:.1e} of {len(tries)} starts, all {rms:.1e}", flush=True)
        return np.stack([values[name] for name in NAMES]), rms


def _angles(directions: Array, elevation_deg: float) -> Array:
    chord = np.linalg.norm(directions - towards(elevation_deg), axis=1)
    angles: Array = 2.0 * np.arcsin(np.minimum(0.5 * chord, 1.0))
    return angles


def _solved(columns: Array, wanted: Array) -> Array:
    """Least squares, kept from large values that cancel."""
    normal = columns.T @ columns
    normal[np.diag_indices_from(normal)] *= 1.0 + 1e-12
    try:
        return np.linalg.solve(normal, columns.T @ wanted)
    except np.linalg.LinAlgError:
        return np.zeros(columns.shape[1])


def _finite(values: Array) -> Array:
    return np.nan_to_num(values, nan=1e3, posinf=1e3, neginf=-1e3)


def fitted(directions: Array, pictures: dict[tuple[int, int], list[Array]]) -> Array:
    """(10 turbidities, 2 albedos, XYZ, 10, 6): from fixed starts, then what failed from its neighbours."""
    table, left = np.zeros((10, 2, 3, len(NAMES), 6)), np.full((10, 2, 3), np.inf)
    fixed = [np.repeat(np.array(start), 6) for start in STARTS]
    rows = [NAMES.index(name) for name in BENT]
    for attempt in range(4):
        for turbidity, albedo, channel in np.ndindex(left.shape):
            if left[turbidity, albedo, channel] < ENOUGH_RMS:
                continue
            starts = fixed
            if attempt > 0:
                beside = [(turbidity - 1, albedo, channel), (turbidity + 1, albedo, channel)]
                beside += [(turbidity, 1 - albedo, channel), (turbidity, albedo, (channel + 1) % 2)]
                beside = [one for one in beside if 0 <= one[0] < TURBIDITIES and left[one] < ENOUGH_RMS]
                starts = [table[one][rows].ravel() for one in beside]
            if not starts:
                continue
            print(f"turbidity {turbidity + 1}, albedo {albedo}, channel {channel}")
            fit = Fit(directions, [picture[:, channel] for picture in pictures[turbidity + 1, albedo]])
            found, rms = fit.run(starts)
            if rms < left[turbidity, albedo, channel]:
                table[turbidity, albedo, channel], left[turbidity, albedo, channel] = found, rms
    print(f"worst fit: {left.max():.1e} of the mean")
    return table


def balance(table: Array, directions: Array, between: list[tuple[float, float, float, Array]]) -> None:
    """Move factors between the shapes and their radiances until the skies between are right; the table is changed."""
    shape, radiance = [NAMES.index(name) for name in ("C", "D", "F", "G", "I")], NAMES.index("L")
    for channel in range(3):
        start = table[:, :, channel : channel + 1].copy()

        def moved(logarithms: Array, start: Array = start) -> Array:
            factors = np.exp(logarithms).reshape(10, 2, 1, 1)
            new = start.copy()
            new[..., shape, :] /= factors[..., None]
            new[..., radiance, :] *= factors
            return new

        def residuals(logarithms: Array, channel: int = channel) -> Array:
            new = moved(logarithms)
            parts = []
            for turbidity, albedo, elevation, picture in between:
                found = coefficients(turbidity, albedo, elevation, new)
                sky = sky_xyz(found, directions[:, 2], _angles(directions, elevation))[:, 0]
                parts.append(sky / picture[:, channel].mean() - picture[:, channel] / picture[:, channel].mean())
            return np.concatenate(parts)

        logarithms, rms = damped_least_squares(residuals, np.zeros(20), 30)
        print(f"balance of channel {channel}: {rms:.1e}, factors up to {np.exp(np.abs(logarithms).max()):.3f}")
        table[:, :, channel] = moved(logarithms)[:, :, 0]


def write(table: Array) -> None:
    """Make the add-on's module."""
    rows = [" ".join(f"{value:.6g}" for value in row) for row in table.reshape(-1, 12)]
    block = "\n".join(rows)
    TARGET.write_text(f'{_HEADER}CONTROL_VALUES = """\n{block}\n"""\n')


def check(camera: Camera, count: int) -> None:
    """Skies that nothing was fitted to, in all directions, by what was written."""
    table, random, worst = control_values(), np.random.default_rng(2), 0.0
    for _ in range(count):
        turbidity, albedo, share = random.uniform(1.0, 10.0), random.uniform(), random.uniform()
        elevation = 0.5 + 89.5 * share**2
        picture = camera.xyz(turbidity, albedo, elevation)
        found = coefficients(turbidity, albedo, elevation, table)
        sky = sky_xyz(found, camera.directions[:, 2], _angles(camera.directions, elevation))
        off = float((np.abs(sky - picture) / picture.mean(axis=0)).max())
        worst = max(worst, off)
        print(f"turbidity {turbidity:.2f}, albedo {albedo:.2f}, elevation {elevation:5.2f}: {off:.1e} of the mean")
    print(f"worst direction of {count} skies: {worst:.1e} of the mean")


def main() -> None:
    """Measure, fit, write, and check what was written."""
    camera = Camera()
    chosen = np.random.default_rng(1).permutation(len(camera.directions))[:FIT_DIRECTIONS]
    directions = camera.directions[chosen]
    pictures = {
        (turbidity, albedo): [camera.xyz(turbidity, albedo, elevation)[chosen] for elevation in FIT_ELEVATIONS_DEG]
        for turbidity in range(1, 11)
        for albedo in (0, 1)
    }
    table = fitted(directions, pictures)
    few = chosen[:100]
    halves = [(turbidity + 0.5, float(albedo)) for turbidity in range(1, 10) for albedo in (0, 1)]
    halves += [(float(turbidity), 0.5) for turbidity in range(1, 11)]
    between = [
        (turbidity, albedo, elevation, camera.xyz(turbidity, albedo, elevation)[few])
        for turbidity, albedo in halves
        for elevation in BETWEEN_ELEVATIONS_DEG
    ]
    balance(table, camera.directions[few], between)
    write(table)
    check(camera, 60)


if __name__ == "__main__":
    main()
