# SPDX-License-Identifier: GPL-3.0-or-later
import bpy

air = bpy.context.scene.tyndall.heterogeneity
air.is_enabled = True
air.amount = 1.0
air.intensity = 1.2
air.level = 0.5
air.scale_m = 1.0
air.octaves = 5
air.persistence = 0.5
air.contrast = 3.0
air.wind_m_per_s = (0.05, 0.0, 0.6)
