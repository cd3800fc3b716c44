# SPDX-License-Identifier: BSD-3-Clause
"""``python3 -m surfacesynthesis``"""

from .command_line import main

if __name__ == "__main__":
    raise SystemExit(main())
