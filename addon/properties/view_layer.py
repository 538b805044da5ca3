# SPDX-License-Identifier: GPL-3.0-or-later
"""``view_layer.tyndall``: passes that Blender has no switch for."""

from bpy.props import BoolProperty
from bpy.types import Context, PropertyGroup

from .tagging import OVERRIDABLE


def update_passes(group: "TyndallViewLayerSettings", _context: Context) -> None:
    """Let the compositor's Render Layers nodes show the sockets of the passes that are switched on."""
    for view_layer in group.id_data.view_layers:
        view_layer.update_render_passes()


class TyndallViewLayerSettings(PropertyGroup):
    use_pass_shafts: BoolProperty(
        name="Shafts",
        description="Light that media scatter towards the camera, which Combined already contains. "
        "Combined without shafts is Combined minus this. Costs memory only",
        default=False,
        update=update_passes,
        override=OVERRIDABLE,
    )
    use_pass_shafts_visibility: BoolProperty(
        name="Shafts Visibility",
        description="Lit share of each view ray's length in media, mean over the lights: 0 in shadow, 1 in full light. "
        "Costs memory only",
        default=False,
        update=update_passes,
        override=OVERRIDABLE,
    )
    use_pass_sample_count: BoolProperty(
        name="Sample Count",
        description="Share of the pixel's samples that were taken before its noise fell below the threshold",
        default=False,
        update=update_passes,
        override=OVERRIDABLE,
    )
    use_pass_denoising_data: BoolProperty(
        name="Denoising Data",
        description="Normal, albedo and depth of what pixels show, without noise, for the compositor's Denoise node. "
        "Costs memory only",
        default=False,
        update=update_passes,
        override=OVERRIDABLE,
    )
    use_pass_shadow_catcher: BoolProperty(
        name="Shadow Catcher",
        description="What the shadows on shadow catchers leave of a picture that is put behind the render: multiply "
        "it by this. The render itself then shows no caught shadow",
        default=False,
        update=update_passes,
        override=OVERRIDABLE,
    )
    use_pass_transmittance: BoolProperty(
        name="Transmittance",
        description="Share of the light of the surface that media let through to the camera. Costs memory only",
        default=False,
        update=update_passes,
        override=OVERRIDABLE,
    )
