# SPDX-License-Identifier: GPL-3.0-or-later
import bpy

air = bpy.context.scene.tyndall.heterogeneity
air.is_enabled = True
air.amount = 1.0
air.intensity = 1.0
air.level = 1.5
air.scale_m = 5.0
air.octaves = 4
air.persistence = 0.4
air.contrast = 2.5
air.wind_m_per_s = (0.2, 0.05, 0.0)
