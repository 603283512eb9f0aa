# SPDX-License-Identifier: Apache-2.0
# Copyright the hdWavefront authors
"""`hdwavefront doctor`: what this installation is made of, and what is wrong with it."""

from __future__ import annotations

import os
import platform
import sys
from collections.abc import Callable

from ..errors import EXIT_FAILED, EXIT_OK, HdWavefrontError


def print_version() -> int:
    from ..api import core

    print(f"hdWavefront {core().__version__}")
    return EXIT_OK


class _Report:
    def __init__(self) -> None:
        self.problems: list[str] = []

    def section(self, title: str, body: Callable[[], None]) -> None:
        print(title)
        try:
            body()
        except (HdWavefrontError, ImportError, RuntimeError, AttributeError, OSError) as error:
            self.problem(f"{title}: {error}")

    def line(self, name: str, value: object) -> None:
        print(f"  {name + ':':<22} {value}")

    def problem(self, text: str) -> None:
        self.problems.append(text)
        print(f"  PROBLEM: {text}")


def doctor() -> int:
    """Exit code 1 where something keeps renders from working."""
    report = _Report()
    report.section("hdWavefront", lambda: _build(report))
    report.section("Devices", lambda: _devices(report))
    report.section("USD", lambda: _usd(report))
    report.section("Hydra plugin", lambda: _hydra(report))
    report.section("Colour", lambda: _color(report))
    report.section("Images", lambda: _images(report))
    print()
    if report.problems:
        print("What is wrong:")
        for problem in report.problems:
            print(f"  - {problem}")
        return EXIT_FAILED
    print("Everything that renders need is there.")
    return EXIT_OK


def _build(report: _Report) -> None:
    from ..api import _DATA_FOLDER, core

    report.line("package", os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
    for name, value in core().build_facts().items():
        report.line(name, value or "none")
    report.line("Python", f"{platform.python_version()} ({sys.executable})")
    report.line("system", f"{platform.system()} {platform.release()} {platform.machine()}")
    libraries = os.path.join(_DATA_FOLDER, "materialx")
    if os.path.isdir(os.path.join(libraries, "stdlib")):
        report.line("MaterialX libraries", libraries)
    else:
        report.problem(f"the MaterialX libraries are missing in {libraries}; install the package again")


def _devices(report: _Report) -> None:
    from ..api import core

    devices = core().list_devices()
    if not devices:
        report.problem("there is no Vulkan device; install a driver (on Debian and Ubuntu: mesa-vulkan-drivers)")
        return
    for index, device in enumerate(devices):
        state = "usable" if device["usable"] else f"not usable: {device['whyNot']}"
        report.line(f"{index}", f"{device['name']} ({device['type']}) - {state}")
        report.line("  driver", device["driver"])
        report.line("  Vulkan", device["apiVersion"])
        report.line("  memory", f"{device['heapBytes'] / 2**30:.1f} GiB")
        for name, value in device.get("details", ()):
            report.line("  " + name, value)
    if not any(d["usable"] for d in devices):
        report.problem("no Vulkan device is usable: " + "; ".join(f"{d['name']}: {d['whyNot']}" for d in devices))
    wish = os.environ.get("HDWAVEFRONT_DEVICE", "")
    if wish:
        report.line("HDWAVEFRONT_DEVICE", wish)
        chosen = [
            device
            for index, device in enumerate(devices)
            if (wish == str(index) if wish.isdecimal() else wish.lower() in device["name"].lower())
        ]
        if not chosen:
            report.problem(f"$HDWAVEFRONT_DEVICE is '{wish}', but no Vulkan device has that index or name")
        elif not any(d["usable"] for d in chosen):
            report.problem(f"$HDWAVEFRONT_DEVICE is '{wish}', which chooses no device that is usable")


def _usd(report: _Report) -> None:
    from ..stage import import_pxr

    usd = import_pxr()
    report.line("OpenUSD", ".".join(str(x) for x in usd.GetVersion()))
    report.line("pxr", os.path.dirname(os.path.dirname(usd.__file__)))


def _hydra(report: _Report) -> None:
    """Its absence is no problem: this host does not need it."""
    from .hydra_plugin import HOW_TO_BUILD, find_hydra_plugin, why_not_loaded

    plugin = find_hydra_plugin()
    if plugin is None:
        report.line("built", f"no plugin is found ({HOW_TO_BUILD})")
        return
    report.line("built", plugin.folder)
    report.line("for OpenUSD", plugin.openusd or "not known")
    try:
        reason = why_not_loaded(plugin)
    except ImportError:
        report.line("loads", "not checked: this pxr has no imaging; run doctor in the Python of that OpenUSD")
        return
    if reason is None:
        report.line("loads", "yes")
    else:
        report.problem(f"the Hydra plugin does not load: {reason}")


def _color(report: _Report) -> None:
    from ..color.manager import ColorManager, ocio_version

    report.line("OpenColorIO", ocio_version())
    colors = ColorManager()
    display, view = colors.display_and_view()
    report.line("configuration", f"{colors.config_name} ({colors.origin})")
    report.line("rendering space", colors.rendering_space)
    report.line("display, view", f"{display}, {view}")


def _images(report: _Report) -> None:
    import OpenImageIO as oiio

    report.line("OpenImageIO", oiio.VERSION_STRING)
    report.line("formats", oiio.get_string_attribute("format_list"))
