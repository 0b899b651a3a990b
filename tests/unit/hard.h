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
#include <stdint.h>
#ifdef __SSE2__
#include <xmmintrin.h>
#endif

/* The bits of flush-to-zero and denormals-are-zero, where the machine has them: those
 * that are on, and a switch for all. */
#if defined(__SSE2__)
#define FLUSH_BITS 0x8040u
static inline unsigned flush_bits(void)
{
    return _mm_getcsr() & FLUSH_BITS;
}
static inline void set_flushing(int on)
{
    _mm_setcsr((_mm_getcsr() & ~FLUSH_BITS) | (on ? FLUSH_BITS : 0));
}
#elif defined(__aarch64__)
#define FLUSH_BITS 0x1000000u
static inline uint64_t float_control(void)
{
    uint64_t control;
    __asm__ volatile("mrs %0, fpcr" : "=r"(control));
    return control;
}
static inline unsigned flush_bits(void)
{
    return (unsigned)float_control() & FLUSH_BITS;
}
static inline void set_flushing(int on)
{
    uint64_t control = (float_control() & ~(uint64_t)FLUSH_BITS) | (on ? FLUSH_BITS : 0);
    __asm__ volatile("msr fpcr, %0" : : "r"(control));
}
#else
#define FLUSH_BITS 0u
static inline unsigned flush_bits(void)
{
    return 0;
}
static inline void set_flushing(int on)
{
    (void)on;
}
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
#if defined(__SSE2__) || defined(__aarch64__)
    {"flushing to zero", FE_TONEAREST, 1},
    {"rounding up and flushing to zero", FE_UPWARD, 1},
#endif
};

#define ENVIRONMENTS (sizeof environments / sizeof *environments)

static inline void environment_enter(const environment *e)
{
    ck_assert_int_eq(fesetround(e->rounding), 0);
    set_flushing(e->flushes);
}

/* The library must have left the environment alone. */
static inline void environment_leave(const environment *e)
{
    ck_assert_int_eq(fegetround(), e->rounding);
    ck_assert_uint_eq(flush_bits(), e->flushes ? FLUSH_BITS : 0);
    set_flushing(0);
    ck_assert_int_eq(fesetround(FE_TONEAREST), 0);
}

#endif
