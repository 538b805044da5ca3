# SPDX-License-Identifier: GPL-3.0-or-later
import bpy

air = bpy.context.scene.tyndall.heterogeneity
air.is_enabled = True
air.amount = 1.0
air.intensity = 1.3
air.level = 0.0
air.scale_m = 8.0
air.octaves = 6
air.persistence = 0.6
air.contrast = 3.0
air.wind_m_per_s = (7.0, 2.0, 0.0)
