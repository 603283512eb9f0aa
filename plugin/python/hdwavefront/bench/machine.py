# SPDX-License-Identifier: Apache-2.0
# Copyright the hdWavefront authors
"""Where the figures come from: device, driver, processor, system; and what the device's memory can do."""

from __future__ import annotations

import os
import platform
from typing import Any

from .measure import cores


def processor() -> str:
    try:
        with open("/proc/cpuinfo", encoding="utf-8") as file:
            for line in file:
                if line.startswith("model name"):
                    return line.split(":", 1)[1].strip()
    except OSError:
        pass
    return platform.processor() or platform.machine()


def describe(device: str) -> dict[str, Any]:
    """Measures the device's copy bandwidth; RuntimeError where there is no such device."""
    from ..api import core

    copy = core().measure_copy_bandwidth(device)
    return {
        "device": copy["name"],
        "driver": copy["driver"],
        "deviceType": copy["type"],
        "isProcessor": copy["type"] == "CPU",
        "copyBytesPerSecond": copy["bytesPerSecond"],
        "processor": processor(),
        "cores": cores(),
        "system": f"{platform.system()} {platform.release()}",
        "loadAverage": os.getloadavg()[0],
        "build": core().build_facts(),
    }


def lines(machine: dict[str, Any]) -> list[str]:
    return [
        f"Device     {machine['device']}",
        f"Driver     {machine['driver']}",
        f"Machine    {machine['processor']}, {machine['cores']} cores, {machine['system']}; load before the start "
        f"{machine['loadAverage']:.1f}",
        f"Memory     {machine['copyBytesPerSecond'] / 1e9:.1f} GB/s read and written by a copy on the device",
        f"hdWavefront {machine['build']['version']}, {machine['build']['build_type']} build, "
        f"{machine['build']['compiler']}",
    ]
