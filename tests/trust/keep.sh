#!/bin/sh
# SPDX-FileCopyrightText: 2026 the multisap authors
# SPDX-License-Identifier: MIT
#
# usage: tests/trust/keep.sh BUILD HARNESS
#
# Replaces fuzz/corpus/HARNESS: of it and of what was found in BUILD/corpus, few and
# small inputs that reach all that is reached. Those of seeds.py stay.
set -eu
build=$1
harness=$2
kept=$build/kept/$harness
corpus=fuzz/corpus/$harness
rm -rf "$kept"
mkdir -p "$kept" "$corpus" "$build/corpus/$harness"
ASAN_OPTIONS=detect_leaks=0 "$build/fuzz/fuzz_$harness" -set_cover_merge=1 -max_len=512 "$kept" \
    "$corpus" "$build/corpus/$harness" >"$build/$harness.keep.log" 2>&1
find "$corpus" -type f ! -name 'seed-*' -delete
for input in "$kept"/*; do
    cmp -s "$input" "$corpus/seed-${input##*/}" || cp "$input" "$corpus/"
done
echo "$harness: $(ls "$corpus" | wc -l) inputs, $(cat "$corpus"/* | wc -c) bytes"
