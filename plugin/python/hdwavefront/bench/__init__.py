# SPDX-License-Identifier: Apache-2.0
# Copyright the hdWavefront authors
"""`hdwavefront bench`: scenes of the project's own, and what rendering them costs."""
