# SPDX-FileCopyrightText: 2026 the multisap authors
# SPDX-License-Identifier: MIT
#
# Fuzzing. Included by tests/trust/trust.mk, with the Makefile's lists and rules;
# README.md says how it is used.
#
# Variables: HARNESSES (which ones), FUZZ_SECONDS (for each, 60), FUZZ_LONG_SECONDS
# (for api in fuzz-long, 3600), FUZZ_LONG_RUNS (of all together, 20000000).

FUZZ_SECONDS ?= 60
FUZZ_LONG_SECONDS ?= 3600
FUZZ_LONG_RUNS ?= 20000000

HARNESSES = api alloc setups bounds prune trace $(if $(LCM_STATIC),lcm stream)
FUZZ = $(HARNESSES:%=$(BUILD)/fuzz/fuzz_%)
FUZZ_COMMON = fuzz/input.c fuzz/scene.c fuzz/play.c fuzz/wrong.c $(UNIT_COMMON)
TRACE = tools/trace.c tools/player.c

# A harness is linked with FUZZ_MAIN, or with what FUZZ_LINK brings instead.
FUZZ_MAIN = $(BUILD)/fuzz/plain.o

$(BUILD)/fuzz/fuzz_trace: $(call objects,$(TRACE))
$(BUILD)/fuzz/fuzz_lcm.o $(BUILD)/fuzz/fuzz_stream.o: | $(LCM_GENERATED)
$(FUZZ): %: %.o $(call objects,$(FUZZ_COMMON)) $(FUZZ_MAIN) $(LCM_STATIC) $(STATIC)
	$(call say,ld $@)
	$(Q)$(LINK) $(FUZZ_LINK) -o $@ $(filter %.o,$^) $(LCM_STATIC) $(STATIC) $(LCM_LINK) -lm -pthread

# Only what is tried is watched, not the harnesses: they are faster without.
$(call objects,$(CORE) $(TRACE)) $(LCM_OBJECTS): private override CFLAGS += $(FUZZ_WATCH)
SETTINGS += $(FUZZ_WATCH) $(FUZZ_LINK)

test-corpus: $(FUZZ) ## run the fuzzing harnesses over their corpora
	@result=0; for h in $(HARNESSES); do printf "$$h: "; $(BUILD)/fuzz/fuzz_$$h fuzz/corpus/$$h || result=1; done; \
	exit $$result

harnesses: $(FUZZ) ## build the fuzzing harnesses, as plain programs

missing = { echo "$@: there is no $(1) here (Debian: apt-get install $(2))" >&2; exit 1; }
with_clang = @echo 'int LLVMFuzzerTestOneInput(const char *d, unsigned long n) { return !d && n; }' \
    | clang -x c - -fsanitize=fuzzer $(SANITIZE) -o /dev/null 2>/dev/null \
    || $(call missing,clang with libFuzzer,clang libclang-rt-14-dev)
with_afl = @command -v afl-clang-fast >/dev/null || $(call missing,AFL++,afl++ libclang-rt-14-dev)

SANITIZE = -fsanitize=address,undefined
FUZZ_CFLAGS = -O2 -g -fno-omit-frame-pointer

LIBFUZZER = BUILD=$(BUILD)/libfuzzer CC=clang CFLAGS='$(FUZZ_CFLAGS)' \
    FUZZ_WATCH='-fsanitize-coverage=inline-8bit-counters,pc-table $(SANITIZE) -fno-sanitize-recover=all' \
    FUZZ_MAIN= FUZZ_LINK='-fsanitize=fuzzer $(SANITIZE)'

fuzz: ## fuzz all harnesses with libFuzzer, FUZZ_SECONDS each
	$(with_clang)
	$(again) $(LIBFUZZER) run-fuzz

run-fuzz: $(FUZZ)
	@result=0; for h in $(HARNESSES); do fuzz/libfuzzer.sh $(BUILD) $$h $(FUZZ_SECONDS) || result=1; done; exit $$result

fuzz-long: ## fuzz api for FUZZ_LONG_SECONDS and meanwhile the others, all together FUZZ_LONG_RUNS times
	$(with_clang)
	$(again) $(LIBFUZZER) run-fuzz-long

run-fuzz-long: $(FUZZ)
	@fuzz/long.sh $(BUILD) $(FUZZ_LONG_SECONDS) $(FUZZ_LONG_RUNS) $(HARNESSES)

fuzz-afl: ## fuzz all harnesses with AFL++, FUZZ_SECONDS each
	$(with_afl)
	$(again) BUILD=$(BUILD)/afl CC=afl-clang-fast CFLAGS='$(FUZZ_CFLAGS)' \
	    FUZZ_WATCH='$(SANITIZE) -fno-sanitize-recover=all' FUZZ_MAIN= FUZZ_LINK='-fsanitize=fuzzer $(SANITIZE)' run-fuzz-afl

run-fuzz-afl: $(FUZZ)
	@result=0; for h in $(HARNESSES); do fuzz/afl.sh $(BUILD) $$h $(FUZZ_SECONDS) || result=1; done; exit $$result

fuzz-keep: ## put the fewest inputs that reach all that was reached into fuzz/corpus
	$(with_clang)
	$(again) $(LIBFUZZER) run-fuzz-keep

run-fuzz-keep: $(FUZZ)
	@for h in $(HARNESSES); do fuzz/keep.sh $(BUILD) $$h || exit 1; done

fuzz-reach: ## which function of the interface is called by which harness, against fuzz/README.md
	$(again) BUILD=$(BUILD)/reach CC=gcc CFLAGS='-O0 -g --coverage' run-fuzz-reach

run-fuzz-reach: $(FUZZ)
	@fuzz/reach.py $(BUILD) $(HARNESSES)

.PHONY: test-corpus harnesses fuzz fuzz-long fuzz-afl fuzz-keep fuzz-reach run-fuzz run-fuzz-long run-fuzz-afl run-fuzz-keep \
    run-fuzz-reach
