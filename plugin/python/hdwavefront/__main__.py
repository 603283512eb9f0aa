# SPDX-License-Identifier: Apache-2.0
# Copyright the hdWavefront authors
"""`python -m hdwavefront`: the console command where only the interpreter is known."""

import sys

from .cli.main import main

sys.exit(main())
