# SPDX-FileCopyrightText: 2026 the multisap authors
# SPDX-License-Identifier: MIT
#
# The short way in: the library, the command and the tests, with make and a C
# compiler. meson.build is the full build; tests/build compares the two.
#
# Variables: BUILD (output folder), CC, CFLAGS, CPPFLAGS, LDFLAGS, PREFIX, DESTDIR,
# LCM=no (do without LCM where it is installed), V=1 (show the commands).

BUILD ?= build
CFLAGS ?= -O2 -g
PREFIX ?= /usr/local
.DEFAULT_GOAL := all

# ------------------------------------------------------------------- sources

CORE = src/axis.c src/box.c src/calm.c src/candidates.c src/cell.c src/change.c src/choose.c src/commit.c \
    src/compare.c src/grid.c src/grid_check.c src/jump.c src/kept.c src/layout.c src/memory.c src/merge.c \
    src/move.c src/near.c src/number.c src/pairs.c src/partners.c src/phase.c src/pool.c src/prune.c \
    src/prune_api.c src/ranges.c src/read.c src/rebuild.c src/renew.c src/rest.c src/restless.c src/rows.c \
    src/sap.c src/settle.c src/share.c src/shift.c src/simd.c src/skin.c src/slide.c src/sort.c src/status.c \
    src/touch.c src/track.c src/update.c src/validate.c src/wide.c src/world.c
TOOL = tools/main.c tools/player.c tools/replay.c tools/setup.c tools/stream.c tools/trace.c \
    examples/thread_pool.c
LCM_BINDING = bindings/lcm/multisap_lcm.c
LCM_TYPES = bindings/lcm/pair_events_t.lcm

UNIT = $(wildcard tests/unit/test_*.c)
UNIT_COMMON = tests/unit/common.c tests/unit/setups.c examples/thread_pool.c
DIFFERENTIAL = tests/differential/differential.c
LCM_TEST = tests/command/test_lcm.c
EXAMPLES = examples/game_loop.c
SCENE = tests/scenes/jolt_ragdolls.trace

# ------------------------------------------------------------- what is built

version_part = $(shell sed -n 's/^.define MSAP_VERSION_$(1) //p' include/multisap.h)
VERSION := $(call version_part,MAJOR).$(call version_part,MINOR).$(call version_part,PATCH)
SOVERSION = 0

STATIC = $(BUILD)/libmultisap.a
SHARED = $(BUILD)/libmultisap.so.$(VERSION)
COMMAND = $(BUILD)/multisap
LIBRARIES = $(STATIC) $(SHARED)

objects = $(patsubst %.c,$(BUILD)/%.o,$(1))
programs = $(patsubst %.c,$(BUILD)/%,$(1))

# LCM is used where a program links with it and its code generator is there.
# (Debian's lcm.pc needs a package that liblcm-dev does not, so pkg-config would
# not find it; and its lcm-gen goes before one that a Python environment brings.)
LCM_GEN ?= $(firstword $(wildcard /usr/bin/lcm-gen) lcm-gen)
LCM ?= $(shell echo 'int main(void) { return lcm_create(0) != 0; }' \
    | $(CC) $(CPPFLAGS) -include lcm/lcm.h -x c - -o /dev/null $(LDFLAGS) -llcm 2>/dev/null \
    && command -v $(LCM_GEN) >/dev/null && echo yes || echo no)
LCM := $(LCM)

ifeq ($(LCM),yes)
LCM_STATIC = $(BUILD)/libmultisap-lcm.a
LCM_SHARED = $(BUILD)/libmultisap-lcm.so.$(VERSION)
LIBRARIES += $(LCM_STATIC) $(LCM_SHARED)
LCM_FLAGS = -DMSAP_WITH_LCM -Ibindings/lcm -I$(BUILD)/lcm
LCM_GENERATED = $(patsubst bindings/lcm/%.lcm,$(BUILD)/lcm/msap_%.c,$(LCM_TYPES))
LCM_OBJECTS = $(call objects,$(LCM_BINDING)) $(LCM_GENERATED:.c=.o)
LCM_LINK = -llcm
LCM_PROGRAM = $(call programs,$(LCM_TEST))
INSTALL_LCM = install-lcm
endif

TEST_PROGRAMS = $(call programs,$(UNIT) $(DIFFERENTIAL) $(EXAMPLES)) $(LCM_PROGRAM)

COMPILE = $(CC) -std=c99 -pedantic -Wall -Wextra -fPIC -fvisibility=hidden -Iinclude $(LCM_FLAGS) \
    $(CPPFLAGS) $(CFLAGS) -MMD -MP
LINK = $(CC) $(CFLAGS) $(LDFLAGS)
CHECK_LINK = $(shell pkg-config --libs check 2>/dev/null || echo -lcheck) -lm -pthread

# A line for each step; with V=1 the command itself, with make -s nothing.
Q = $(if $(V),,@)
say = $(if $(V)$(findstring s,$(firstword -$(MAKEFLAGS))),,@echo '  $(1)')

# ------------------------------------------------------------------- targets

all: lib tool ## build the libraries and the command (the default)

lib: $(LIBRARIES) ## build the libraries alone

tool: $(COMMAND) ## build the command, build/multisap

run: ## install what is missing, build, stream a recorded scene over LCM
	@.ci/setup run
	@$(MAKE) --no-print-directory tool
	@$(COMMAND) stream $(SCENE)

check: ## install what is missing, build, run all tests
	@.ci/setup check
	@$(MAKE) --no-print-directory test

SUITES = asan-unit build python unit asan-rest trust differential command examples corpus abi

# Two suites at a time, the longest first; what they share is built before. What a suite prints comes
# when it has ended, in one piece.
test: ## run all tests, set nothing up
	-@$(MAKE) -s -k -j 2 programs asan-programs
	@rm -f $(BUILD)/results; printf '%s\n' $(SUITES) | xargs -P 2 -I SUITE sh -c \
	    'said=$$($(MAKE) -s test-SUITE 2>&1) && result=passed || result=FAILED; \
	    printf "%s\n" "--- SUITE" "$$said"; echo "$$result SUITE" >> $(BUILD)/results'; \
	cat $(BUILD)/results; failed=$$(grep -c FAILED $(BUILD)/results); \
	echo "$$(grep -c passed $(BUILD)/results) passed, $$failed failed"; [ $$failed = 0 ]

test-unit: $(call programs,$(UNIT)) ## run the unit tests
	$(run_each)

test-differential: $(call programs,$(DIFFERENTIAL)) ## compare random scenes with brute force
	$(run_each)

test-command: $(COMMAND) $(LCM_PROGRAM) ## run the tests of the command and of the LCM binding
	@result=0; for program in $(LCM_PROGRAM); do $$program || result=1; done; \
	MULTISAP=$(abspath $(COMMAND)) $(PYTEST) tests/command && exit $$result

test-examples: $(call programs,$(EXAMPLES)) ## run the examples
	$(run_each)

# The package as a user installs it, in an environment of its own, with what its tests need.
PYTHON ?= python3
PYTHON_ENV = $(BUILD)/python
PYTHON_FILES = pyproject.toml meson.build meson_options.txt include/multisap.h docs/python.md $(CORE) \
    bindings/python/meson.build $(wildcard bindings/python/multisap/*.py)

$(PYTHON_ENV)/installed: $(PYTHON_FILES)
	$(call say,pip install .)
	$(Q)$(PYTHON) -m venv $(PYTHON_ENV) && $(PYTHON_ENV)/bin/pip -q --disable-pip-version-check install '.[test]'
	@touch $@

test-python: $(COMMAND) $(PYTHON_ENV)/installed ## test the Python package, installed as a user installs it
	@MULTISAP=$(abspath $(COMMAND)) PYTHONDONTWRITEBYTECODE=1 $(PYTHON_ENV)/bin/python -m pytest -q \
	    -p no:cacheprovider bindings/python/tests

test-build: ## test the build itself: lists, symbols, headers, installation
	@$(PYTEST) tests/build

# In one process a program, since what is watched takes long to fork; native runs fork. Without the leak
# checker: every world of the tests has an allocator that counts what comes back; and with 16 MB for
# what was freed. Brute force is not watched: it is faster without.
ASAN = CK_FORK=no ASAN_OPTIONS=detect_leaks=0:quarantine_size_mb=16 $(MAKE) -k -O --no-print-directory BUILD=$(BUILD)/asan \
    LDFLAGS='$(LDFLAGS)' \
    CFLAGS='-O1 -g -fsanitize=address,undefined -fno-sanitize-recover=all -fno-omit-frame-pointer' \
    REFERENCE_FLAGS='-O3 -fno-sanitize=all'
ASAN_REST = test-differential test-command test-examples

asan: ## run the tests with the address and undefined-behaviour sanitizers
	+@$(ASAN) test-unit $(ASAN_REST)

asan-programs:
	+@$(ASAN) test-programs

test-asan-unit:
	+@$(ASAN) test-unit

test-asan-rest:
	+@$(ASAN) $(ASAN_REST)

# A Python that has pytest: the one in PATH, or Debian's own.
PYTEST = PYTHONDONTWRITEBYTECODE=1 $(shell python3 -c 'import pytest' 2>/dev/null && echo python3 \
    || echo /usr/bin/python3) -m pytest -q -p no:cacheprovider

# Two at a time; what a program prints comes when it has ended, in one piece.
run_each = @printf '%s\n' $^ | xargs -P 2 -I PROGRAM sh -c \
    'said=$$(PROGRAM 2>&1); result=$$?; printf "%s\n" "$$said"; exit $$result'

TO = $(DESTDIR)$(PREFIX)

install: all $(INSTALL_LCM) ## install below PREFIX (/usr/local), with DESTDIR before it
	install -d $(TO)/bin $(TO)/include $(TO)/lib/pkgconfig $(TO)/share/man/man1
	install $(COMMAND) $(TO)/bin
	install -m 644 include/multisap.h $(TO)/include
	install -m 644 docs/multisap.1 $(TO)/share/man/man1
	cp -P $(STATIC) $(SHARED:.$(VERSION)=)* $(TO)/lib
	$(call write_pc,multisap,Which axis-aligned boxes overlap and what changed,)

install-lcm: all
	install -d $(TO)/include $(TO)/lib/pkgconfig $(TO)/share/multisap
	install -m 644 bindings/lcm/multisap_lcm.h $(TO)/include
	install -m 644 $(LCM_TYPES) $(TO)/share/multisap
	cp -P $(LCM_STATIC) $(LCM_SHARED:.$(VERSION)=)* $(TO)/lib
	$(call write_pc,multisap-lcm,Pair events of multisap over LCM,multisap)

# write_pc NAME,DESCRIPTION,REQUIRED PACKAGES
write_pc = @printf '%s\n' 'prefix=$(PREFIX)' 'includedir=$${prefix}/include' 'libdir=$${prefix}/lib' '' \
    'Name: $(1)' 'Description: $(2)' 'Version: $(VERSION)' 'Requires: $(3)' \
    'Libs: -L$${libdir} -l$(1) $(if $(3),$(LCM_LINK))' 'Cflags: -I$${includedir}' > $(TO)/lib/pkgconfig/$(1).pc

clean: ## remove what was built
	rm -rf $(BUILD) *.lcmlog

help: ## list the targets
	@sed -n 's/^\([a-z -]*\):.*## /\1	/p' $(MAKEFILE_LIST) | expand -t 20

# ------------------------------------------------------------------ building

# The flags and lists of the last build: what depends on them is made anew when
# they change, as they do when LCM comes to be installed.
SETTINGS = $(COMPILE) $(LINK) $(CORE) $(TOOL) $(LCM_OBJECTS)
$(BUILD)/settings: FORCE
	@mkdir -p $(@D)
	@echo '$(SETTINGS)' | cmp -s - $@ || echo '$(SETTINGS)' > $@

$(BUILD)/%.o: %.c $(BUILD)/settings
	@mkdir -p $(@D)
	$(call say,cc $<)
	$(Q)$(COMPILE) -c $< -o $@

# Tests spend their time in the library and in brute force: they are not worth optimizing.
TEST_FLAGS ?= -O0
$(BUILD)/tests/unit/test_%.o: private override CFLAGS += $(TEST_FLAGS)

# Brute force goes by columns, which a compiler makes vectors of if asked to.
REFERENCE_FLAGS ?= -O3
$(BUILD)/tests/unit/common.o: private override CFLAGS += $(REFERENCE_FLAGS)

# lcm-gen ends with 0 when it fails, so its output is looked for; what it writes
# is not ours to warn about.
$(BUILD)/lcm/msap_%.c $(BUILD)/lcm/msap_%.h: bindings/lcm/%.lcm $(BUILD)/settings
	@mkdir -p $(@D)
	$(call say,lcm-gen $<)
	@rm -f $@
	$(Q)$(LCM_GEN) --c --c-cpath $(@D) --c-hpath $(@D) $< && test -f $@

$(BUILD)/lcm/%.o: $(BUILD)/lcm/%.c
	$(call say,cc $<)
	$(Q)$(COMPILE) -w -c $< -o $@

$(call objects,$(LCM_BINDING) $(TOOL) $(LCM_TEST)): | $(LCM_GENERATED)

$(STATIC): $(call objects,$(CORE))
$(LCM_STATIC): $(LCM_OBJECTS)
$(STATIC) $(LCM_STATIC): $(BUILD)/settings
	$(call say,ar $@)
	@rm -f $@
	$(Q)$(AR) rcs $@ $(filter %.o,$^)

$(SHARED): $(call objects,$(CORE))
$(LCM_SHARED): $(LCM_OBJECTS) $(SHARED)
$(LCM_SHARED): LINK_WITH = $(LCM_LINK)
$(SHARED) $(LCM_SHARED): %.so.$(VERSION): src/multisap.map
	$(call say,ld $@)
	$(Q)$(LINK) -shared -Wl,-z,defs -Wl,-soname,$(*F).so.$(SOVERSION) -Wl,--version-script=src/multisap.map \
	    -o $@ $(filter-out %.map,$^) $(LINK_WITH)
	@ln -sf $(@F) $*.so.$(SOVERSION) && ln -sf $(@F) $*.so

$(COMMAND): $(call objects,$(TOOL))
$(COMMAND): LINK_WITH = $(LCM_LINK) -lm -pthread
$(TEST_PROGRAMS): %: %.o
$(call programs,$(UNIT) $(DIFFERENTIAL)): $(call objects,$(UNIT_COMMON))
$(call programs,$(UNIT)): LINK_WITH = $(CHECK_LINK)
$(call programs,$(DIFFERENTIAL)): LINK_WITH = -lm -pthread
$(LCM_PROGRAM): LINK_WITH = $(LCM_LINK) $(CHECK_LINK)
$(COMMAND) $(TEST_PROGRAMS): $(LCM_STATIC) $(STATIC)
	$(call say,ld $@)
	$(Q)$(LINK) -o $@ $(filter %.o,$^) $(LCM_STATIC) $(STATIC) $(LINK_WITH)

include bench/bench.mk bench/accuracy/accuracy.mk tests/trust/trust.mk

programs: test-programs harnesses $(TRUST_PROGRAMS) ## build all that is run by tests

test-programs: all $(TEST_PROGRAMS)

FORCE:
.PHONY: all lib tool run check test programs test-programs asan asan-programs install install-lcm clean help FORCE \
    $(SUITES:%=test-%)
.SECONDARY:
-include $(wildcard $(BUILD)/*/*.d $(BUILD)/*/*/*.d)
