#!/bin/sh
# SPDX-FileCopyrightText: 2026 the multisap authors
# SPDX-License-Identifier: MIT
#
# usage: tests/differential/portable.sh FOLDER
#
# Builds golden.c and the library in many ways, into FOLDER, and runs each: every one
# must print what is pinned there. (Of x86-64, plain builds have SSE2 and choose AVX2
# or AVX-512 at run time; config.simd 1 sweeps in portable C, 2 with SSE2, 3 with AVX2,
# 4 with AVX-512; and without __SSE2__ bounds are compared in portable C, too. aarch64 has
# NEON, s390x nothing.)
# Compilers and emulators that this machine lacks are named and left out. The last line
# counts; the exit status is 1 if any build failed.
set -eu
cd "$(dirname "$0")/../.."
folder=$1
mkdir -p "$folder"
passed=0
failed=0
missing=

# tell NAME RESULT
tell()
{
    printf '%-52s %s\n' "$1" "$2"
}

# play NAME COMMAND...: runs a program that was built
play()
{
    name=$1
    shift
    if result=$("$@" 2>"$folder/errors"); then
        passed=$((passed + 1))
        tell "$name" "$(echo $result)"
    else
        failed=$((failed + 1))
        tell "$name" FAILED
        cat "$folder/errors"
    fi
}

# build COMPILER FLAGS...: into $folder/golden; returns 1 where that does not work
build()
{
    if ! command -v "$1" >/dev/null; then
        case $missing in *"$1"*) ;; *) missing="$missing $1" ;; esac
        return 1
    fi
    "$@" -std=c99 -Iinclude -o "$folder/golden" tests/differential/golden.c tests/unit/setups.c \
        examples/thread_pool.c src/*.c -pthread && return 0
    failed=$((failed + 1))
    tell "$*" 'DOES NOT BUILD'
    return 1
}

# here COMPILER FLAGS...
here()
{
    build "$@" && play "$*" "$folder/golden" || :
}

# there EMULATOR COMPILER FLAGS...: a static program, so that no foreign library is needed
there()
{
    emulator=$1
    shift
    if ! command -v "$emulator" >/dev/null; then
        case $missing in *"$emulator"*) ;; *) missing="$missing $emulator" ;; esac
        return 0
    fi
    build "$@" -static && play "$emulator: $*" "$emulator" "$folder/golden" || :
}

for compiler in gcc clang; do
    for level in -O0 -O2 -O3; do
        here $compiler $level
    done
    here $compiler -O2 -ffast-math
    if [ "$(uname -m)" = x86_64 ]; then
        here $compiler -O3 -ffast-math -mavx2 -mfma
        for simd in 1 2 3 4; do
            build $compiler -O2 && play "$compiler -O2, config.simd $simd" "$folder/golden" $simd || :
        done
        build $compiler -O2 -U__SSE2__ && play "$compiler -O2 -U__SSE2__, config.simd 1" "$folder/golden" 1 || :
    fi
done
[ "$(uname -m)" != x86_64 ] || here gcc -O2 -mfpmath=387
for level in -O0 -O2 -O3; do
    there qemu-aarch64 aarch64-linux-gnu-gcc $level
    there qemu-s390x s390x-linux-gnu-gcc $level
    there qemu-i386 i686-linux-gnu-gcc $level
done
[ -z "$missing" ] || echo "not here, left out:$missing"
echo "$passed passed, $failed failed"
[ $failed = 0 ]
