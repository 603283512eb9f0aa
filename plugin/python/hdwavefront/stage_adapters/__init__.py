# SPDX-License-Identifier: Apache-2.0
# Copyright the hdWavefront authors
"""From a USD stage to the delegate's updates: what UsdImaging does in the Hydra host. One module per schema."""

# USD's tokens that the command line checks as well, before pxr is loaded.
PURPOSES = ("default", "render", "proxy", "guide")
WINDOW_POLICIES = (  # UsdRenderSettings' aspectRatioConformPolicy
    "expandAperture",
    "cropAperture",
    "adjustApertureWidth",
    "adjustApertureHeight",
    "adjustPixelAspectRatio",
)
