# SPDX-FileCopyrightText: 2026 the multisap authors
# SPDX-License-Identifier: MIT
"""The README shows what is true, and what the documents name exists."""

import re

import pytest
from conftest import MAKE, ROOT, header_version, run

README = ROOT / "README.md"
DOCUMENTS = sorted(path.relative_to(ROOT) for pattern in ("*.md", "docs/**/*.md", "fuzz/*.md", "tests/**/*.md")
                   for path in ROOT.glob(pattern))


def blocks(language):
    return re.findall(rf"^```{language}\n(.*?)^```", README.read_text(), re.MULTILINE | re.DOTALL)


def test_the_example_is_the_one_that_is_run(made):
    example = (ROOT / "examples/game_loop.c").read_text()
    shown, printed = blocks("c")[0], blocks("text")[0]
    assert example.split("*/\n", 1)[1] == shown
    run(*MAKE, made / "examples/game_loop", f"BUILD={made}")
    assert run(made / "examples/game_loop") == printed


@pytest.fixture(scope="module")
def targets():
    lines = run("make", "-s", "help").splitlines()
    return {target for line in lines for target in re.split(r"  +", line)[0].split()}


def test_the_two_commands_exist(targets):
    named = set(re.findall(r"^make ([a-z-]+)", "".join(blocks("sh")), re.MULTILINE))
    assert {"run", "check"} <= named <= targets


@pytest.mark.parametrize("document", DOCUMENTS, ids=str)
def test_every_make_target_that_is_named_exists(document, targets):
    named = re.findall(r"(?:`|^ {4}|^)make ([a-z][a-z-]*)(?=[ `\n])", (ROOT / document).read_text(), re.MULTILINE)
    assert [name for name in named if name not in targets] == []


@pytest.mark.parametrize("document", DOCUMENTS, ids=str)
def test_every_path_that_is_linked_exists(document):
    paths = re.findall(r"\]\(([\w./-]+)\)", (ROOT / document).read_text())
    assert [path for path in paths if not (ROOT / document).parent.joinpath(path).exists()] == []


def test_every_folder_that_the_readme_lists_exists():
    paths = re.findall(r"^\| `([\w./-]+)` \|", README.read_text(), re.MULTILINE)
    assert len(paths) > 6
    assert [path for path in paths if not (ROOT / path).exists()] == []


def test_the_version_is_the_same_everywhere():
    meson = re.search(r"^  version: '(.*)'", (ROOT / "meson.build").read_text(), re.MULTILINE).group(1)
    changelog = re.search(r"^## ([\d.]+)", (ROOT / "CHANGELOG.md").read_text(), re.MULTILINE).group(1)
    assert meson == changelog == header_version()
