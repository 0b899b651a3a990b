#!/bin/sh
# SPDX-FileCopyrightText: 2026 the multisap authors
# SPDX-License-Identifier: MIT
#
# usage: fuzz/keep.sh BUILD HARNESS
#
# Replaces fuzz/corpus/HARNESS: of it and of what was found in BUILD/corpus, few and
# small inputs that reach all that is reached. Those of seeds.py, and the inputs that
# showed a bug (found-*), stay.
set -eu
build=$1
harness=$2
kept=$build/kept/$harness
corpus=fuzz/corpus/$harness
log=$build/$harness.keep.log
rm -rf "$kept"
mkdir -p "$kept" "$corpus" "$build/corpus/$harness"
export ASAN_OPTIONS=detect_leaks=0:quarantine_size_mb=4
"$build/fuzz/fuzz_$harness" -set_cover_merge=1 -use_counters=0 -max_len=512 \
    "$kept" "$corpus" "$build/corpus/$harness" >"$log" 2>&1 || {
    tail -n 20 "$log" >&2
    exit 1
}
find "$corpus" -type f ! -name 'seed-*' ! -name 'found-*' -delete
for input in "$kept"/*; do
    [ -e "$input" ] || continue
    is_there=
    for old in "$corpus"/seed-* "$corpus"/found-*; do
        ! cmp -s "$input" "$old" || is_there=yes
    done
    [ -n "$is_there" ] || cp "$input" "$corpus/"
done
echo "$harness: $(ls "$corpus" | wc -l) inputs, $(cat "$corpus"/* | wc -c) bytes"
