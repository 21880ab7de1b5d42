/* Equal rows of three numbers found by hashing: the welding of vertices, of uvs and of faces. */
#include "umg.h"

#include <stdlib.h>
#include <string.h>

static uint64_t mix(uint64_t key) {
    key ^= key >> 33;
    key *= 0xff51afd7ed558ccdULL;
    key ^= key >> 33;
    key *= 0xc4ceb9fe1a85ec53ULL;
    return key ^ (key >> 33);
}

static uint64_t hash_row(const double *row) {
    uint64_t hash = 0;
    for (int i = 0; i < 3; i++) {
        double value = row[i] + 0.0; /* -0 and 0 are equal, so they must hash alike */
        uint64_t bits;
        memcpy(&bits, &value, sizeof bits);
        hash = mix(hash ^ bits) + 0x9e3779b97f4a7c15ULL;
    }
    return hash;
}

static PyObject *weld_rows(PyObject *self, PyObject *args) {
    (void)self;
    PyObject *rows_object, *labels_object;
    if (!PyArg_ParseTuple(args, "OO", &rows_object, &labels_object))
        return NULL;
    Py_buffer rows, labels;
    if (umg_buffer(rows_object, &rows, 'd', -1, 0, "rows") < 0)
        return NULL;
    Py_ssize_t count = rows.len / (3 * 8);
    if (umg_buffer(labels_object, &labels, 'i', count, 1, "labels") < 0) {
        PyBuffer_Release(&rows);
        return NULL;
    }
    size_t slots = 16;
    while (slots < 2 * (size_t)count)
        slots *= 2;
    int32_t *table = count < INT32_MAX ? malloc(slots * sizeof *table) : NULL; /* row index + 1, 0 where free */
    int32_t kept = 0;
    if (table != NULL) {
        const double *row = rows.buf;
        int32_t *label = labels.buf;
        Py_BEGIN_ALLOW_THREADS
        memset(table, 0, slots * sizeof *table);
        for (Py_ssize_t i = 0; i < count; i++) {
            const double *mine = row + 3 * i;
            size_t slot = (size_t)hash_row(mine) & (slots - 1);
            for (; table[slot] != 0; slot = (slot + 1) & (slots - 1)) {
                const double *other = row + 3 * (Py_ssize_t)(table[slot] - 1);
                if (mine[0] == other[0] && mine[1] == other[1] && mine[2] == other[2])
                    break;
            }
            if (table[slot] == 0) {
                table[slot] = (int32_t)(i + 1);
                label[i] = kept++;
            } else {
                label[i] = label[table[slot] - 1];
            }
        }
        Py_END_ALLOW_THREADS
        free(table);
    }
    PyBuffer_Release(&rows);
    PyBuffer_Release(&labels);
    if (table == NULL)
        return PyErr_NoMemory();
    return PyLong_FromLong(kept);
}

PyMethodDef umg_weld_methods[] = {
    {"weld_rows", weld_rows, METH_VARARGS,
     "weld_rows(rows, labels) -> count: label (count, 3) float64 rows so that equal rows share a label, in order of first use."},
    {NULL, NULL, 0, NULL},
};
