#!/bin/sh
# SPDX-FileCopyrightText: 2026 the multisap authors
# SPDX-License-Identifier: MIT
#
# usage: tests/trust/coverage.sh BUILD...
#
# Says which lines and branches of src/ the programs in the folders, built with
# --coverage, did not reach, and fails if there are any. What cannot be reached is
# excluded in the source, by GCOVR_EXCL_LINE, GCOVR_EXCL_BR_LINE or GCOVR_EXCL_START and
# STOP, with the reason beside it. coverage.html in the first folder shows it line by
# line.
set -eu
cd "$(dirname "$0")/../.."

report()
{
    gcovr --root . --filter src/ --exclude-throw-branches "$@"
}

result=0
report --html-details "$1/coverage.html" --fail-under-line 100 --fail-under-branch 100 "$@" >"$1/lines.txt" || result=1
report --txt-metric branch "$@" >"$1/branches.txt"
for what in lines branches; do
    awk -v what=$what '/^TOTAL/ { print what ": " $3 " of " $2 ", " $4 }
        $4 ~ /%/ && $4 != "100%" && !/^TOTAL/ { print "    " $0 }' "$1/$what.txt"
done
exit $result
