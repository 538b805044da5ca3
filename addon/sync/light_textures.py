# SPDX-License-Identifier: GPL-3.0-or-later
"""Pictures before lights: the image nodes of a light's tree as Cycles reads them, and the gobo of our own."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from mathutils import Matrix

from tyndall.scene_description import Extension, LightProjection, LightTexture, TextureUse

from .light_vectors import CannotBeRead, Frame, Start, Vector, read_vector, spot_coordinates, uv_of_light
from .program import BLACK, Term, Value
from .texture_mapping import own_matrix
from .texture_nodes import EXTENSIONS, image_use
from .value_nodes import Domain, ValueReader

if TYPE_CHECKING:
    import bpy
    from numpy.typing import NDArray

    from .affine_colours import AffineColour
    from .images import ImageReader
    from .node_graph import Socket
    from .reports import Reports


class LightValueReader(ValueReader):
    """Evaluates nodes that show one image, and keeps where it lies. Raises CannotBeRead for all others."""

    def __init__(self, light: bpy.types.Light, culprit: str, reports: Reports, images: ImageReader) -> None:
        super().__init__(culprit, reports, images, Domain.LIGHT)
        self._light = light
        self._placed: list[LightTexture] = []
        self._vectors: list[Vector] = []

    def unsupported(self, at: Socket, fallback: str) -> None:
        raise CannotBeRead(f"{at.node.bl_label} {fallback}")

    def constant(self, at: Socket | None, default: float = 0.0) -> float:
        if isinstance(self.number(at, default), Term):
            raise CannotBeRead("a number that varies")
        return super().constant(at, default)

    def constant_colour(self, at: Socket | None, default: Value = BLACK) -> tuple[float, float, float]:
        if isinstance(self.colour(at, default), Term):
            raise CannotBeRead("a colour that varies")
        return super().constant_colour(at, default)

    def image(self, at: Socket) -> Value:
        """The colour of an Image Texture or an Environment Texture node."""
        if at.socket.identifier == "Alpha":
            raise CannotBeRead("the alpha of an image")
        is_environment = at.node.type == "TEX_ENVIRONMENT"
        vector = self._vector(at, is_environment=is_environment)
        use = image_use(self, at)
        if not isinstance(use, TextureUse):
            return use
        is_sphere = is_environment or at.node.projection == "SPHERE"
        if not is_environment and at.node.projection not in {"FLAT", "SPHERE"}:
            raise CannotBeRead("an image in a box or a tube")
        placed = _placed(use, vector, is_sphere=is_sphere, is_environment=is_environment)
        self._placed.append(placed)
        self._vectors.append(vector)
        return self.program.texture(use, str(len(self._placed) - 1), (1, 0, 0, 0, 1, 0, 0, 0, 1))

    def _vector(self, at: Socket, *, is_environment: bool) -> Vector:
        if own_matrix(at.node) != Matrix.Identity(4):
            raise CannotBeRead("an image with a mapping of its own")
        socket = at.input("Vector")
        if socket.is_connected():
            return read_vector(self, self._light, socket)
        if is_environment:
            raise CannotBeRead("without a vector it sees the light's position")
        return uv_of_light(self._light, at.node.bl_label)

    def texture(self, colour: AffineColour, world_from_light: NDArray[np.float64]) -> LightTexture | None:
        """Of one instance of the light; ``world_from_light``: (4, 4)."""
        if colour.texture is None:
            return None
        index = int(self.program.uv_map(colour.texture))
        origin, placed = self._vectors[index].origin, self._placed[index]
        return LightTexture(
            use=placed.use,
            projection=placed.projection,
            follows_normal=origin is not None and origin.start is not Start.DIRECTION,
            axes_from_world=(origin.frame if origin else Frame.WORLD).axes_from_world(world_from_light[:3, :3]),
            place_from_axes=placed.place_from_axes,
            uv_from_projected=placed.uv_from_projected,
            offset=tuple(float(channel) for channel in colour.offset),
            gain=colour.gain,
        )


def _placed(use: TextureUse, vector: Vector, *, is_sphere: bool, is_environment: bool) -> LightTexture:
    """Without the frame of the light. Raises CannotBeRead."""
    x, y, z = vector.ratios
    if vector.origin is not None and vector.origin.start is Start.SPHERE:
        if is_sphere:
            raise CannotBeRead("a sphere of spherical coordinates")
        uv_matrix = np.array([part.numerator(_ONE)[[0, 1, 3]] for part in (x, y)] + [np.array([0.0, 0.0, 1.0])])
        return LightTexture(use=use, projection=LightProjection.SPHERE, uv_from_projected=uv_matrix)
    if is_sphere:
        rows = [part.numerator(_ONE) for part in (x, y, z)]
        # An environment's longitude starts a quarter turn from that of an image's sphere.
        rows = [rows[1], rows[0], rows[2]] if is_environment else [2.0 * row - _ONE for row in rows]
        return LightTexture(use=use, projection=LightProjection.SPHERE, place_from_axes=np.array(rows))
    below = next((part.below for part in (x, y) if not part.is_constant), _ONE)
    rows = [part.numerator(below) for part in (x, y)]
    projection = LightProjection.DIRECT if np.array_equal(below, _ONE) else LightProjection.PERSPECTIVE
    return LightTexture(use=use, projection=projection, place_from_axes=np.array([*rows, below]))


_ONE = np.array([0.0, 0.0, 0.0, 1.0])


def read_gobo(
    data: bpy.types.Light, images: ImageReader, reports: Reports, culprit: str, world_from_light: NDArray[np.float64]
) -> LightTexture | None:
    """The light's own property, of one that is no area light."""
    use = gobo_use(data, images, reports, culprit)
    if use is None:
        return None
    settings = data.tyndall
    share = settings.gobo_strength
    blend = {"offset": (1.0 - share,) * 3, "gain": np.eye(3) * share}
    if data.type == "SUN":
        return LightTexture(use=use, width_m=settings.gobo_size_m, centre_m=tuple(settings.gobo_offset_m), **blend)
    if data.type == "SPOT":
        placed = _placed(use, spot_coordinates(data.spot_size), is_sphere=False, is_environment=False)
        return LightTexture(
            use=use,
            projection=placed.projection,
            axes_from_world=Frame.LIGHT.axes_from_world(world_from_light[:3, :3]),
            place_from_axes=placed.place_from_axes,
            **blend,
        )
    return LightTexture(
        use=TextureUse(image=use.image, extension=Extension.REPEAT),
        projection=LightProjection.SPHERE,
        follows_normal=True,
        axes_from_world=Frame.LIGHT.axes_from_world(world_from_light[:3, :3]),
        **blend,
    )


def gobo_use(data: bpy.types.Light, images: ImageReader, reports: Reports, culprit: str) -> TextureUse | None:
    """``data`` is evaluated; its pointer is not read: it may outlive what it points to."""
    image = data.original.tyndall.gobo_image
    if image is None:
        return None
    if image.size[0] * image.size[1] == 0:
        place = image.filepath or image.source.lower()
        reports.add(culprit, f'its gobo, image "{image.name}", is left out: it is missing or has no pixels ({place})')
        return None
    read = images.read(image, reports, culprit, associated=True)
    return TextureUse(image=read, extension=EXTENSIONS[data.tyndall.gobo_extension])
