# SPDX-FileCopyrightText: 2026 the multisap authors
# SPDX-License-Identifier: MIT
"""The README shows what is true."""

import re

from conftest import ROOT, header_version, run

README = ROOT / "README.md"


def blocks(language):
    return re.findall(rf"^```{language}\n(.*?)^```", README.read_text(), re.MULTILINE | re.DOTALL)


def test_the_example_is_the_one_that_is_run(made):
    example = (ROOT / "examples/game_loop.c").read_text()
    shown, printed = blocks("c")[0], blocks("text")[0]
    assert example.split("*/\n", 1)[1] == shown
    run("make", made / "examples/game_loop", f"BUILD={made}")
    assert run(made / "examples/game_loop") == printed


def test_every_make_target_that_is_named_exists():
    targets = set(re.findall(r"^([a-z-]+)", run("make", "-s", "help"), re.MULTILINE))
    assert set(re.findall(r"make ([a-z-]+)", "".join(blocks("sh")))) <= targets
    assert {"run", "check"} <= targets


def test_every_path_that_is_named_exists():
    text = README.read_text()
    paths = re.findall(r"^\| `([\w./-]+)` \|", text, re.MULTILINE) + re.findall(r"\]\(([\w./-]+)\)", text)
    assert len(paths) > 6
    assert [path for path in paths if not (ROOT / path).exists()] == []


def test_the_version_is_the_same_everywhere():
    meson = re.search(r"^  version: '(.*)'", (ROOT / "meson.build").read_text(), re.MULTILINE).group(1)
    changelog = re.search(r"^## ([\d.]+)", (ROOT / "CHANGELOG.md").read_text(), re.MULTILINE).group(1)
    assert meson == changelog == header_version()
