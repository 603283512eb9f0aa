# SPDX-License-Identifier: Apache-2.0
# Copyright the hdWavefront authors
"""The command line: `hdwavefront record`, `hdwavefront explain`, `hdwavefront doctor`."""
