# SPDX-License-Identifier: Apache-2.0
# Copyright the hdWavefront authors
"""The walls of the house: who may include and import whom, licence lines, no machine's paths in the tree.

Each rule is a function from a tree to a list of breaches. It is run on this checkout, and on small trees that break
it, so that a rule that can no longer fail is noticed.
"""

from __future__ import annotations

import ast
import re
import subprocess
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent
CPP = {".h", ".cpp"}
SHADERS = {".glsl", ".comp", ".def"}
INCLUDE = re.compile(r'^\s*#\s*include\s*([<"])([^>"]+)[>"]', re.MULTILINE)
SOURCES = CPP | SHADERS | {".py", ".cmake", ".sh"}


def tracked(root: Path) -> list[Path]:
    """Files of the tree, relative: git's (committed, staged or not ignored) where it is a checkout, else all sources."""
    if (root / ".git").exists():
        command = ["git", "-C", str(root), "ls-files", "--cached", "--others", "--exclude-standard", "-z"]
        names = subprocess.run(command, check=True, capture_output=True, text=True).stdout.split("\0")
        return sorted(Path(n) for n in names if n and (root / n).is_file())
    names = (p.relative_to(root) for p in root.rglob("*") if p.is_file())
    return sorted(p for p in names if p.parts[0] not in ("build", ".venv") and "__pycache__" not in p.parts)


def text_of(path: Path) -> str:
    return path.read_text(encoding="utf-8", errors="replace")


def room_of(path: Path) -> str:
    """The room that a file stands in: `wavefront`, `materialgen`, `delegate`, `plugin/python`, `plugin/hydra`, ..."""
    parts = path.parts
    return "/".join(parts[:2]) if parts[0] == "plugin" and len(parts) > 2 else parts[0]


def includes(root: Path, suffixes: set[str]) -> Iterator[tuple[Path, str]]:
    """(file, what it includes) with paths from the root: a name beside the file is resolved to it."""
    for path in tracked(root):
        if path.suffix not in suffixes:
            continue
        for _, name in INCLUDE.findall(text_of(root / path)):
            beside = path.parent / name
            if (root / name).is_file() or not (root / beside).is_file():
                yield path, name
            else:
                yield path, str(Path(*[p for p in beside.parts if p != "."]))


def is_wavefront_facade(name: str) -> bool:
    """wavefront's root headers, and base/, which everyone may include."""
    parts = Path(name).parts
    return len(parts) == 2 or parts[1] == "base"


def layer_breaches(root: Path) -> list[str]:
    """C++: plugin -> delegate -> {wavefront's root headers, materialgen}; these two do not see each other."""
    rooms = ("wavefront", "materialgen", "delegate", "plugin", "tests", "testenv")
    may_include = {
        "wavefront": ("wavefront",),
        "materialgen": ("materialgen", "wavefront/base"),
        "delegate": ("delegate", "materialgen", "wavefront"),
        "plugin/python": ("plugin/python", "delegate", "materialgen", "wavefront"),
        "plugin/hydra": ("plugin/hydra", "delegate", "materialgen", "wavefront"),
        "plugin/bench": ("plugin/bench", "delegate/capture", "materialgen", "wavefront"),
    }
    breaches = []
    for path, name in includes(root, CPP):
        room = room_of(path)
        if room not in may_include or not name.startswith(tuple(r + "/" for r in rooms)):
            continue
        allowed = any(name.startswith(r + "/") for r in may_include[room])
        if allowed and room != "wavefront" and name.startswith("wavefront/"):
            allowed = is_wavefront_facade(name)
        if not allowed:
            breaches.append(f"{path} includes {name}")
    return breaches


def vulkan_breaches(root: Path) -> list[str]:
    """vulkan.h and volk only under wavefront/vulkan (and in tests of it); none in wavefront's root headers."""
    vulkan = re.compile(r"^(vulkan/|vulkan\.h|volk(/|\.h)|vk_)")
    may = ("wavefront/vulkan/", "tests/")
    return [
        f"{path} includes {name}"
        for path, name in includes(root, CPP)
        if vulkan.match(name) and not str(path).startswith(may)
    ]


def pxr_breaches(root: Path) -> list[str]:
    """pxr/ only under plugin/hydra and in its tests."""
    return [
        f"{path} includes {name}"
        for path, name in includes(root, CPP | SHADERS)
        if name.startswith("pxr/") and not str(path).startswith(("plugin/hydra/", "tests/hydra/"))
    ]


def foreign_breaches(root: Path) -> list[str]:
    """MaterialX and glslang only in materialgen, Python bindings only in plugin/python, OpenSubdiv only in delegate."""
    owners = {
        "MaterialX": ("materialgen",),
        "glslang": ("materialgen",),
        "SPIRV": ("materialgen",),
        "spirv-tools": ("materialgen",),
        "nanobind": ("plugin/python",),
        "Python.h": ("plugin/python",),
        "opensubdiv": ("delegate",),
    }
    breaches = []
    for path, name in includes(root, CPP):
        first = name.split("/")[0]
        if first.startswith("MaterialX"):
            first = "MaterialX"
        if first in owners and room_of(path) not in (*owners[first], "tests"):
            breaches.append(f"{path} includes {name}")
    return breaches


def shader_breaches(root: Path) -> list[str]:
    """GLSL stands in wavefront and includes only what stands there."""
    breaches = []
    for path, name in includes(root, SHADERS):
        found = [b for b in ("", "wavefront/", "wavefront/kernels/") if (root / (b + name)).is_file()]
        if room_of(path) == "wavefront" and found and not (found[0] + name).startswith("wavefront/"):
            breaches.append(f"{path} includes {name}")
    return breaches


def python_breaches(root: Path) -> list[str]:
    """Our package only under plugin/python (and in tests), Python's `pxr` in both plugins."""
    breaches = []
    for path in tracked(root):
        if path.suffix != ".py" or room_of(path) in ("tests", "testenv", "plugin/python"):
            continue
        for node in ast.walk(ast.parse(text_of(root / path), str(path))):
            names = []
            if isinstance(node, ast.Import):
                names = [alias.name for alias in node.names]
            elif isinstance(node, ast.ImportFrom) and node.module and node.level == 0:
                names = [node.module]
            banned = ("hdwavefront",) if room_of(path) == "plugin/hydra" else ("pxr", "hdwavefront")
            breaches += [f"{path} imports {name}" for name in names if name.split(".")[0] in banned]
    return breaches


def licence_breaches(root: Path) -> list[str]:
    """Every source says its licence within its first lines."""
    return [
        f"{path} has no SPDX line"
        for path in tracked(root)
        if (path.suffix in SOURCES or path.name == "CMakeLists.txt" or path.name == "run")
        and "SPDX-License-Identifier: Apache-2.0" not in "\n".join(text_of(root / path).splitlines()[:5])
        and text_of(root / path).strip()
    ]


def machine_path_breaches(root: Path) -> list[str]:
    """No path of the machine that a file was written on."""
    # Assembled, so that this file does not match itself.
    tops = "|".join(("work", "root", "farm", "tmp", r"home/\w+", r"Users/\w+"))
    machine = re.compile(r"(?<![\w.$}{)/-])/(" + tops + r")/[\w.]")
    skip = {".exr", ".png", ".jpg", ".hdr", ".usdc", ".usdz", ".bin"}
    breaches = []
    for path in tracked(root):
        if path.suffix in skip:
            continue
        for number, line in enumerate(text_of(root / path).splitlines(), 1):
            if machine.search(line):
                breaches.append(f"{path}:{number}: {line.strip()[:120]}")
    return breaches


Rule = Callable[[Path], list[str]]
SPDX = "// SPDX-License-Identifier: Apache-2.0\n"

# (rule, file, its text): each breaks the rule and must be found.
BROKEN: list[tuple[Rule, str, str]] = [
    (layer_breaches, "wavefront/scene/a.cpp", '#include "materialgen/network.h"\n'),
    (layer_breaches, "wavefront/scene/a.cpp", '#include "delegate/x.h"\n'),
    (layer_breaches, "materialgen/a.cpp", '#include "wavefront/renderer.h"\n'),
    (layer_breaches, "materialgen/a.cpp", '#include "wavefront/scene/x.h"\n'),
    (layer_breaches, "delegate/prims/a.cpp", '#include "wavefront/scene/bvh.h"\n'),
    (layer_breaches, "delegate/prims/a.cpp", "#  include <plugin/python/src/x.h>\n"),
    (layer_breaches, "plugin/python/src/a.cpp", '#include "wavefront/vulkan/device.h"\n'),
    (layer_breaches, "plugin/hydra/a.cpp", '#include "plugin/python/src/x.h"\n'),
    (layer_breaches, "plugin/bench/a.cpp", '#include "delegate/render_delegate.h"\n'),
    (layer_breaches, "plugin/bench/a.cpp", '#include "wavefront/vulkan/device.h"\n'),
    (vulkan_breaches, "wavefront/scheduler/a.cpp", "#include <vulkan/vulkan.h>\n"),
    (vulkan_breaches, "wavefront/renderer.h", "#include <volk.h>\n"),
    (vulkan_breaches, "delegate/a.cpp", '#include "vulkan.h"\n'),
    (pxr_breaches, "delegate/a.h", "#include <pxr/base/gf/matrix4d.h>\n"),
    (pxr_breaches, "plugin/python/src/a.h", '#include "pxr/usd/usd/stage.h"\n'),
    (pxr_breaches, "tests/delegate/a.cpp", "#include <pxr/pxr.h>\n"),
    (foreign_breaches, "delegate/a.cpp", "#include <MaterialXCore/Document.h>\n"),
    (foreign_breaches, "wavefront/a.cpp", "#include <glslang/Public/ShaderLang.h>\n"),
    (foreign_breaches, "delegate/a.cpp", "#include <nanobind/nanobind.h>\n"),
    (foreign_breaches, "wavefront/scene/a.cpp", "#include <opensubdiv/far/topologyRefiner.h>\n"),
    (shader_breaches, "wavefront/kernels/a.comp", '#include "materialgen/x.glsl"\n'),
    (python_breaches, "resources/make.py", "def f():\n    from pxr.Usd import Stage\n"),
    (python_breaches, "plugin/hydra/blender/addon.py", "import hdwavefront\n"),
    (python_breaches, "materialgen/make.py", "import hdwavefront._core\n"),
    (licence_breaches, "wavefront/a.cpp", "int x;\n"),
    (licence_breaches, "tests/test_a.py", "x = 1\n"),
    (machine_path_breaches, "README.md", "see " + "/wo" + "rk/main/run\n"),
    (machine_path_breaches, "tests/test_a.py", "x = '" + "/ho" + "me/someone/stage.usda'\n"),
]

# What the rules must let through.
SOUND = {
    "wavefront/renderer.h": SPDX + '#include <vector>\n#include "wavefront/base/result.h"\n#include "scene.h"\n',
    "wavefront/scene.h": SPDX,
    "wavefront/base/result.h": SPDX,
    "wavefront/vulkan/device.cpp": SPDX + '#include <volk.h>\n#include "device.h"\n',
    "wavefront/vulkan/device.h": SPDX,
    "wavefront/kernels/logic.comp": SPDX + '#include "lib/queue.glsl"\n#include "shared/bindings.h"\n',
    "wavefront/kernels/lib/queue.glsl": SPDX,
    "wavefront/shared/bindings.h": SPDX,
    "materialgen/network.h": SPDX + '#include "wavefront/base/diagnostics.h"\n#include <MaterialXCore/Node.h>\n',
    "materialgen/x.glsl": SPDX,
    "delegate/render.cpp": SPDX + '#include "wavefront/renderer.h"\n#include "materialgen/network.h"\n',
    "plugin/python/src/module.cpp": SPDX + '#include <nanobind/nanobind.h>\n#include "delegate/render.h"\n',
    "plugin/python/hdwavefront/stage.py": "# SPDX-License-Identifier: Apache-2.0\nfrom pxr import Usd\n",
    "plugin/hydra/blender/addon.py": "# SPDX-License-Identifier: Apache-2.0\nfrom pxr import Plug\n",
    "plugin/hydra/delegate.cpp": SPDX + "#include <pxr/imaging/hd/renderDelegate.h>\n",
    "tests/wavefront/test_device.cpp": SPDX + '#include <volk.h>\n#include "wavefront/vulkan/device.h"\n',
    "README.md": "https://example.org/work/in/progress and build/root/x and /usr/share\n",
}

RULES: list[Rule] = list(dict.fromkeys(rule for rule, _, _ in BROKEN))


def write_tree(root: Path, files: dict[str, str]) -> None:
    for name, text in files.items():
        path = root / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)


@pytest.mark.parametrize("rule", RULES, ids=lambda rule: rule.__name__)
def test_the_house_keeps(rule: Rule) -> None:
    assert rule(ROOT) == []


@pytest.mark.parametrize("rule", RULES, ids=lambda rule: rule.__name__)
def test_a_sound_tree_passes(rule: Rule, tmp_path: Path) -> None:
    write_tree(tmp_path, SOUND)
    assert rule(tmp_path) == []


@pytest.mark.parametrize(
    ("rule", "name", "text"), BROKEN, ids=[f"{rule.__name__}-{i}" for i, (rule, _, _) in enumerate(BROKEN)]
)
def test_a_breach_is_found(rule: Rule, name: str, text: str, tmp_path: Path) -> None:
    write_tree(tmp_path, SOUND)
    write_tree(tmp_path, {name: text})
    breaches = rule(tmp_path)
    assert len(breaches) == 1 and breaches[0].startswith(name)


def test_this_checkout_is_seen() -> None:
    """The rules above read something: an empty listing would pass them all."""
    names = {str(path) for path in tracked(ROOT)}
    assert {"run", "CMakeLists.txt", "wavefront/renderer.h", "tests/test_house.py"} <= names
