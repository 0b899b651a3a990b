#!/usr/bin/env python3
# SPDX-FileCopyrightText: 2026 the multisap authors
# SPDX-License-Identifier: MIT
"""Which function of the interface is called by which harness with its corpus.

usage: fuzz/reach.py [-w] BUILD HARNESS...

The harnesses in BUILD were built with --coverage. The table is compared with the one in
fuzz/README.md, or put there (-w). A function that no harness calls is an error.
"""

import json
import re
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
README = ROOT / "fuzz/README.md"
HEADERS = {"include/multisap.h": "src", "bindings/lcm/multisap_lcm.h": "bindings/lcm"}
TABLE = re.compile(r"(?<=<!-- reach -->\n).*?(?=<!-- /reach -->)", re.DOTALL)


def functions():
    """The functions of the interface, by header, and the folder of each header's sources."""
    for header, folder in HEADERS.items():
        text = (ROOT / header).read_text()
        for name in re.findall(r"^MSAP_API [^(;]*?(\w+)\(", text, re.MULTILINE):
            yield name, folder


def functions_run(build):
    """The functions that ran since the counts were last deleted."""
    counts = sorted(path for folder in HEADERS.values() for path in (build / folder).glob("*.gcda"))
    done = subprocess.run(["gcov", "--json-format", "--stdout", *counts], check=True, stdout=subprocess.PIPE)
    reports = (json.loads(line) for line in done.stdout.splitlines() if line)
    return {function["name"] for report in reports for file in report["files"]
            for function in file["functions"] if function["execution_count"]}


def run(build, harness):
    for count in build.rglob("*.gcda"):
        count.unlink()
    subprocess.run([build / f"fuzz/fuzz_{harness}", ROOT / "fuzz/corpus" / harness], check=True,
                   stdout=subprocess.DEVNULL)
    return functions_run(build)


def table(harnesses, ran):
    rows = ["| function | " + " | ".join(harnesses) + " |", "| --- |" + " :-: |" * len(harnesses)]
    for name, _ in functions():
        rows.append(f"| `{name}` | " + " | ".join("x" if name in ran[h] else "" for h in harnesses) + " |")
    return "\n".join(rows) + "\n"


def main(arguments):
    write = arguments[0] == "-w"
    build, *harnesses = arguments[write:]
    built = [(name, folder) for name, folder in functions() if list((Path(build) / folder).glob("*.gcno"))]
    ran = {harness: run(Path(build).resolve(), harness) for harness in harnesses}
    unreached = [name for name, _ in built if not any(name in functions for functions in ran.values())]
    rows, text = table(harnesses, ran), README.read_text()
    if unreached:
        sys.exit("no harness calls " + ", ".join(unreached))
    if write:
        README.write_text(TABLE.sub(lambda match: rows, text))
    elif TABLE.search(text).group() != rows:
        sys.exit(rows + "fuzz/README.md has another table (fuzz/reach.py -w writes it)")
    print(f"{len(built)} functions, each called by a harness")


if __name__ == "__main__":
    main(sys.argv[1:])
