# SPDX-License-Identifier: Apache-2.0
# Copyright the hdWavefront authors
"""The table of functions that references of nodes register themselves in, and what they share."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

Array = Any
Inputs = dict[str, Any]
LEAVES: dict[str, Callable[[Inputs, Any, Any], Any]] = {}


def leaf(*categories: str) -> Callable[[Any], Any]:
    def register(function: Any) -> Any:
        for category in categories:
            LEAVES[category] = function
        return function

    return register


def simple(category: str, function: Callable[..., Array], *names: str) -> None:
    LEAVES[category] = lambda i, d, s: function(*(i[n] for n in names))


def join(*parts: Array) -> Array:
    """Components side by side; what is the same everywhere has one row."""
    rows = max(len(p) for p in parts)
    return np.concatenate([np.broadcast_to(p, (rows, p.shape[1])) for p in parts], axis=1)


def dot(a: Array, b: Array) -> Array:
    return (a * b).sum(-1, keepdims=True)


def normalize(a: Array) -> Array:
    return a / np.linalg.norm(a, axis=-1, keepdims=True)


def wide(scalar: Array, like: Array) -> Array:
    """A scalar against matrices."""
    return scalar[..., None] if like.ndim == 3 and scalar.ndim == 2 else scalar


def blend(i: Inputs, value: Array) -> Array:
    return i["mix"] * value + (1 - i["mix"]) * i["bg"]


def mix(a: Array, b: Array, t: Array) -> Array:
    return a * (1 - t) + b * t


def divide(a: Array, b: Array) -> Array:
    return a @ np.linalg.inv(b) if b.ndim == 3 else a / b
