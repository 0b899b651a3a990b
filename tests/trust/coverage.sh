#!/bin/sh
# SPDX-FileCopyrightText: 2026 the multisap authors
# SPDX-License-Identifier: MIT
#
# usage: tests/trust/coverage.sh BUILD
#
# Says which lines and branches of src/ the programs in BUILD, built with --coverage, did
# not reach, and fails if there are any. What cannot be reached is excluded in the
# source, by GCOVR_EXCL_LINE, GCOVR_EXCL_BR_LINE or GCOVR_EXCL_START and STOP, with the
# reason beside it. BUILD/coverage.html shows it line by line.
set -eu
build=$1
cd "$(dirname "$0")/../.."
gcovr --root . --filter 'src/' --object-directory "$build" --exclude-throw-branches --html-details "$build/coverage.html" \
    --txt "$build/coverage.txt" --txt-metric branch --fail-under-line 100 --fail-under-branch 100 "$build" &&
    result=0 || result=1
gcovr --root . --filter 'src/' --object-directory "$build" --exclude-throw-branches "$build" |
    awk '/TOTAL/ { print "lines " $4 } $4 ~ /%/ && $4 != "100%" && !/TOTAL/'
awk '/TOTAL/ { print "branches " $4 } $4 ~ /%/ && $4 != "100%" && !/TOTAL/' "$build/coverage.txt"
exit $result
