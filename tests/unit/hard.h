/* SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT
 *
 * Environments: the modes that a host may have set its floating point to, as game
 * engines do and -ffast-math at link. The answers must be the same in all of them.
 *
 * Within one, a test's own float arithmetic is not to be trusted; to copy floats and
 * to make them of small integers is safe.
 */
#ifndef HARD_H
#define HARD_H

#include <check.h>
#include <fenv.h>
#include <stddef.h>
#ifdef __SSE2__
#include <xmmintrin.h>
#endif

typedef struct environment {
    const char *name;
    int rounding; /* as fesetround takes it */
    int flushes;  /* 1: subnormal results and operands are 0 */
} environment;

static const environment environments[] = {
    {"rounding to nearest", FE_TONEAREST, 0},
#ifdef FE_DOWNWARD
    {"rounding down", FE_DOWNWARD, 0},
#endif
#ifdef FE_UPWARD
    {"rounding up", FE_UPWARD, 0},
#endif
#ifdef FE_TOWARDZERO
    {"rounding towards zero", FE_TOWARDZERO, 0},
#endif
#ifdef __SSE2__
    {"flushing to zero", FE_TONEAREST, 1},
    {"rounding up and flushing to zero", FE_UPWARD, 1},
#endif
};

#define ENVIRONMENTS (sizeof environments / sizeof *environments)

static inline void environment_enter(const environment *e)
{
    ck_assert_int_eq(fesetround(e->rounding), 0);
#ifdef __SSE2__
    if (e->flushes)
        _mm_setcsr(_mm_getcsr() | 0x8040);
#endif
}

/* The library must have left the environment alone. */
static inline void environment_leave(const environment *e)
{
    ck_assert_int_eq(fegetround(), e->rounding);
#ifdef __SSE2__
    ck_assert_uint_eq(_mm_getcsr() & 0x8040, e->flushes ? 0x8040 : 0);
    _mm_setcsr(_mm_getcsr() & ~0x8040u);
#endif
    ck_assert_int_eq(fesetround(FE_TONEAREST), 0);
}

#endif
