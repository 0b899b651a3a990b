#!/bin/sh
# SPDX-FileCopyrightText: 2026 the multisap authors
# SPDX-License-Identifier: MIT
#
# usage: fuzz/libfuzzer.sh BUILD HARNESS SECONDS [RUNS]
#
# Runs a libFuzzer program for so many seconds, or executions if they come first (0 or
# none: no limit). New inputs stay in BUILD/corpus, what was found in BUILD/found.
# Prints one line, and the end of the log if something was found.
set -eu
build=$1
harness=$2
seconds=$3
runs=${4:-0}
[ "$runs" != 0 ] || runs=-1
mkdir -p "$build/corpus/$harness" "$build/found"
log=$build/$harness.log

# A tracker counts what leaks; a small quarantine keeps the memory in the cache.
export ASAN_OPTIONS=detect_leaks=0:quarantine_size_mb=4
result=0
"$build/fuzz/fuzz_$harness" -max_total_time="$seconds" -runs="$runs" -max_len=512 -timeout=30 -rss_limit_mb=4096 \
    -dict=fuzz/fuzz.dict -artifact_prefix="$build/found/$harness-" -print_final_stats=1 \
    "$build/corpus/$harness" "fuzz/corpus/$harness" >"$log" 2>&1 || result=1

executions=$(sed -n 's/^stat::number_of_executed_units: *//p' "$log")
edges=$(sed -n 's/.* cov: \([0-9]*\) .*/\1/p' "$log" | tail -n 1)
if [ $result = 0 ]; then
    echo "$harness: ${executions:-0} executions, ${edges:-0} edges"
else
    tail -n 40 "$log" >&2
    echo "$harness: FAILED after ${executions:-0} executions, ${edges:-0} edges; the input is in $build/found" >&2
fi
exit $result
