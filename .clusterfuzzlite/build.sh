#!/bin/bash -eu
# SPDX-FileCopyrightText: 2026 the multisap authors
# SPDX-License-Identifier: MIT
#
# Builds the harnesses into $OUT, with the compilers, flags and engine that the
# environment names, each with its corpus, dictionary and options. Where they run there
# is no LCM, so its two harnesses are left out.
make BUILD="$WORK/multisap" LCM=no LINK="$CXX $CXXFLAGS" FUZZ_MAIN= FUZZ_LINK="$LIB_FUZZING_ENGINE" harnesses

for corpus in fuzz/corpus/*; do
    harness=fuzz_${corpus##*/}
    program=$WORK/multisap/fuzz/$harness
    [ -x "$program" ] || continue
    cp "$program" "$OUT/"
    cp fuzz/fuzz.dict "$OUT/$harness.dict"
    printf '[libfuzzer]\nmax_len = 512\n' >"$OUT/$harness.options"
    zip -jqr "$OUT/${harness}_seed_corpus.zip" "$corpus"
done
