/* What the core uses of the C library, for boards that have none; defined in memory.c. */
#ifndef FL_STRING_H
#define FL_STRING_H

#include <stddef.h>

void *memcpy(void *restrict to, const void *restrict from, size_t count);
void *memmove(void *to, const void *from, size_t count);
void *memset(void *to, int value, size_t count);
int memcmp(const void *a, const void *b, size_t count);
size_t strlen(const char *text);

/* So that compilers make moves of single numbers of the copy of a structure whose parts are used one by one. */
#define memcpy(to, from, count) __builtin_memcpy((to), (from), (count))

#endif
