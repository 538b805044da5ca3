# SPDX-License-Identifier: GPL-3.0-or-later
"""``python -m tyndall``."""

import sys

from .command_line import main

sys.exit(main())
