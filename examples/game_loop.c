/* A game loop: a ball falls on a floor and bounces off; the pairs that begin and
 * end are printed. The README shows this program.
 *
 * SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT
 */
#include <multisap.h>
#include <stdio.h>

int main(void)
{
    const float floor_min[3] = {-9, -1, -9}, floor_max[3] = {9, 0, 9};
    float ball_min[3] = {0, 2, 0}, ball_max[3] = {1, 3, 1}, speed = -1;
    msap_world *world;
    msap_handle floor, ball;
    const msap_pair *began, *ended;
    size_t b, e;
    if (msap_create(NULL, &world) || msap_add(world, floor_min, floor_max, MSAP_STATIC, NULL, &floor)
        || msap_add(world, ball_min, ball_max, 0, NULL, &ball))
        return 1;
    for (int frame = 0; frame < 6; frame++, ball_min[1] += speed, ball_max[1] += speed) {
        if (msap_update(world, ball, ball_min, ball_max) || msap_commit(world, NULL, NULL)
            || msap_created(world, &began, &b) || msap_deleted(world, &ended, &e))
            return 1;
        printf("frame %d: %d began, %d ended\n", frame, (int)b, (int)e);
        if (b > 0 && began[0].a == floor && began[0].b == ball)
            speed = 1;
    }
    return msap_destroy(world);
}
