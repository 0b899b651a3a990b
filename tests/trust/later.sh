#!/bin/sh
# SPDX-FileCopyrightText: 2026 the multisap authors
# SPDX-License-Identifier: MIT
#
# usage: tests/trust/later.sh BUILD CC SOURCE.c...
#
# Programs of before with a library of later: makes, in BUILD, a copy of the header in
# which msap_config and msap_world_stats have fields more, and a shared library from the
# sources with it. A program that was built with the header as it is must run with that
# library; so must one that was built with the later header.
set -eu
build=$1
cc=$2
shift 2
later=$build/later
flags='-std=c99 -pedantic -Wall -Wextra -Werror -O1'
mkdir -p "$later/include"

sed -e 's/^} msap_config;/    uint64_t later_a[3];\n&/' -e 's/^} msap_world_stats;/    uint64_t later_b[2];\n&/' \
    include/multisap.h >"$later/include/multisap.h"
$cc $flags -fPIC -fvisibility=hidden -I"$later/include" -shared -Wl,-soname,libmultisap.so.0 \
    -Wl,--version-script=src/multisap.map -o "$later/libmultisap.so.0" "$@"

sizes=
for header in include "$later/include"; do
    $cc $flags -I"$header" tests/trust/program_of_before.c "$later/libmultisap.so.0" -o "$later/program"
    size=$(LD_LIBRARY_PATH=$later "$later/program") || exit 1
    sizes="$sizes $size"
done
set -- $sizes
echo "later library: programs with configs of $1 and $2 bytes run"
[ "$1" -lt "$2" ]
