# SPDX-FileCopyrightText: 2026 the multisap authors
# SPDX-License-Identifier: MIT
#
# Trust: targets that try to break the library. Included by the Makefile, whose lists
# and rules are used; docs/testing.md says what each has come to.
#
# A target that needs other flags makes the same rules again, in a folder of its own
# below BUILD. Variables: MACHINES (for cross); see also fuzz/fuzz.mk.

again = @$(MAKE) --no-print-directory -s

include fuzz/fuzz.mk

# ------------------------------------------------------------------ programs

# No Check, for where it cannot be linked (tests/trust/nocheck/check.h), and no LCM.
BARE = LCM=no CPPFLAGS='-Itests/trust/nocheck $(CPPFLAGS)' CHECK_LINK='-lm -pthread'
GOLDEN = tests/differential/golden.c
TRUST = tests/trust/bad_programs.c tests/trust/memory_limit.c
TRUST_PROGRAMS = $(call programs,$(TRUST) $(GOLDEN))

$(TRUST_PROGRAMS): %: %.o $(call objects,$(UNIT_COMMON)) $(STATIC)
	$(call say,ld $@)
	$(Q)$(LINK) -o $@ $(filter %.o,$^) $(STATIC) -lm -pthread

test-trust: $(call programs,$(TRUST)) ## run programs that misuse the library or give it little memory
	$(run_each)

# ---------------------------------------------------------------- sanitizers

# The tests without Check, so that the sanitizer sees all code that runs; then, in another
# folder, what compares with brute force, without SSE2: the portable half of the code.
# sanitize FOLDER,COMPILER,FLAGS,TARGETS
define sanitize
$(again) BUILD=$(BUILD)/$(1) CC=$(2) $(BARE) CFLAGS='-O1 -g -fno-omit-frame-pointer $(3)' $(4)
$(again) BUILD=$(BUILD)/$(1)-portable CC=$(2) $(BARE) CFLAGS='-O1 -g -fno-omit-frame-pointer $(3) -U__SSE2__' \
    test-differential test-corpus
endef

# What reaches most in least time, run by RUN (empty: directly): unit tests, bad programs,
# the golden hash of the events, a round of comparison with brute force, the corpora.
QUICK = bad_bounds batches callbacks config errors events handles limits prune regressions user_data validate
QUICK_PROGRAMS = $(QUICK:%=unit/test_%) trust/bad_programs differential/golden differential/differential
run-quick: $(QUICK_PROGRAMS:%=$(BUILD)/tests/%) $(FUZZ)
	@result=0; \
	for p in $(QUICK_PROGRAMS:%/differential=%/differential\ 1\ 1\ 40); do $(RUN) $(BUILD)/tests/$$p || result=1; done; \
	for h in $(HARNESSES); do printf "$$h: "; $(RUN) $(BUILD)/fuzz/fuzz_$$h fuzz/corpus/$$h || result=1; done; \
	exit $$result

ubsan: ## the tests with clang's undefined-behaviour sanitizer and its stricter checks
	$(call sanitize,ubsan,clang,$(UBSAN),test-unit test-differential test-corpus test-trust)

UBSAN = -fno-sanitize-recover=all \
    -fsanitize=undefined,float-divide-by-zero,implicit-conversion,local-bounds,nullability

msan: ## the tests with clang's sanitizer for uninitialized memory
	$(call sanitize,msan,clang,-fsanitize=memory,run-quick test-differential)

# Only tests that have threads say anything here.
THREADED_UNIT = golden_events memory strategies threads workers
tsan: ## the tests that have threads with the thread sanitizer
	$(call sanitize,tsan,gcc,-fsanitize=thread,run-threaded test-differential test-corpus)

run-threaded: $(THREADED_UNIT:%=$(BUILD)/tests/unit/test_%)
	$(run_each)

valgrind: ## a part of the tests with valgrind
	$(again) BUILD=$(BUILD)/valgrind RUN='valgrind -q --error-exitcode=9 --leak-check=full' $(BARE) CFLAGS='-O1 -g' \
	    run-quick

# ----------------------------------------------------------------- analysers

analyse: $(LCM_GENERATED) ## the code with gcc -fanalyzer, clang-tidy and cppcheck
	@tests/trust/analyse.sh '-Iinclude $(LCM_FLAGS)' $(CORE) $(if $(LCM_STATIC),$(LCM_BINDING)) $(TOOL)

# ------------------------------------------------------------------ coverage

# With SSE2 and without: what either reaches is reached. Only what is counted is built
# without optimization; the tests, which take most of the time, are not counted.
# cover FOLDER,FLAGS,TARGETS
define cover
$(again) -j2 -O BUILD=$(BUILD)/$(1) LCM=no CFLAGS='-O2 -g $(2)' LDFLAGS=--coverage \
    FUZZ_WATCH='-O0 --coverage -fprofile-update=atomic -DALWAYS_INLINE=inline' $(3)
endef

coverage: ## lines and branches of src/ that the tests reach, of which none may be missing
	@rm -f $(BUILD)/coverage/src/*.gcda $(BUILD)/coverage-portable/src/*.gcda
	$(call cover,coverage,,test-unit)
	$(call cover,coverage,,run-limited test-differential test-corpus)
	$(call cover,coverage-portable,-U__SSE2__,run-portable test-differential test-corpus)
	@tests/trust/coverage.sh $(BUILD)/coverage $(BUILD)/coverage-portable

# What reaches those portable halves that take a lack of memory, boxes far away, very many, or in skins.
run-portable: $(patsubst %,$(BUILD)/tests/unit/test_%,far_boxes kept_rows many_boxes memory renewing restless)
	$(run_each)

# Test-trust with a smaller pair explosion, in which each box is compared with each.
run-limited: $(call programs,$(TRUST))
	@$(BUILD)/tests/trust/bad_programs
	@$(BUILD)/tests/trust/memory_limit 6000

# ----------------------------------------------------------------------- ABI

abi test-abi: ## the library's ABI against src/multisap.abi, and programs of before with one of later
	$(again) BUILD=$(BUILD)/abi CC=gcc LCM=no CFLAGS='-O0 -g' run-abi

run-abi: $(SHARED)
	@tests/trust/abi.sh $(SHARED) $(BUILD)
	@tests/trust/later.sh $(BUILD) '$(CC)' $(CORE)

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

cross: $(MACHINES:%=cross-%) ## a part of the tests on other machines, emulated, and with another C library

$(MACHINES:%=cross-%): cross-%:
	@echo '--- $*'
	$(again) BUILD=$(BUILD)/$* CC=$($*_CC) RUN=$($*_RUN) $(BARE) CFLAGS='-O2 -g -D_FILE_OFFSET_BITS=64' \
	    LDFLAGS=-static run-quick

# ----------------------------------------------------------------- all of it

TRUST_TARGETS = test-corpus test-trust test-abi asan ubsan msan tsan valgrind analyse coverage fuzz-reach cross \
    portable fuzz
trust: ## all of these, and a summary
	@failed=; for target in $(TRUST_TARGETS); do echo "--- $$target"; \
	    $(MAKE) --no-print-directory -s $$target || failed="$$failed $$target"; done; \
	echo "failed:$${failed:- none}"; [ -z "$$failed" ]

.PHONY: ubsan msan tsan valgrind analyse coverage abi abi-baseline cross trust test-trust test-abi \
    $(MACHINES:%=cross-%) run-quick run-threaded run-portable run-limited run-abi run-abi-baseline
