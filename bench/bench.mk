# SPDX-FileCopyrightText: 2026 the multisap authors
# SPDX-License-Identifier: MIT
#
# Programs that measure, and what they write into docs/. Included by the Makefile.

BENCH_COMMON = bench/bench.c bench/library.c bench/scene.c examples/thread_pool.c
CLAIMS = bench/claims.c bench/claim_axes.c bench/claim_batches.c bench/claim_cells.c bench/claim_pairs.c \
    bench/claim_parallel.c bench/claim_pruning.c bench/claim_queues.c bench/claim_scaling.c \
    bench/claim_statics.c bench/film.c bench/pair_set.c bench/paper_sap.c
STRATEGIES = bench/strategies.c
SPEED = bench/speed.c
REPLAY = bench/replay.c bench/accuracy/main.c bench/accuracy/oracle.c bench/accuracy/scene.c
BENCH_PROGRAMS = $(BUILD)/bench/claims $(BUILD)/bench/strategies $(BUILD)/bench/speed

claims: $(BUILD)/bench/claims ## measure the paper's claims, write docs/claims.md
	@CC='$(CC)' CFLAGS='$(CFLAGS)' $(PYTHON) bench/claims.py measure $< $(CLAIMS) $(BENCH_COMMON) \
	    > $(BUILD)/bench/claims.tsv
	@$(PYTHON) bench/claims.py write $(BUILD)/bench/claims.tsv > docs/claims.md

# The peers are those of the accuracy report, where their packages are installed.
bench: $(BUILD)/bench/speed $(BUILD)/bench/replay ## measure speed and memory beside peers, write docs/performance.md
	@$(if $(PEERS),$(MAKE) --no-print-directory $(PEERS:%=$(IN_ACCURACY)/%))
	@CC='$(CC)' CFLAGS='$(CFLAGS)' $(PYTHON_PLOT) bench/speed.py $(BENCH_FLAGS) $(BUILD)/bench/speed \
	    $(BUILD)/bench/replay $(PEERS:%=$(IN_ACCURACY)/%)

strategies: $(BUILD)/bench/strategies ## measure what the choice among the ways of a commit rests on
	@$<

$(BUILD)/bench/claims: $(call objects,$(CLAIMS))
$(BUILD)/bench/strategies: $(call objects,$(STRATEGIES))
$(BUILD)/bench/speed: $(call objects,$(SPEED))
$(BENCH_PROGRAMS): $(call objects,$(BENCH_COMMON)) $(STATIC)
	$(call say,ld $@)
	$(Q)$(LINK) -o $@ $(filter %.o,$^) $(STATIC) -lm -pthread

$(BUILD)/bench/replay: $(call objects,$(REPLAY) examples/thread_pool.c) $(STATIC)
	$(call say,ld $@)
	$(Q)$(LINK) -o $@ $(filter %.o,$^) $(STATIC) -lm -pthread

.PHONY: bench claims strategies
