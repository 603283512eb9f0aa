# SPDX-License-Identifier: Apache-2.0
# Copyright the hdWavefront authors
"""Other renderers on the same scenes, where they are installed."""
