/* What a pair costs a narrow phase: prints nanoseconds as a line of JSON.
 *
 * SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT
 *
 * 3000 bodies are boxes turned at random, about 1 wide, and 100000 pairs of them are
 * about to touch. "again": the two axis-aligned boxes are compared once more. "turned":
 * the separating axis test of the two turned boxes, up to 15 axes, as a narrow phase
 * does for boxes; for hulls and meshes it does far more. Both read the bodies from
 * memory in the order of the pairs, which is as good as random. The shortest of 9
 * times counts. */
#define _POSIX_C_SOURCE 200809L
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

enum { BODIES = 3000, PAIRS = 100000, ROUNDS = 9 };

struct body {
    float min[3], max[3];
    float centre[3], half[3], axis[3][3];
};

static struct body bodies[BODIES];
static uint32_t pairs[PAIRS][2];
static uint64_t state = 1;

static float random_between(float low, float high)
{
    state = state * UINT64_C(6364136223846793005) + UINT64_C(1442695040888963407);
    return low + (high - low) * (float)(state >> 40) / 16777216.0f;
}

static float dot(const float a[3], const float b[3]) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

static void cross(float to[3], const float a[3], const float b[3])
{
    for (int k = 0; k < 3; k++) to[k] = a[(k + 1) % 3] * b[(k + 2) % 3] - a[(k + 2) % 3] * b[(k + 1) % 3];
}

static void make_body(struct body *b)
{
    float up[3];
    for (int k = 0; k < 3; k++) {
        b->centre[k] = random_between(-0.7f, 0.7f);
        b->half[k] = random_between(0.35f, 0.65f);
        b->axis[0][k] = random_between(-1, 1);
        up[k] = random_between(-1, 1);
    }
    cross(b->axis[1], b->axis[0], up);
    cross(b->axis[2], b->axis[0], b->axis[1]);
    for (int i = 0; i < 3; i++) {
        float length = sqrtf(dot(b->axis[i], b->axis[i]));
        for (int k = 0; k < 3; k++) b->axis[i][k] /= length;
    }
    for (int k = 0; k < 3; k++) {
        float reach = 0;
        for (int i = 0; i < 3; i++) reach += b->half[i] * fabsf(b->axis[i][k]);
        b->min[k] = b->centre[k] - reach;
        b->max[k] = b->centre[k] + reach;
    }
}

static int boxes_meet(const struct body *a, const struct body *b)
{
    for (int k = 0; k < 3; k++)
        if (!(a->min[k] <= b->max[k] && b->min[k] <= a->max[k]))
            return 0;
    return 1;
}

static float reach_along(const struct body *b, const float axis[3])
{
    return b->half[0] * fabsf(dot(b->axis[0], axis)) + b->half[1] * fabsf(dot(b->axis[1], axis)) +
           b->half[2] * fabsf(dot(b->axis[2], axis));
}

static int is_separating(const struct body *a, const struct body *b, const float between[3], const float axis[3])
{
    return fabsf(dot(between, axis)) > reach_along(a, axis) + reach_along(b, axis);
}

static int bodies_meet(const struct body *a, const struct body *b)
{
    float between[3], axis[3];
    for (int k = 0; k < 3; k++) between[k] = b->centre[k] - a->centre[k];
    for (int i = 0; i < 3; i++)
        if (is_separating(a, b, between, a->axis[i]) || is_separating(a, b, between, b->axis[i]))
            return 0;
    for (int i = 0; i < 9; i++) {
        cross(axis, a->axis[i / 3], b->axis[i % 3]);
        if (is_separating(a, b, between, axis))
            return 0;
    }
    return 1;
}

static volatile int meetings;

static double nanoseconds(int (*meet)(const struct body *, const struct body *))
{
    double best = 1e30;
    for (int round = 0; round < ROUNDS; round++) {
        struct timespec start, end;
        int n = 0;
        clock_gettime(CLOCK_MONOTONIC, &start);
        for (int i = 0; i < PAIRS; i++) n += meet(&bodies[pairs[i][0]], &bodies[pairs[i][1]]);
        clock_gettime(CLOCK_MONOTONIC, &end);
        meetings = n;
        best = fmin(best, (double)(end.tv_sec - start.tv_sec) * 1e9 + (double)(end.tv_nsec - start.tv_nsec));
    }
    return best / PAIRS;
}

int main(void)
{
    for (int i = 0; i < BODIES; i++) make_body(&bodies[i]);
    for (int i = 0; i < PAIRS; i++)
        for (int k = 0; k < 2; k++) pairs[i][k] = (uint32_t)random_between(0, BODIES - 0.5f);
    printf("{\"again\": %.1f, \"turned\": %.1f}\n", nanoseconds(boxes_meet), nanoseconds(bodies_meet));
    return 0;
}
