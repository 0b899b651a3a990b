#!/bin/sh
# SPDX-FileCopyrightText: 2026 the multisap authors
# SPDX-License-Identifier: MIT
#
# usage: tests/trust/abi.sh LIBRARY          prints its ABI, as src/multisap.abi holds it
#        tests/trust/abi.sh LIBRARY BUILD    compares it with src/multisap.abi
#
# Any difference fails: one that is meant is taken over by `make abi-baseline` and noted
# in CHANGELOG.md; docs/ABI.md says which may be meant. The library must have been built
# with -g.
set -eu
library=$1

# The build's folders, lines and compiler are no part of it, nor is the machine.
describe()
{
    abidw --exported-interfaces-only --headers-dir include --drop-private-types --no-corpus-path \
        --no-comp-dir-path --no-show-locs --no-elf-needed "$library"
}

if [ $# = 1 ]; then
    describe
    exit
fi

described=$2/multisap.abi
describe >"$described"
result=0
abidiff --no-show-locs src/multisap.abi "$described" >"$2/abi.diff" 2>&1 || result=$?
if [ $result = 0 ]; then
    echo "abi: as in src/multisap.abi, $(grep -c '<elf-symbol ' "$described") functions"
    exit 0
fi
cat "$2/abi.diff" >&2
if [ $((result & 8)) != 0 ]; then
    echo 'abi: not compatible with src/multisap.abi: programs of before would fail' >&2
else
    echo 'abi: not that of src/multisap.abi' >&2
fi
exit 1
