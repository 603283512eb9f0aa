# SPDX-License-Identifier: Apache-2.0
# Copyright the hdWavefront authors
"""Colour by OpenColorIO: the configuration, conversions into the rendering space, displays and views."""
