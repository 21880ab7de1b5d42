/* What every kernel file needs: argument buffers and the run-time choice of vector instructions.
 * Kernels hold no policy. Python has validated values (indices in range, finite numbers) before they are
 * called; here only what would make memory access unsafe is checked again: type, contiguity and length. */
#ifndef UMG_H
#define UMG_H

#define PY_SSIZE_T_CLEAN
#include <Python.h>
#include <stdint.h>

/* One clone per instruction set, chosen by the loader. No fused multiply-add: all clones round alike. */
#if defined(__x86_64__) && defined(__linux__) && defined(__GNUC__) && !defined(__SANITIZE_ADDRESS__)
#define UMG_VECTORISED __attribute__((target_clones("avx2", "default")))
#else
#define UMG_VECTORISED
#endif

/* Fill `view` with a C-contiguous buffer of `object` whose items are of `type`: 'd' float64, 'f' float32,
 * 'i' int32, 'l' int64, 'B' uint8. `length` is the number of items wanted, or -1 for any.
 * Returns 0, or -1 with a Python exception set and nothing held. */
int umg_buffer(PyObject *object, Py_buffer *view, char type, Py_ssize_t length, int writable, const char *name);

#endif
