#!/bin/sh
# SPDX-FileCopyrightText: 2026 the multisap authors
# SPDX-License-Identifier: MIT
#
# usage: fuzz/long.sh BUILD SECONDS RUNS HARNESS...
#
# A campaign: the first harness runs for SECONDS; meanwhile the others take turns, and
# go on until all have run RUNS times together. A harness that found something takes
# part no more. Prints a table; what was found is in BUILD/found.
set -eu
build=$1
seconds=$2
runs=$3
first=$4
shift 4

# In a turn a fast harness stops early, so that the time goes to the slow ones.
turn=$((seconds / 12 + 1))
most=$((runs / 5 + 1))
rm -rf "$build/found"
mkdir -p "$build/tally"
rm -f "$build/tally"/*

# One turn of a harness, its result added to its tally.
take_turn()
{
    began=$(date +%s)
    fuzz/libfuzzer.sh "$build" "$1" "$2" "$3" >"$build/$1.line" 2>&1 || cat "$build/$1.line" >&2
    counts=$(sed -n 's/.* \([0-9]*\) executions, \([0-9]*\) edges.*/\1 \2/p' "$build/$1.line")
    echo "$(($(date +%s) - began)) $counts" >>"$build/tally/$1"
}

executions()
{
    cat "$build/tally"/* 2>/dev/null | awk '{n += $2} END {print n + 0}'
}

has_found()
{
    ls "$build/found/$1-"* >/dev/null 2>&1
}

is_over()
{
    [ -e "$build/first.over" ] && [ "$(executions)" -ge "$runs" ]
}

rm -f "$build/first.over"
{ take_turn "$first" "$seconds" 0; : >"$build/first.over"; } &
playing=$#
while [ "$playing" -gt 0 ]; do
    playing=0
    for harness; do
        if ! has_found "$harness" && ! is_over; then
            playing=$((playing + 1))
            take_turn "$harness" "$turn" "$most"
        fi
    done
done
wait

found=0
printf '%-8s %8s %12s %6s %7s %6s\n' harness seconds executions edges inputs found
for harness in "$first" "$@"; do
    n=$(find "$build/found" -name "$harness-*" 2>/dev/null | wc -l)
    found=$((found + n))
    awk -v h="$harness" -v inputs="$(ls "$build/corpus/$harness" | wc -l)" -v n="$n" \
        '{s += $1; e += $2; if ($3 > c) c = $3}
         END {printf "%-8s %8d %12d %6d %7d %6d\n", h, s, e, c, inputs, n}' \
        "$build/tally/$harness"
done
echo "together $(executions) executions, $found findings"
[ "$found" = 0 ] && [ "$(executions)" -ge "$runs" ]
