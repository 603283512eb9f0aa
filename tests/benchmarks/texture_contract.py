# SPDX-License-Identifier: Apache-2.0
# Copyright the hdWavefront authors
"""`./run bench textures`: what a filtered texture read costs through the renderer's pages, and in other forms.

All ways (textures/README.md) read the same items of the same textures in turn; each result is compared with the value
in double precision first. Times are medians, with half of the range between the quartiles: nanoseconds of one core
where the device is a CPU (other work on the machine counts little then), else of the device; what a kernel without a
read takes is subtracted. Compiling is creation and first dispatch of a kernel with 1, 4 and 16 reads that nobody
compiled before.
"""

from __future__ import annotations

import argparse
import json
import os
import struct
import sys
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent))
if __name__ == "__main__":  # not for the tests that import this. Before the driver is loaded: compiling is measured
    os.environ.setdefault("MESA_SHADER_CACHE_DISABLE", "true")

import kernel_runner  # noqa: E402
import numpy as np  # noqa: E402
from benchmarks import texture_layouts as layouts  # noqa: E402

GROUP = 64
MEMORY = 12 << 30  # the ways stand side by side on the device
RECORDS, TABLE, PAGES, OUT, ITEMS, BYTES, HALFS, PLAIN, LINEAR = 19, 20, 21, 40, 41, 43, 44, 45, 46
FULL = [(1, 256), (8, 256), (64, 256), (1, 2048), (8, 2048), (64, 1024)]


@dataclass(frozen=True)
class Way:
    name: str
    source: str
    exact: bool = True  # filtered in single precision; else by a sampler, whose weights may have 8 bits
    defines: str = ""
    own_dispatch: bool = False  # one dispatch per texture
    only: str = ""  # pattern


NOTHING = Way("no read", "")
WAYS = [
    Way("A  pages, as built", "pages.glsl"),
    Way("A0 pages, look-up per texel", "pages_per_texel.glsl"),
    Way("B1 array pages, sampler", "array_pages.glsl", exact=False, defines="#define HARDWARE_FILTER"),
    Way("B2 array pages, texelFetch", "array_pages.glsl"),
    Way("C  plain descriptor", "plain.glsl", exact=False, own_dispatch=True),
    Way("C8 plain, switch of 8", "plain_switch.glsl", exact=False, only="mixed"),
    Way("D  texel buffer per texture", "buffer.glsl", own_dispatch=True),
]
HEAD = """#version 460
#include "lib/bindings.glsl"
layout(local_size_x = 64) in;
layout(binding = 40) buffer Out { vec4 result[]; };
layout(binding = 41) uniform textureBuffer items;
"""
RUN = """
void main() {
  uint i = gl_GlobalInvocationID.x;
  if (i >= pushWord1) return;
  i += pushBucket;
  vec4 item = texelFetch(items, int(i));
  vec4 sum = vec4(0.0);
  [[dont_unroll]] for (uint r = 0u; r < 4u; ++r) {
    sum += benchRead(floatBitsToUint(item.w), item.xy + vec2(0.25, 0.125) * float(r), item.z);
  }
  result[i] = sum;
}
"""


def source_of(way: Way) -> str:
    if not way.source:
        return "vec4 benchRead(uint id, vec2 uv, float footprint) { return vec4(uv, footprint, float(id)); }\n"
    return f'{way.defines}\n#include "{way.source}"\n'


def bindings_of(way: Way, plain: int = 1) -> list[tuple[int, str, int]]:
    """(binding, kind, array size); the formats of pools that hold either are put in by their reader."""
    tables = [(RECORDS, "rgba32ui", 1), (TABLE, "r32ui", 1)]
    own = {
        "": [],
        "pages.glsl": [*tables, (PAGES, "rgba32ui", 1)],
        "pages_per_texel.glsl": [*tables, (BYTES, "rgba8", 1), (HALFS, "rgba16f", 1)],
        "array_pages.glsl": [*tables, (PAGES, "rgba32ui", 1), (BYTES, "image", 1), (HALFS, "image", 1)],
        "plain.glsl": [(PLAIN, "image", plain)],
        "plain_switch.glsl": [(PLAIN, "image", 8)],
        "buffer.glsl": [*tables, (PAGES, "rgba32ui", 1), (LINEAR, "rgba8", 1)],
    }[way.source]
    return [(OUT, "storage", 1), (ITEMS, "rgba32f", 1), *own]


class Rig:
    """A device with a set of textures in every layout."""

    def __init__(self, textures: layouts.Textures, ways: Sequence[Way]) -> None:
        from _kernel_runner import Bench

        self.bench = Bench(MEMORY)
        self.textures = textures
        self.ways = [NOTHING, *ways]
        spirv = {
            way: kernel_runner.spirv(HEAD + source_of(way) + RUN, include=[HERE / "textures"]) for way in self.ways
        }
        self.programs = {way: self.bench.program(spirv[way], bindings_of(way))[0] for way in self.ways}
        sources = {way.source for way in ways}
        side, texel_format = textures.side, textures.texel_format
        tables = textures.tables
        self.zeros = self.bench.buffer(bytes(64))
        self.records = self.bench.buffer(tables["textureRecords"])
        self.table = self.bench.buffer(tables["pageTable"])
        if "pages.glsl" in sources:
            self.pages = self.bench.buffer(tables["texturePages"])
        if "pages_per_texel.glsl" in sources:
            self.per_texel = [self.bench.buffer(data) for data in layouts.pages_per_texel(textures)]
        if "array_pages.glsl" in sources:
            layers, table = layouts.array_pages(textures)
            count = len(layers) // (layouts.LAYER**2 * (4 if texel_format == "rgba8" else 8))
            self.layers = self.bench.image(layouts.LAYER, layouts.LAYER, count, texel_format, [layers], True)
            self.no_layers = self.bench.image(4, 4, 1, "rgba8", [bytes(64)], True)
            self.layer_table = self.bench.buffer(table)
        levels = [level.tobytes() for level in textures.levels]
        if sources & {"plain.glsl", "plain_switch.glsl"}:
            self.images = [self.bench.image(side, side, 1, texel_format, levels, False) for _ in range(textures.count)]
        if "buffer.glsl" in sources:
            self.linear = [self.bench.buffer(b"".join(levels)) for _ in range(textures.count)]

    def entries(self, way: Way, texture: int) -> list[tuple[int, int, str, int]]:
        tables = [(RECORDS, 0, "rgba32ui", self.records), (TABLE, 0, "r32ui", self.table)]
        if way.source == "pages.glsl":
            return [*tables, (PAGES, 0, "rgba32ui", self.pages)]
        if way.source == "pages_per_texel.glsl":
            records, table, texels = self.per_texel
            pools = (texels, self.zeros) if self.textures.texel_format == "rgba8" else (self.zeros, texels)
            return [
                *[(RECORDS, 0, "rgba32ui", records), (TABLE, 0, "r32ui", table)],
                *[(BYTES, 0, "rgba8", pools[0]), (HALFS, 0, "rgba16f", pools[1])],
            ]
        if way.source == "array_pages.glsl":
            pools = (self.layers, self.no_layers)
            pools = pools if self.textures.texel_format == "rgba8" else pools[::-1]
            return [
                *[tables[0], (TABLE, 0, "r32ui", self.layer_table)],
                *[(BYTES, 0, "image", pools[0]), (HALFS, 0, "image", pools[1])],
            ]
        if way.source == "plain.glsl":
            return [(PLAIN, 0, "image", self.images[texture])]
        if way.source == "plain_switch.glsl":
            return [(PLAIN, i, "image", self.images[min(i, len(self.images) - 1)]) for i in range(8)]
        if way.source == "buffer.glsl":
            return [*tables, (LINEAR, 0, self.textures.texel_format, self.linear[texture])]
        return []

    def dispatches(self, way: Way, count: int, items: int, out: int) -> list[tuple[int, int, int, bytes]]:
        own = count // self.textures.count if way.own_dispatch else count
        result = []
        for first in range(0, count, own):
            entries = self.entries(way, first // own)
            program = self.programs[way]
            bound = self.bench.set(program, [(OUT, 0, "storage", out), (ITEMS, 0, "rgba32f", items), *entries])
            result.append((program, bound, -(-own // GROUP), struct.pack("4I", first, own, 0, 0)))
        return result


def seconds_of(bench: Any, dispatches: list, on_cpu: bool) -> float:
    start = time.process_time()
    nanoseconds, _ = bench.run(dispatches)
    return time.process_time() - start if on_cpu else nanoseconds * 1e-9


def read_case(count: int, side: int, texel_format: str, item_count: int, repeat: int, log: Any = print) -> dict:
    """Times and errors of all ways for one set of textures: (way, pattern, trilinear) -> numbers."""
    textures = layouts.make(count, side, texel_format)
    ways = [way for way in WAYS if way.source != "plain_switch.glsl" or count == 8]
    rig = Rig(textures, ways)
    on_cpu = is_cpu()
    out = rig.bench.buffer(bytes(16 * item_count))
    patterns = [("coherent", False), ("coherent", True), ("incoherent", False), ("incoherent", True)]
    if count == 8:
        patterns.append(("mixed", True))
    runs: dict[tuple[Way, str, bool], list] = {}
    errors: dict[Way, float] = {}
    checked = np.random.default_rng(1).integers(0, item_count, min(item_count, 4096))
    for pattern, trilinear in patterns:
        values = layouts.items(textures, item_count, pattern, trilinear)
        buffer = rig.bench.buffer(values.tobytes())
        want = layouts.expected(textures, values[checked])
        for way in rig.ways:
            if (way.own_dispatch and pattern == "mixed") or (way.only and way.only != pattern):
                continue
            key = (way, pattern, trilinear)
            runs[key] = rig.dispatches(way, item_count, buffer, out)
            rig.bench.run(runs[key])  # compiles
            if way is not NOTHING:
                got = np.frombuffer(rig.bench.read(out), np.float32).reshape(-1, 4)[checked]
                error = float(np.abs(got - want).max()) / layouts.READS / textures.value_range
                errors[way] = max(errors.get(way, 0.0), error)
    wrong = [way.name for way, error in errors.items() if not error < (2e-6 if way.exact else 1 / 128)]
    times: dict[tuple[Way, str, bool], list[float]] = {key: [] for key in runs}
    for _ in range(repeat):
        for key, dispatches in runs.items():
            times[key].append(seconds_of(rig.bench, dispatches, on_cpu) * 1e9 / item_count / layouts.READS)
    empty = {key[1:]: np.median(values) for key, values in times.items() if key[0] is NOTHING}
    cells = {
        key: (
            float(np.median(values) - empty[key[1:]]),
            float(np.subtract(*np.percentile(values, [75, 25])) / 2),
        )
        for key, values in times.items()
        if key[0] is not NOTHING
    }
    log(f"\n{count} texture{'s' * (count > 1)} of {side} x {side} {texel_format}; ns a read, and times C")
    print_reads(ways, patterns, cells, errors, log)
    return {"cells": cells, "errors": errors, "wrong": wrong}


def print_reads(ways: Sequence[Way], patterns: list, cells: dict, errors: dict[Way, float], log: Any) -> None:
    names = [f"{pattern[:6]}. {'tri' if trilinear else 'bi'}linear" for pattern, trilinear in patterns]
    log(f"  {'':28}" + "".join(f"{name:>22}" for name in names) + f"{'error':>10}")
    base = next((way for way in ways if way.source == "plain.glsl"), None)
    for way in ways:
        text = f"  {way.name:28}"
        for pattern in patterns:
            cell = cells.get((way, *pattern))
            against = cells.get((base, *pattern))
            ratio = f"{cell[0] / against[0]:5.2f}x" if cell and against else " " * 6
            text += f"{cell[0]:9.1f} ±{cell[1]:4.1f}{ratio}" if cell else f"{'-':>22}"
        log(text + f"{errors.get(way, 0.0):10.1e}")


def compile_source(way: Way, reads: int, unique: float) -> str:
    """A kernel of so many reads at places of their own; `unique` keeps it out of every cache."""
    text = HEAD
    plain = way.source == "plain.glsl"
    if plain:
        text += f"#define PLAIN_COUNT {reads}\n"
    text += source_of(way)
    if plain:  # a name each
        reader = (HERE / "textures" / way.source).read_text().splitlines()[-1]
        for read in range(1, reads):
            named = reader.replace("benchRead", f"benchRead{read}")
            text += named.replace("PLAIN_READ(PLAIN)", f"PLAIN_READ({read})") + "\n"
    calls = ""
    for read in range(reads):
        name = f"benchRead{read}" if plain and read else "benchRead"
        calls += f"  sum += {name}(floatBitsToUint(item.w) + {read}u, item.xy * {1 + read / 8}, item.z);\n"
    return f"""{text}
void main() {{
  uint i = gl_GlobalInvocationID.x;
  vec4 item = texelFetch(items, int(i)) * {unique:.9f};
  vec4 sum = vec4(0.0);
{calls}  result[i] = sum;
}}
"""


def compile_case(repeat: int, reads: Sequence[int] = (1, 4, 16), log: Any = print) -> dict:
    """Milliseconds of creation and first dispatch by (way, reads)."""
    from _kernel_runner import Bench

    bench = Bench(MEMORY)
    on_cpu = is_cpu()
    buffer = bench.buffer(bytes(1 << 16))
    image = bench.image(4, 4, 1, "rgba8", [bytes(64)], False)
    layers = bench.image(4, 4, 1, "rgba8", [bytes(64)], True)
    rng = np.random.default_rng()
    ways = [NOTHING, *(way for way in WAYS if way.source != "plain_switch.glsl")]
    times: dict[tuple[Way, int], list[float]] = {}
    for _ in range(repeat):
        for way in ways:
            for count in reads:
                code = kernel_runner.spirv(compile_source(way, count, 1 + rng.random()), include=[HERE / "textures"])
                bindings = bindings_of(way, count)
                clock = time.process_time if on_cpu else time.perf_counter
                start = clock()
                program, _ = bench.program(code, bindings)
                entries = []
                for number, kind, size in bindings:
                    what = buffer if kind != "image" else image if number == PLAIN else layers
                    entries += [(number, element, kind, what) for element in range(size)]
                bound = bench.set(program, entries)
                bench.run([(program, bound, 1, bytes(16))])
                times.setdefault((way, count), []).append((clock() - start) * 1e3)
    log("\nms to create and first dispatch a kernel of so many reads")
    log(f"  {'':28}" + "".join(f"{count:>16}" for count in reads))
    for way in ways:
        text = f"  {way.name:28}"
        for count in reads:
            low, middle, high = np.percentile(times[way, count], [25, 50, 75])
            text += f"{middle:10.0f} ±{(high - low) / 2:4.0f}"
        log(text)
    return {key: float(np.median(values)) for key, values in times.items()}


def limits() -> dict[str, Any]:
    from _kernel_runner import Bench

    return dict(Bench(MEMORY).limits())


def is_cpu() -> bool:
    return bool(limits()["on a CPU"])


def print_limits(log: Any = print) -> None:
    found = {name: value for name, value in limits().items() if name != "on a CPU"}
    log(f"{found.pop('device')}, {found.pop('driver')}")
    log("  " + ", ".join(f"{name}: {value}" for name, value in found.items()))
    texel_buffers = sum(1 for _, kind, _ in bindings_of(WAYS[0]) if kind != "storage")
    images = found["sampled images a stage (texel buffers too)"] - texel_buffers
    log(f"  plain descriptors: at most {min(images, found['samplers a stage'])} textures in a kernel")
    pages = found["image array layers"] * layouts.ACROSS**2
    log(f"  array pages: {pages} pages in layers of {layouts.LAYER} x {layouts.LAYER}")
    log(f"  texel-buffer pages: {found['texel buffer elements'] * 16 / 2**30:.0f} GiB of texels")


def main() -> int:
    parser = argparse.ArgumentParser(prog="./run bench textures", description=__doc__.splitlines()[0])
    parser.add_argument("--repeat", type=int, default=11, help="runs of each kernel (default: %(default)s)")
    parser.add_argument("--items", type=int, default=1 << 16, help="items of a run, four reads each (%(default)s)")
    parser.add_argument("--quick", action="store_true", help="8 textures of 256 x 256 only")
    parser.add_argument("--json", type=Path, help="also write the numbers to this file")
    options = parser.parse_args()
    print_limits()
    cases = [(8, 256)] if options.quick else FULL
    wrong, record = [], []
    for texel_format in ("rgba8", "rgba16f"):
        for count, side in cases:
            case = read_case(count, side, texel_format, options.items, options.repeat)
            wrong += case["wrong"]
            for (way, pattern, trilinear), (median, spread) in case["cells"].items():
                record.append([count, side, texel_format, way.name, pattern, trilinear, median, spread])
    compiling = compile_case(options.repeat)
    if options.json:
        compiled = [[way.name, count, value] for (way, count), value in compiling.items()]
        options.json.write_text(json.dumps({"reads": record, "compiling": compiled}) + "\n")
    if wrong:
        print(f"\nWRONG VALUES: {', '.join(sorted(set(wrong)))}")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
