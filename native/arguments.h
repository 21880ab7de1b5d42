/* Take many buffers at once, with one clean-up. */
#ifndef UMG_ARGUMENTS_H
#define UMG_ARGUMENTS_H

#include "umg.h"

/* Into every clone of a UMG_VECTORISED caller, not once for the plainest processor. */
#if defined(__GNUC__)
#define UMG_INLINE static inline __attribute__((always_inline))
#else
#define UMG_INLINE static inline
#endif

typedef struct {
    char type;
    Py_ssize_t length;
    int writable;
    const char *name;
} Argument;

static inline void release_arguments(Py_buffer *views, int count) {
    for (int i = 0; i < count; i++)
        PyBuffer_Release(&views[i]);
}

/* 0, or -1 with an exception set and nothing held. */
static inline int take_arguments(PyObject **objects, const Argument *wanted, Py_buffer *views, int count) {
    for (int i = 0; i < count; i++)
        if (umg_buffer(objects[i], &views[i], wanted[i].type, wanted[i].length, wanted[i].writable, wanted[i].name) < 0) {
            release_arguments(views, i);
            return -1;
        }
    return 0;
}

#endif
