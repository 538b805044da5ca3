# SPDX-License-Identifier: GPL-3.0-or-later
import bpy

air = bpy.context.scene.tyndall.heterogeneity
air.is_enabled = True
air.amount = 0.7
air.intensity = 1.0
air.level = 0.0
air.scale_m = 0.6
air.octaves = 6
air.persistence = 0.75
air.contrast = 2.0
air.wind_m_per_s = (0.05, 0.0, -0.03)
