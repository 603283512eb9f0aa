# SPDX-License-Identifier: Apache-2.0
# Copyright the hdWavefront authors
"""From a USD stage to the delegate's updates: what UsdImaging does in the Hydra host. One module per schema."""
