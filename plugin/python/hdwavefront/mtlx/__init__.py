# SPDX-License-Identifier: Apache-2.0
# Copyright the hdWavefront authors
""".mtlx files in stages, the same with every pxr.

A pxr without UsdMtlx (the usd-core wheel) opens a stage with an empty prim in a .mtlx reference's place; one with it
may have no MaterialX libraries (then its materials are empty), and drops a document's own colour space. So each file is
converted here, by the `materialx` package, to an anonymous layer that holds what UsdMtlx would make of it at the same
paths, and takes the file's place. Where that cannot be done, a diagnostic says which materials are missing and why.
"""

from .convert import convert_file
from .references import replace_references

__all__ = ["convert_file", "replace_references"]
