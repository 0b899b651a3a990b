# SPDX-FileCopyrightText: 2026 the multisap authors
# SPDX-License-Identifier: MIT
#
# Accuracy: speed against error, as the report in docs/accuracy; and whether every
# compiler and machine gives the same events. Included by the Makefile, whose rules are
# used.
#
# Variables: CXX and CXXFLAGS (for the libraries beside ours), ACCURACY (the report's
# folder), ACCURACY_FLAGS (for run.py: --help tells).

CXX ?= c++
CXXFLAGS ?= $(CFLAGS)
ACCURACY ?= docs/accuracy

# ---------------------------------------------------------- speed against error

# A library beside ours is measured where the header of its Debian package is found.
bullet_HEADER = bullet/btBulletCollisionCommon.h
bullet_FLAGS = -isystem /usr/include/bullet
bullet_LIBRARIES = -lBulletCollision -lLinearMath
ode_HEADER = ode/ode.h
ode_LIBRARIES = -lode
fcl_HEADER = fcl/fcl.h
fcl_FLAGS = -isystem /usr/include/eigen3
fcl_LIBRARIES = -lfcl -lccd -loctomap -loctomath
cgal_HEADER = CGAL/box_intersection_d.h
cgal_FLAGS = -frounding-math
cgal_LIBRARIES = -lgmp -lmpfr
PEERS := $(foreach peer,bullet ode fcl cgal,$(if $(wildcard /usr/include/$($(peer)_HEADER)),$(peer)))

IN_ACCURACY = $(BUILD)/bench/accuracy
ACCURACY_COMMON = $(patsubst %,$(IN_ACCURACY)/%.o,main scene oracle)
ACCURACY_PROGRAMS = $(patsubst %,$(IN_ACCURACY)/%,ours $(PEERS))

$(IN_ACCURACY)/%.o: bench/accuracy/%.cpp $(BUILD)/settings
	@mkdir -p $(@D)
	$(call say,c++ $<)
	$(Q)$(CXX) -std=c++17 -Wall -Wextra $($*_FLAGS) -DNDEBUG $(CPPFLAGS) $(CXXFLAGS) -MMD -MP -c $< -o $@

$(ACCURACY_PROGRAMS): $(IN_ACCURACY)/%: $(IN_ACCURACY)/%.o $(ACCURACY_COMMON) $(STATIC)
	$(call say,ld $@)
	$(Q)$(CXX) $(CXXFLAGS) $(LDFLAGS) -o $@ $(filter %.o,$^) $(STATIC) $($*_LIBRARIES) -lm

$(IN_ACCURACY)/narrow: %: %.o
	$(call say,ld $@)
	$(Q)$(LINK) -o $@ $< -lm

# A Python that has matplotlib: the one in PATH, or Debian's own.
PYTHON_PLOT = PYTHONDONTWRITEBYTECODE=1 $(shell python3 -c 'import matplotlib' 2>/dev/null && echo python3 \
    || echo /usr/bin/python3)
RUN_ACCURACY = @$(PYTHON_PLOT) bench/accuracy/run.py --out $(ACCURACY) --flags '$(CFLAGS)' --compiler '$(CC)' \
    $(ACCURACY_FLAGS) $(IN_ACCURACY) ours $(PEERS)

accuracy: $(ACCURACY_PROGRAMS) $(IN_ACCURACY)/narrow ## measure speed against error, write docs/accuracy
	$(RUN_ACCURACY)

accuracy-redraw: ## write docs/accuracy anew from the last run of accuracy
	$(RUN_ACCURACY) --redraw

# ------------------------------------------------------------- the same events

portable: ## the same events from every compiler, option, vector unit and emulated machine
	@tests/differential/portable.sh $(BUILD)/portable

.PHONY: accuracy accuracy-redraw portable
