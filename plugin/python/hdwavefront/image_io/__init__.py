# SPDX-License-Identifier: Apache-2.0
# Copyright the hdWavefront authors
"""Images by OpenImageIO: textures in, renders out."""
