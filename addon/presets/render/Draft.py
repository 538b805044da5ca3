# SPDX-License-Identifier: GPL-3.0-or-later
import bpy

settings = bpy.context.scene.tyndall
settings.pixel_samples = 4
settings.noise_threshold = 0.02
settings.shafts.method = "SHADOW_MAP"
settings.shafts.error_target = 0.01
settings.shafts.resolution = 0
settings.shafts.light_samples = 4
settings.shafts.world_samples = 16
settings.shafts.lens_steps = 4
