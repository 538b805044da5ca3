# SPDX-License-Identifier: GPL-3.0-or-later
"""What colours and arrays are here."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Rgb = tuple[float, float, float]
FloatArray = NDArray[np.float32]
