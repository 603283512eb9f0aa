# SPDX-License-Identifier: Apache-2.0
# Copyright the hdWavefront authors
"""What `./run test` starts: the C++ tests, then pytest, and one closing line over both.

No arguments: everything. `--cpp ...`: only the C++ tests, the rest goes to GoogleTest. Else: only pytest, with these.
The build folder is $HDWAVEFRONT_BUILD_DIR.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import time
import xml.etree.ElementTree as ElementTree
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent


@dataclass
class Tally:
    passed: int = 0
    failed: int = 0
    skipped: int = 0

    def add(self, other: Tally) -> None:
        self.passed += other.passed
        self.failed += other.failed
        self.skipped += other.skipped


def tally_of_gtest(report: Path) -> Tally:
    """Counts of GoogleTest's JSON report; a missing or cut report is a crash, which is a failure."""
    try:
        data = json.loads(report.read_text())
    except (OSError, ValueError):
        return Tally(failed=1)
    tally = Tally()
    for suite in data["testsuites"]:
        for case in suite["testsuite"]:
            if case.get("result") == "SKIPPED":
                tally.skipped += 1
            elif case.get("status") == "NOTRUN":
                continue
            elif case.get("failures"):
                tally.failed += 1
            else:
                tally.passed += 1
    return tally


def tally_of_pytest(report: Path) -> Tally:
    """Counts of pytest's JUnit report; a missing or cut report is a crash, which is a failure."""
    try:
        suites = ElementTree.parse(report).getroot()
    except (OSError, ElementTree.ParseError):
        return Tally(failed=1)
    tally = Tally()
    for suite in suites.iter("testsuite"):
        failed = int(suite.get("failures", 0)) + int(suite.get("errors", 0))
        skipped = int(suite.get("skipped", 0))
        tally.add(Tally(int(suite.get("tests", 0)) - failed - skipped, failed, skipped))
    return tally


def run(command: list[str], report: Path, cwd: Path, env: dict[str, str]) -> int:
    report.unlink(missing_ok=True)
    return subprocess.run(command, cwd=cwd, env=env, check=False).returncode


def anchor(argument: str) -> str:
    """A path that exists where the user stands, with or without ::test, made independent of it."""
    path, separator, test = argument.partition("::")
    if path and not path.startswith("-") and Path(path).exists():
        return str(Path(path).resolve()) + separator + test
    return argument


def main(arguments: list[str]) -> int:
    build = Path(os.environ["HDWAVEFRONT_BUILD_DIR"]).resolve()
    env = dict(os.environ)
    env.setdefault("HDWAVEFRONT_VALIDATION", "1")
    assets = ROOT.parent / "shared" / "assets"  # third-party stages, where they stand beside the checkout
    if assets.is_dir():
        env.setdefault("HDWAVEFRONT_ASSETS", str(assets))
    env["PYTHONPATH"] = os.pathsep.join(p for p in (str(build / "python"), env.get("PYTHONPATH", "")) if p)
    started = time.monotonic()
    tally = Tally()
    codes = []

    if not arguments or arguments[0] == "--cpp":
        program, report = build / "tests" / "hdwavefront_tests", build / "gtest.json"
        if program.exists():
            command = [str(program), "--gtest_brief=1", f"--gtest_output=json:{report}", *arguments[1:]]
            codes.append(run(command, report, ROOT, env))
            tally.add(tally_of_gtest(report))
        elif arguments:
            print("There are no C++ tests.", file=sys.stderr)
            codes.append(1)
    if not arguments or arguments[0] != "--cpp":
        report = build / "pytest.xml"
        command = [sys.executable, "-m", "pytest", f"--junitxml={report}", *map(anchor, arguments)]
        codes.append(run(command, report, ROOT, env))
        tally.add(tally_of_pytest(report))

    seconds = time.monotonic() - started
    bad = tally.failed > 0 or any(codes) or tally.passed == 0
    print(f"\n{'Tests failed' if bad else 'All tests passed'}, {seconds:.0f} s")
    print(f"{tally.passed} passed, {tally.failed} failed" + (f", {tally.skipped} skipped" if tally.skipped else ""))
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
