# SPDX-License-Identifier: GPL-3.0-or-later
import bpy

settings = bpy.context.scene.tyndall
settings.pixel_samples = 32
settings.noise_threshold = 0.005
settings.shafts.method = "EPIPOLAR"
settings.shafts.error_target = 0.0005
settings.shafts.resolution = 0
settings.shafts.light_samples = 64
settings.shafts.world_samples = 256
settings.shafts.lens_steps = 32
