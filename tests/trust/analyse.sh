#!/bin/sh
# SPDX-FileCopyrightText: 2026 the multisap authors
# SPDX-License-Identifier: MIT
#
# usage: tests/trust/analyse.sh 'FLAGS' FILE.c...
#
# Analyses each file with gcc -fanalyzer, clang, clang-tidy and cppcheck. Every warning
# is an error. FLAGS are those that the files need to be compiled. What is switched off, and why:
#
# -Wanalyzer-use-of-uninitialized-value, -Wanalyzer-null-dereference
#     gcc 12 follows no loop whose count depends on an argument, and takes what such a
#     loop fills for not filled; MSan, UBSan and clang's analyser look at the same
# bugprone-easily-swappable-parameters
#     nearly every function of two integers
# bugprone-implicit-widening-of-multiplication-result
#     end points are numbered 2 * box and 2 * box + 1, which fit 32 bits as boxes fit 31
# bugprone-narrowing-conversions
#     clang's implicit-conversion sanitizer sees the real ones
# bugprone-reserved-identifier, cert-dcl37-c, cert-dcl51-cpp
#     feature test macros like _POSIX_C_SOURCE are reserved identifiers
# cert-err33-c
#     the command checks its output once, at the end; where printing an error fails,
#     nothing can be said about it
# cert-flp30-c
#     a loop that doubles a number is exact
# clang-analyzer-security.insecureAPI.DeprecatedOrUnsafeBufferHandling
#     asks for memcpy_s, which no C library here has
# misc-*
#     takes all memory in version 14
set -eu
flags=$1
shift
result=0
checks='-*,clang-analyzer-*,bugprone-*,cert-*,portability-*,performance-*'
for off in bugprone-easily-swappable-parameters bugprone-implicit-widening-of-multiplication-result \
    bugprone-narrowing-conversions bugprone-reserved-identifier cert-dcl37-c cert-dcl51-cpp cert-err33-c cert-flp30-c \
    clang-analyzer-security.insecureAPI.DeprecatedOrUnsafeBufferHandling; do
    checks="$checks,-$off"
done

for file in "$@"; do
    gcc -std=c99 -O1 $flags -fanalyzer -Wno-analyzer-use-of-uninitialized-value -Wno-analyzer-null-dereference \
        -pedantic -Wall -Wextra -Werror -c "$file" -o /dev/null || result=1
    clang -std=c99 $flags -pedantic -Wall -Wextra -Werror -fsyntax-only "$file" || result=1
    clang-tidy --quiet --warnings-as-errors='*' --checks="$checks" "$file" -- -std=c99 $flags 2>/dev/null || result=1
done
cppcheck --quiet --std=c99 --enable=warning,performance,portability --inline-suppr --error-exitcode=1 $flags "$@" ||
    result=1
[ $result = 0 ] && echo "analyse: $# files without a warning"
exit $result
