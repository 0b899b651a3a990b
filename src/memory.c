/* Memory: the world's allocator with an account of what it gave.
 *
 * SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT */
#if defined(__linux__)
#if !defined(_DEFAULT_SOURCE)
#define _DEFAULT_SOURCE /* for madvise and posix_memalign */
#endif
#include <sys/mman.h>
#endif

#include "internal.h"

#include <stdlib.h>

/* Linux gives out small pages one by one, which takes longer than to fill them, and of small pages a processor
 * knows the places of few. So it is asked for huge ones: an array gets as many as it fills and, if it fills half
 * of another, that one too. */
static void *default_alloc(void *user, size_t size)
{
    (void)user;
#if defined(MADV_HUGEPAGE)
    size_t huge = (size / (HUGE_PAGE / 2) + 1) / 2 * HUGE_PAGE;
    void *memory = NULL;
    if (huge > 0) {
        /* left out of the count of branches: where memory lacks, tests have allocators of their own */
        if (posix_memalign(&memory, HUGE_PAGE, larger_of(huge, size)) != 0) return NULL; /* GCOVR_EXCL_BR_LINE */
        madvise(memory, huge, MADV_HUGEPAGE);
        return memory;
    }
#endif
    return malloc(size);
}

static void default_free(void *user, void *pointer, size_t size)
{
    (void)user;
    (void)size;
    free(pointer);
}

msap_status msap_memory_init(struct memory *m, msap_alloc_fn alloc, msap_free_fn free_fn, void *user)
{
    if (!alloc != !free_fn) return MSAP_ERROR_CONFIG;
    memset(m, 0, sizeof *m);
    m->alloc = alloc ? alloc : default_alloc;
    m->free = free_fn ? free_fn : default_free;
    m->user = user;
    return MSAP_OK;
}

/* An array starts at a cache line, so that a struct of 64 bytes is one; the byte before
 * it tells how far from there the allocator's memory starts. */
void *msap_memory_alloc(struct memory *m, size_t count, size_t size)
{
    if (count > (SIZE_MAX - CACHE_LINE) / size) return NULL;
    size_t bytes = count * size + CACHE_LINE;
    unsigned char *start = m->alloc(m->user, bytes);
    m->calls++;
    if (!start) return NULL;
    m->bytes += bytes;
    if (m->bytes > m->peak) m->peak = m->bytes;
    size_t offset = CACHE_LINE - (uintptr_t)start % CACHE_LINE;
    start[offset - 1] = (unsigned char)offset;
    return start + offset;
}

void msap_memory_free(struct memory *m, void *pointer, size_t count, size_t size)
{
    if (!pointer) return;
    size_t bytes = count * size + CACHE_LINE;
    unsigned char *array = pointer;
    m->bytes -= bytes;
    m->free(m->user, array - array[-1], bytes);
}

/* Gives the array at *(void **)pointer_to_array room for new_room elements, of which
 * the first `used` are kept. Returns 1, or 0 without memory and nothing changed. */
int msap_memory_resize(struct memory *m, void *pointer_to_array, size_t *room, size_t new_room, size_t used,
                       size_t size)
{
    void *old, *grown = NULL;
    memcpy(&old, pointer_to_array, sizeof old);
    if (new_room > 0) {
        grown = msap_memory_alloc(m, new_room, size);
        if (!grown) return 0;
        if (used > 0) memcpy(grown, old, used * size);
    }
    msap_memory_free(m, old, *room, size);
    memcpy(pointer_to_array, &grown, sizeof grown);
    *room = new_room;
    return 1;
}

/* As memory_resize, but only to grow: by half at least, and with an eighth to spare,
 * so that a little more after much does not move it all again. */
int msap_memory_reserve(struct memory *m, void *pointer_to_array, size_t *room, size_t need, size_t used,
                        size_t size)
{
    if (need <= *room) return 1;
    size_t roomy = *room + *room / 2, spared = need + need / 8;
    if (spared < need) return 0;
    return msap_memory_resize(m, pointer_to_array, room, larger_of(spared, roomy), used, size);
}

/* Gives room for `need` elements, which are kept, back; without memory for the smaller
 * array the larger one stays. */
void msap_memory_shrink(struct memory *m, void *pointer_to_array, size_t *room, size_t need, size_t size)
{
    if (need < *room) msap_memory_resize(m, pointer_to_array, room, need, need, size);
}

void *msap_scratch_get(struct scratch *s, struct memory *m, size_t words)
{
    return msap_memory_reserve(m, &s->at, &s->room, words, 0, sizeof *s->at) ? s->at : NULL;
}

void msap_scratch_free(struct scratch *s, struct memory *m)
{
    msap_memory_resize(m, &s->at, &s->room, 0, 0, sizeof *s->at);
}
