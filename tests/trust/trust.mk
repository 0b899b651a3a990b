# SPDX-FileCopyrightText: 2026 the multisap authors
# SPDX-License-Identifier: MIT
#
# Trust: targets that try to break the library. Included by the Makefile, whose lists
# and rules are used; docs/testing.md says what each has come to.
#
# A target that needs other flags makes the same rules again, in a folder of its own
# below BUILD. Variables: FUZZ_SECONDS (for each harness, 60), MACHINES (for cross).

FUZZ_SECONDS ?= 60

again = @$(MAKE) --no-print-directory -s

# ------------------------------------------------------------------- fuzzing

# A harness is linked with FUZZ_MAIN, or with what FUZZ_LINK brings instead.
HARNESSES = api alloc setups bounds prune trace $(if $(LCM_STATIC),lcm)
FUZZ = $(HARNESSES:%=$(BUILD)/fuzz/fuzz_%)
FUZZ_COMMON = fuzz/input.c fuzz/scene.c fuzz/play.c fuzz/wrong.c $(UNIT_COMMON)
FUZZ_MAIN = $(BUILD)/fuzz/plain.o
TRACE = tools/trace.c tools/player.c

$(BUILD)/fuzz/fuzz_trace: $(call objects,$(TRACE))
$(BUILD)/fuzz/fuzz_lcm.o: | $(LCM_GENERATED)
$(FUZZ): %: %.o $(call objects,$(FUZZ_COMMON)) $(FUZZ_MAIN) $(LCM_STATIC) $(STATIC)
	$(call say,ld $@)
	$(Q)$(LINK) $(FUZZ_LINK) -o $@ $(filter %.o,$^) $(LCM_STATIC) $(STATIC) $(LCM_LINK) -lm -pthread

# Only what is tried is watched, not the harnesses.
$(call objects,$(CORE) $(TRACE)) $(LCM_OBJECTS): private override CFLAGS += $(FUZZ_WATCH)

test-corpus: $(FUZZ) ## run the fuzzing harnesses over their corpora
	@result=0; for h in $(HARNESSES); do printf "$$h: "; $(BUILD)/fuzz/fuzz_$$h fuzz/corpus/$$h || result=1; done; \
	exit $$result

# libFuzzer has no option for C99's -pedantic main.
LIBFUZZER = BUILD=$(BUILD)/libfuzzer CC=clang FUZZ_MAIN= FUZZ_LINK=-fsanitize=fuzzer \
    FUZZ_WATCH=-fsanitize-coverage=inline-8bit-counters,pc-table \
    CFLAGS='-O2 -g -fsanitize=address,undefined -fno-sanitize-recover=all'

fuzz: ## fuzz all harnesses with libFuzzer, FUZZ_SECONDS each
	$(again) $(LIBFUZZER) run-fuzz

run-fuzz: $(FUZZ)
	@for h in $(HARNESSES); do tests/trust/fuzz.sh $(BUILD) $$h $(FUZZ_SECONDS) || exit 1; done

fuzz-afl: ## fuzz all harnesses with AFL++, FUZZ_SECONDS each
	$(again) BUILD=$(BUILD)/afl CC=afl-clang-fast FUZZ_MAIN= FUZZ_LINK=-fsanitize=fuzzer \
	    CFLAGS='-O2 -g -fsanitize=address,undefined -fno-sanitize-recover=all' run-fuzz-afl

run-fuzz-afl: $(FUZZ)
	@for h in $(HARNESSES); do tests/trust/afl.sh $(BUILD) $$h $(FUZZ_SECONDS) || exit 1; done

fuzz-keep: ## put the fewest inputs that reach all that was reached into fuzz/corpus
	$(again) $(LIBFUZZER) run-fuzz-keep

run-fuzz-keep: $(FUZZ)
	@for h in $(HARNESSES); do tests/trust/keep.sh $(BUILD) $$h || exit 1; done

fuzz-reach: ## which function of the interface is called by which harness, against fuzz/README.md
	$(again) BUILD=$(BUILD)/reach CFLAGS='-O0 -g --coverage' run-fuzz-reach

run-fuzz-reach: $(FUZZ)
	@tests/trust/reach.py $(BUILD) $(HARNESSES)

# ------------------------------------------------------------------ programs

# No Check, for where it cannot be linked (tests/trust/nocheck/check.h), and no LCM.
BARE = LCM=no CPPFLAGS='-Itests/trust/nocheck $(CPPFLAGS)' CHECK_LINK='-lm -pthread'
GOLDEN = tests/differential/golden.c
TRUST = tests/trust/bad_programs.c tests/trust/memory_limit.c
TRUST_PROGRAMS = $(call programs,$(TRUST) $(GOLDEN))

$(TRUST_PROGRAMS): %: %.o $(call objects,$(UNIT_COMMON)) $(STATIC)
	$(call say,ld $@)
	$(Q)$(LINK) -o $@ $(filter %.o,$^) $(STATIC) -lm -pthread

test-trust: $(call programs,$(TRUST)) ## run programs that misuse the library, or have little memory
	$(run_each)

# ---------------------------------------------------------------- sanitizers

# Everything but what is only about how long it takes.
SANITIZED = test-unit test-differential test-corpus

ubsan: ## the tests with clang's undefined-behaviour sanitizer and its stricter checks
	$(again) BUILD=$(BUILD)/ubsan CC=clang $(BARE) CFLAGS='-O1 -g -fno-sanitize-recover=all \
	    -fsanitize=undefined,float-divide-by-zero,implicit-conversion,local-bounds,nullability' $(SANITIZED) test-trust

msan: ## the tests with clang's sanitizer for uninitialized memory
	$(again) BUILD=$(BUILD)/msan CC=clang $(BARE) CFLAGS='-O1 -g -fsanitize=memory -fno-omit-frame-pointer' \
	    $(SANITIZED) test-trust

tsan: ## the tests with the thread sanitizer
	$(again) BUILD=$(BUILD)/tsan $(BARE) CFLAGS='-O1 -g -fsanitize=thread' $(SANITIZED) test-trust

# Valgrind is slow: the programs that reach most in least time.
VALGRIND_UNIT = bad_bounds batches callbacks config errors events handles limits prune user_data validate
valgrind: ## the tests with valgrind
	$(again) BUILD=$(BUILD)/valgrind $(BARE) CFLAGS='-O1 -g' run-valgrind

run-valgrind: $(VALGRIND_UNIT:%=$(BUILD)/tests/unit/test_%) $(call programs,$(DIFFERENTIAL)) $(FUZZ)
	@result=0; v='valgrind -q --error-exitcode=9 --leak-check=full'; \
	for u in $(VALGRIND_UNIT); do $$v $(BUILD)/tests/unit/test_$$u || result=1; done; \
	$$v $(BUILD)/tests/differential/differential 1 1 40 || result=1; \
	for h in $(HARNESSES); do printf "$$h: "; $$v $(BUILD)/fuzz/fuzz_$$h fuzz/corpus/$$h || result=1; done; \
	exit $$result

# ----------------------------------------------------------------- analysers

analyse: ## the core with gcc -fanalyzer, clang-tidy and cppcheck
	@tests/trust/analyse.sh $(CORE) $(LCM_BINDING) $(TOOL)

# ------------------------------------------------------------------ coverage

coverage: ## lines and branches of src/ that the tests reach
	$(again) BUILD=$(BUILD)/coverage LCM=no CFLAGS='-O0 -g --coverage' run-coverage

run-coverage: test-unit test-differential test-corpus test-trust
	@tests/trust/coverage.sh $(BUILD)

# ----------------------------------------------------------------------- ABI

abi: ## the library's ABI against src/multisap.abi, and a program of before with it
	$(again) BUILD=$(BUILD)/abi CC=gcc LCM=no CFLAGS='-O0 -g' run-abi

run-abi: $(SHARED)
	@tests/trust/abi.sh $(SHARED) $(BUILD)

abi-baseline: ## make the library's present ABI the one that is promised
	$(again) BUILD=$(BUILD)/abi CC=gcc LCM=no CFLAGS='-O0 -g' run-abi-baseline

run-abi-baseline: $(SHARED)
	@tests/trust/abi.sh $(SHARED) > src/multisap.abi

# ------------------------------------------------------------ other machines

MACHINES ?= i386 aarch64 armhf s390x musl
i386_CC = i686-linux-gnu-gcc
i386_RUN = qemu-i386
aarch64_CC = aarch64-linux-gnu-gcc
aarch64_RUN = qemu-aarch64
armhf_CC = arm-linux-gnueabihf-gcc
armhf_RUN = qemu-arm
s390x_CC = s390x-linux-gnu-gcc
s390x_RUN = qemu-s390x
musl_CC = musl-gcc

# What is worth an emulator's time.
CROSS_UNIT = bad_bounds batches config doubles errors events golden_events handles limits numbers prune touching_boxes

cross: $(MACHINES:%=cross-%) ## the tests on other machines, emulated, and with another C library

cross-%:
	@echo '--- $*'
	$(again) BUILD=$(BUILD)/$* CC=$($*_CC) RUN=$($*_RUN) $(BARE) CFLAGS='-O2 -g' LDFLAGS=-static run-cross

run-cross: $(CROSS_UNIT:%=$(BUILD)/tests/unit/test_%) $(call programs,$(DIFFERENTIAL) $(GOLDEN)) $(FUZZ)
	@tests/trust/cross.sh '$(RUN)' $(BUILD) '$(CROSS_UNIT)' '$(HARNESSES)'

# ----------------------------------------------------------------- all of it

TRUST_SUITES = corpus trust
TRUST_TARGETS = asan ubsan msan tsan valgrind analyse coverage fuzz-reach abi cross fuzz
trust: ## all of these, and a summary
	@failed=; for target in $(TRUST_SUITES:%=test-%) $(TRUST_TARGETS); do echo "--- $$target"; \
	    $(MAKE) --no-print-directory -s $$target || failed="$$failed $$target"; done; \
	echo "failed:$${failed:- none}"; [ -z "$$failed" ]

.PHONY: fuzz fuzz-afl fuzz-keep fuzz-reach ubsan msan tsan valgrind analyse coverage abi abi-baseline cross trust \
    $(MACHINES:%=cross-%) $(TRUST_SUITES:%=test-%) run-fuzz run-fuzz-afl run-fuzz-keep run-fuzz-reach run-valgrind \
    run-coverage run-abi run-abi-baseline run-cross
