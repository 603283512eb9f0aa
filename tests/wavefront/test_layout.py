# SPDX-License-Identifier: Apache-2.0
# Copyright the hdWavefront authors
"""What C++ and GLSL share is laid out alike in both: frame constants, bindings, registries, record sizes."""

from __future__ import annotations

import re
import shutil
import struct
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
SHARED = ROOT / "wavefront" / "shared"
KERNELS = ROOT / "wavefront" / "kernels"


def registry(name: str, macro: str) -> list[list[str]]:
    text = (SHARED / name).read_text()
    rows = re.findall(rf"^{macro}\((.*)\)$", text, re.M)
    assert rows and len(rows) == len(re.findall(rf"^{macro}\(", text, re.M)), "a row that this pattern does not read"
    return [re.findall(r'"[^"]*"|[^,\s][^,]*', row) for row in rows]


def words(spirv: bytes):
    """(opcode, operands) of every instruction."""
    data = struct.unpack(f"<{len(spirv) // 4}I", spirv)
    i = 5
    while i < len(data):
        count = data[i] >> 16
        yield data[i] & 0xFFFF, data[i + 1 : i + count]
        i += count


def text_of(operands) -> str:
    return struct.pack(f"<{len(operands)}I", *operands).split(b"\0")[0].decode()


@pytest.fixture(scope="module")
def new_path(tmp_path_factory) -> bytes:
    """SPIR-V of a kernel that uses the frame constants, compiled as the build does."""
    compiler = shutil.which("glslangValidator") or shutil.which("glslang")
    assert compiler, "glslangValidator is missing: install glslang-tools"
    out = tmp_path_factory.mktemp("spirv") / "new_path.spv"
    includes = [f"-I{KERNELS}", f"-I{ROOT / 'wavefront'}"]
    source = KERNELS / "new_path.comp"
    subprocess.run([compiler, "--quiet", "-V", "--target-env", "vulkan1.3", *includes, "-o", out, source], check=True)
    return out.read_bytes()


def test_frame_constants_have_the_offsets_of_cpp(new_path, tmp_path):
    """OpMemberDecorate Offset of every member, against offsetof in a program that the C++ compiler builds."""
    op_name, op_member_name, op_member_decorate, offset_decoration = 5, 6, 72, 35
    names, members, offsets = {}, {}, {}
    for op, args in words(new_path):
        if op == op_name:
            names[args[0]] = text_of(args[1:])
        elif op == op_member_name:
            members[args[0], args[1]] = text_of(args[2:])
        elif op == op_member_decorate and args[2] == offset_decoration:
            offsets[args[0], args[1]] = args[3]
    types = [t for t, name in names.items() if name == "FrameConstants" and (t, 0) in offsets]
    assert types, "no struct FrameConstants with offsets in the SPIR-V"
    in_spirv = {members[t, m]: offset for (t, m), offset in offsets.items() if t == types[0]}

    program = tmp_path / "offsets.cpp"
    program.write_text(
        '#include <cstddef>\n#include <cstdio>\n#include "wavefront/shared/frame_constants.h"\n'
        "using wavefront::layout::FrameConstants;\nint main() {\n"
        + "".join(f'  std::printf("{name} %zu\\n", offsetof(FrameConstants, {name}));\n' for name in in_spirv)
        + '  std::printf("size %zu\\n", sizeof(FrameConstants));\n}\n'
    )
    compiler = shutil.which("c++") or shutil.which("g++") or shutil.which("clang++")
    assert compiler, "a C++ compiler is missing"
    subprocess.run([compiler, "-std=c++20", f"-I{ROOT}", "-o", tmp_path / "offsets", program], check=True)
    printed = subprocess.run([tmp_path / "offsets"], check=True, capture_output=True, text=True).stdout
    in_cpp = {name: int(value) for name, value in (line.split() for line in printed.splitlines())}
    size = in_cpp.pop("size")
    assert in_spirv == in_cpp
    body = (SHARED / "frame_constants.h").read_text().split("struct FrameConstants {")[1].split("};")[0]
    declared = re.findall(r"\b(?:vec4|float|uint)\s+([\w,\s]+);", re.sub(r"//.*", "", body))
    assert set(in_spirv) == {name.strip() for group in declared for name in group.split(",")}
    assert size == max(in_spirv.values()) + 4, "a hole at the end"
    assert size <= 16384, "the smallest uniform range that Vulkan promises"


def glsl_bindings() -> dict[int, tuple[str, str]]:
    """number -> (kind, element) of lib/bindings.glsl."""
    text = (KERNELS / "lib" / "bindings.glsl").read_text()
    found: dict[int, tuple[str, str]] = {}
    for number, rest in re.findall(r"binding = (\d+)(?:, scalar)?\) (.*)", text):
        assert int(number) not in found, f"binding {number} twice"
        if "textureBuffer" in rest:
            found[int(number)] = ("Texel", "uint" if "utextureBuffer" in rest else "float")
        else:
            found[int(number)] = ("Uniform" if rest.startswith("uniform") else "Storage", "")
    return found


def test_bindings_agree():
    rows = {int(number): kind for _, number, kind in registry("bindings.def", "WAVEFRONT_BINDING")}
    in_glsl = glsl_bindings()
    # The numeric type of a format is what the kernels declare.
    types = {
        "Uint": ("Texel", "uint"),
        "Float": ("Texel", "float"),
        "Storage": ("Storage", ""),
        "Uniform": ("Uniform", ""),
    }
    assert {n: types[re.sub("^(R|Rg|Rgba)32", "", kind)] for n, kind in rows.items()} == in_glsl
    assert sorted(rows) == list(range(len(rows)))
    counted = [kind for kind, _ in in_glsl.values()]
    assert counted.count("Storage") <= 32 and counted.count("Texel") <= 64, "limits of lavapipe 22.3.6"


NOT_OF_A_RENDER = ["cast_rays", "count_ray_fetches"]  # scheduler/ray_caster.cpp, for the benchmark


def test_every_kernel_has_its_file_and_every_file_its_row():
    files = [row[1].strip('"') for row in registry("kernels.def", "WAVEFRONT_KERNEL")]
    assert len(set(files)) == len(files)
    assert sorted([*files, *NOT_OF_A_RENDER]) == sorted(path.stem for path in KERNELS.glob("*.comp"))
    for path in KERNELS.glob("*.comp"):
        head = path.read_text()[:1500]
        for word in ("Reads", "Writes", "Runs "):
            assert word.lower() in head.lower(), f"{path.name} does not say what it {word}"


def test_path_state_is_contiguous_and_fits():
    rows = registry("path_state.def", "WAVEFRONT_PATH_CHUNK")
    indices = [int(row[1]) for row in rows]
    assert indices == list(range(len(rows)))
    assert len(rows) * 16 * 524288 <= 128 << 20, "512K paths fit one storage binding of lavapipe"


def constants(name: str) -> dict[str, int]:
    found = re.findall(r"^WF_CONST\((\w+), (0x[0-9a-f]+|\d+)u\)", (SHARED / name).read_text(), re.M)
    assert found
    assert len({key for key, _ in found}) == len(found), "a constant twice"
    return {key: int(value, 0) for key, value in found}


def test_queues_fit_their_place_in_the_counters():
    rows = registry("queues.def", "WAVEFRONT_QUEUE")
    assert [int(row[1]) for row in rows] == list(range(len(rows)))
    c = constants("counters_layout.h")
    others = [
        c[k]
        for k in ("kPathsDoneLo", "kPathsDoneHi", "kSegmentsLo", "kSegmentsHi", "kIterations", "kActivePaths")
        if k in c
    ]
    first, last = c["kQueueBase"], c["kQueueBase"] + c["kQueueStride"] * len(rows)
    assert all(not first <= at < last for at in others)
    assert max([last, *(at + 1 for at in others)]) <= c["kBucketBase"]
    assert c["kQueuePeak"] < c["kQueueStride"] and c["kBucketItemsHi"] < c["kBucketStride"]
    # Indirect arguments start at multiples of four bytes and do not overlap their neighbours.
    assert c["kQueueArgs"] + 3 <= c["kQueueItemsLo"] and c["kBucketArgs"] + 3 <= c["kBucketItemsLo"]
    flags = [c[k] for k in c if k.startswith("kError") and k != "kErrorFlags"]
    assert all(f & (f - 1) == 0 for f in flags) and len(set(flags)) == len(flags)


def test_item_arrays_are_distinct():
    c = constants("counters_layout.h")
    assert sorted([c["kItemsKeys"], c["kItemsSorted"], c["kItemsQueues"]]) == [0, 1, 2]
    indices = [int(row[1]) for row in registry("queues.def", "WAVEFRONT_QUEUE")]
    assert indices == list(range(len(indices)))  # one array each, from kItemsQueues on


def test_scene_records_are_as_long_in_both_languages():
    c = constants("scene_layout.h")
    light_table = (ROOT / "wavefront/scene/light_table.cpp").read_text()
    # The light record: three matrices' rows count three each.
    pushes = re.findall(r"table\.records\.(push_back|insert)\(", light_table)
    assert sum(1 if p == "push_back" else 3 for p in pushes) == c["kLightTexels"]
    commit = (ROOT / "wavefront/scene/scene_commit.cpp").read_text()
    highest = max(int(n) for n in re.findall(r"\bwords\[(\d+)\]", commit))
    assert highest < 4 * c["kInstanceTexels"]
    bvh = (ROOT / "wavefront/scene/bvh/bvh.h").read_text()
    for name, texels in (("BvhNode4", "kBvhNodeTexels"), ("TriangleRecord", "kTriangleTexels")):
        size = re.search(rf"static_assert\(sizeof\({name}\) == ([^)]*?)[,)]", bvh)
        assert size, f"bvh.h does not assert the size of {name}"
        factors = [
            int(n) if n.isdigit() else c[n.split("::")[-1]] for n in re.split(r"\s*\*\s*", size.group(1).strip())
        ]
        product = 1
        for f in factors:
            product *= f
        assert product == 16 * c[texels]
    kinds = [c[k] for k in ("kKindRect", "kKindDisk", "kKindSphere", "kKindCylinder")]
    types = [c[k] for k in ("kLightRect", "kLightDisk", "kLightSphere", "kLightCylinder")]
    assert [k - 1 for k in kinds] == types
    enum = re.search(r"enum class LightType : uint32_t \{ (.*?) \}", (ROOT / "wavefront/scene.h").read_text()).group(1)
    for i, name in enumerate(enum.split(", ")):
        assert c[f"kLight{name}"] == i
    enum = re.search(r"enum class Interpolation : uint8_t \{ (.*?) \}", (ROOT / "wavefront/scene.h").read_text()).group(
        1
    )
    for i, name in enumerate(enum.split(", ")):
        assert c[f"kInterp{name}"] == i
    wraps = re.search(r"enum class WrapMode : uint32_t \{ (.*?) \}", (ROOT / "wavefront/scene.h").read_text()).group(1)
    glsl = (KERNELS / "lib/textures.glsl").read_text()
    for i, name in enumerate(wraps.split(", ")):
        assert f"kWrap{name} = {i}u" in glsl
