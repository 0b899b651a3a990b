#!/usr/bin/env python3
# SPDX-FileCopyrightText: 2026 the multisap authors
# SPDX-License-Identifier: MIT
"""Which function of the interface is called by which harness with its corpus.

usage: tests/trust/reach.py [-w] BUILD HARNESS...

The harnesses in BUILD were built with --coverage. The table is compared with the one in
fuzz/README.md, or put there (-w). A function that no harness calls is an error.
"""

import json
import re
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
README = ROOT / "fuzz/README.md"
TABLE = re.compile(r"(?<=<!-- reach -->\n).*?(?=<!-- /reach -->)", re.DOTALL)

# Not worth a harness: they have no arguments, or one of a dozen.
WITHOUT = {"msap_version", "msap_version_text", "msap_status_text"}


def functions_run(build):
    """The functions that ran since the counts were last deleted."""
    counts = sorted(build.glob("src/*.gcda")) + sorted(build.glob("bindings/lcm/*.gcda"))
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
    symbols = (ROOT / "src/multisap.symbols").read_text().split() + ["msap_lcm_check"]
    rows = ["| function | " + " | ".join(harnesses) + " |", "|---" * (len(harnesses) + 1) + "|"]
    for symbol in symbols:
        if symbol not in WITHOUT:
            cells = ["x" if symbol in ran[harness] else "" for harness in harnesses]
            rows.append(f"| `{symbol}` | " + " | ".join(cells) + " |")
    return "\n".join(rows) + "\n"


def main(arguments):
    write = arguments[0] == "-w"
    build, *harnesses = arguments[write:]
    ran = {harness: run(Path(build).resolve(), harness) for harness in harnesses}
    rows = table(harnesses, ran)
    text = README.read_text()
    for row in rows.splitlines():
        if "x" not in row.split("|", 2)[2] and "`" in row:
            sys.exit(f"no harness calls {row.split('`')[1]}")
    if write:
        README.write_text(TABLE.sub(lambda match: rows, text))
    elif TABLE.search(text).group() != rows:
        sys.exit(rows + "fuzz/README.md has another table (tests/trust/reach.py -w writes it)")


if __name__ == "__main__":
    main(sys.argv[1:])
