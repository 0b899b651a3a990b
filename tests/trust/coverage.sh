#!/bin/sh
# SPDX-FileCopyrightText: 2026 the multisap authors
# SPDX-License-Identifier: MIT
#
# usage: tests/trust/coverage.sh BUILD PORTABLE
#
# Says which lines and branches of src/ the programs in BUILD, built with --coverage, did
# not reach, and which of the files that have a portable half those in PORTABLE, built
# without SSE2, did not; fails if there are any. What cannot be reached is excluded in the
# source, by GCOVR_EXCL_LINE, GCOVR_EXCL_BR_LINE or GCOVR_EXCL_START and STOP, with the
# reason beside it. The coverage.html in each of them shows it line by line.
set -eu
cd "$(dirname "$0")/../.."

# report NAME FOLDER FILTERS...: the totals, and what is missing
report()
{
    name=$1
    folder=$2
    shift 2
    gcovr --root . "$@" --txt "$folder/lines.txt" --html-details "$folder/coverage.html" \
        --fail-under-line 100 --fail-under-branch 100 "$folder" 2>"$folder/errors" || result=1
    grep -v 'failed minimum' "$folder/errors" >&2 || :
    gcovr --root . "$@" --txt "$folder/branches.txt" --branches "$folder"
    for what in lines branches; do
        awk -v what="$name, $what" '/^TOTAL/ { print what ": " $3 " of " $2 " reached, " $4 }
            $4 ~ /[0-9]%/ && $4 != "100%" && !/^TOTAL/ { print "    " $0 }' "$folder/$what.txt"
    done
}

result=0
report 'with vectors' "$1" --filter src/
report 'portable halves' "$2" $(grep -l __SSE2__ src/* | sed 's/^/--filter /')
exit $result
