/* SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT
 *
 * Guards: msap_encode_float keeps the order of the floats, zeros of both signs being
 * one, NaNs beyond the infinities; msap_decode_float takes it back.
 */
#include "checks.h"

/* In ascending order, each above the one before. */
static const uint32_t ascending[] = {
    0xFF800000, 0xFF7FFFFF, 0xFF7FFFFE, 0xC0000000, 0xBF800001, 0xBF800000, 0xBF7FFFFF, 0x80800001, 0x80800000,
    0x807FFFFF, 0x80000002, 0x80000001, 0x00000000, 0x00000001, 0x00000002, 0x007FFFFF, 0x00800000, 0x00800001,
    0x3F7FFFFF, 0x3F800000, 0x3F800001, 0x40000000, 0x7F7FFFFE, 0x7F7FFFFF, 0x7F800000,
};

static uint32_t code_of(uint32_t bits)
{
    return msap_encode_float(float_of(bits));
}

START_TEST(special_values_keep_their_order)
{
    size_t i;
    for (i = 0; i < COUNT(ascending); i++) {
        if (i)
            ck_assert_uint_lt(code_of(ascending[i - 1]), code_of(ascending[i]));
        ck_assert_uint_eq(bits_of(msap_decode_float(code_of(ascending[i]))), ascending[i]);
    }
}
END_TEST

START_TEST(zeros_are_one)
{
    ck_assert_uint_eq(code_of(0x80000000), code_of(0x00000000));
    ck_assert_uint_eq(bits_of(msap_decode_float(code_of(0x80000000))), 0x00000000);
}
END_TEST

/* By sign above +inf or below -inf, whatever the payload. (Quiet ones: a signalling
 * NaN may be made quiet on its way into a function.) */
START_TEST(nans_are_beyond_the_infinities)
{
    uint32_t payload;
    for (payload = 0; payload < 0x400000; payload += 0x3FFFF) {
        ck_assert_uint_gt(code_of(0x7FC00000 | payload), code_of(0x7F800000));
        ck_assert_uint_lt(code_of(0xFFC00000 | payload), code_of(0xFF800000));
    }
}
END_TEST

/* The ends of the range are no number's, as sentinels need it. */
START_TEST(no_number_is_at_an_end)
{
    ck_assert_uint_gt(code_of(0xFF800000), 0);
    ck_assert_uint_lt(code_of(0x7F800000), UINT32_MAX);
}
END_TEST

static int is_nan(uint32_t bits)
{
    return (bits & 0x7FFFFFFF) > 0x7F800000;
}

START_TEST(random_bits_keep_their_order)
{
    uint64_t random = 1;
    int i;
    for (i = 0; i < 200000; i++) {
        uint32_t a = (uint32_t)random_next(&random);
        uint32_t b = i % 2 ? (uint32_t)random_next(&random) : a + random_below(&random, 5) - 2;
        if (is_nan(a) || is_nan(b))
            continue;
        ck_assert_int_eq(float_of(a) < float_of(b), code_of(a) < code_of(b));
        ck_assert_int_eq(float_of(a) == float_of(b), code_of(a) == code_of(b));
        if (a != 0x80000000)
            ck_assert_uint_eq(bits_of(msap_decode_float(code_of(a))), a);
    }
}
END_TEST

/* Every exponent, with its least and greatest mantissa: neighbours are neighbours. */
START_TEST(neighbours_differ_by_one)
{
    uint32_t bits;
    for (bits = 1; bits < 0x7F800000; bits += 0x7FFFFF) {
        ck_assert_uint_eq(code_of(bits + 1), code_of(bits) + 1);
        ck_assert_uint_eq(code_of(bits | 0x80000000), code_of((bits + 1) | 0x80000000) + 1);
    }
}
END_TEST

int main(void)
{
    TCase *tests = tcase_create("numbers");
    tcase_add_test(tests, special_values_keep_their_order);
    tcase_add_test(tests, zeros_are_one);
    tcase_add_test(tests, nans_are_beyond_the_infinities);
    tcase_add_test(tests, no_number_is_at_an_end);
    tcase_add_test(tests, random_bits_keep_their_order);
    tcase_add_test(tests, neighbours_differ_by_one);
    return run_case(tests, "numbers");
}
