#!/bin/sh
# SPDX-FileCopyrightText: 2026 the multisap authors
# SPDX-License-Identifier: MIT
#
# usage: fuzz/afl.sh BUILD HARNESS SECONDS
#
# Runs a harness that was built by afl-clang-fast for so many seconds, from its corpus.
# Prints one line; what was found is in BUILD/found.
set -eu
build=$1
harness=$2
seconds=$3
found=$build/found/$harness
rm -rf "$found"
mkdir -p "$build/found"

export AFL_SKIP_CPUFREQ=1 AFL_NO_AFFINITY=1 AFL_I_DONT_CARE_ABOUT_MISSING_CRASHES=1 AFL_NO_UI=1
afl-fuzz -V "$seconds" -m none -t 10000 -i "fuzz/corpus/$harness" -o "$found" -x fuzz/fuzz.dict -- \
    "$build/fuzz/fuzz_$harness" >"$build/$harness.log" 2>&1 || {
    tail -n 30 "$build/$harness.log" >&2
    exit 1
}

stats=$found/default/fuzzer_stats
executions=$(sed -n 's/^execs_done *: *//p' "$stats")
crashes=$(sed -n 's/^saved_crashes *: *//p' "$stats")
hangs=$(sed -n 's/^saved_hangs *: *//p' "$stats")
if [ "$crashes" = 0 ] && [ "$hangs" = 0 ]; then
    echo "$harness: $executions executions"
else
    echo "$harness: FAILED after $executions executions: $crashes crashes, $hangs hangs in $found/default" >&2
    exit 1
fi
