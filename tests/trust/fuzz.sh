#!/bin/sh
# SPDX-FileCopyrightText: 2026 the multisap authors
# SPDX-License-Identifier: MIT
#
# usage: tests/trust/fuzz.sh BUILD HARNESS SECONDS
#
# Runs a libFuzzer program for so many seconds. New inputs stay in BUILD/corpus, what
# was found in BUILD/found. Prints one line, and the end of the log if something was
# found.
set -eu
build=$1
harness=$2
seconds=$3
mkdir -p "$build/corpus/$harness" "$build/found"
log=$build/$harness.log

result=0
ASAN_OPTIONS=detect_leaks=0 "$build/fuzz/fuzz_$harness" -max_total_time="$seconds" -max_len=512 -timeout=30 \
    -rss_limit_mb=4096 -dict=fuzz/fuzz.dict -artifact_prefix="$build/found/$harness-" -print_final_stats=1 \
    "$build/corpus/$harness" "fuzz/corpus/$harness" >"$log" 2>&1 || result=1

executions=$(sed -n 's/^stat::number_of_executed_units: *//p' "$log")
if [ $result = 0 ]; then
    echo "$harness: ${executions:-0} executions"
else
    tail -n 40 "$log" >&2
    echo "$harness: FAILED after ${executions:-0} executions; the input is in $build/found" >&2
fi
exit $result
