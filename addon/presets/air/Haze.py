# SPDX-License-Identifier: GPL-3.0-or-later
import bpy

air = bpy.context.scene.tyndall.heterogeneity
air.is_enabled = True
air.amount = 0.8
air.intensity = 1.0
air.level = 0.5
air.scale_m = 6.0
air.octaves = 3
air.persistence = 0.45
air.contrast = 2.2
air.wind_m_per_s = (0.1, 0.0, 0.0)
