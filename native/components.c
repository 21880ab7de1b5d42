/* Connected components of triangle meshes by union-find. */
#include "umg.h"

#include <stdlib.h>

static int32_t find_root(int32_t *parent, int32_t vertex) {
    while (parent[vertex] != vertex) {
        parent[vertex] = parent[parent[vertex]];
        vertex = parent[vertex];
    }
    return vertex;
}

/* The smaller index becomes the root, so that roots come before all others of their component. */
static void join(int32_t *parent, int32_t a, int32_t b) {
    a = find_root(parent, a), b = find_root(parent, b);
    if (a < b)
        parent[b] = a;
    else
        parent[a] = b;
}

static PyObject *vertex_components(PyObject *self, PyObject *args) {
    (void)self;
    PyObject *faces_object, *labels_object;
    if (!PyArg_ParseTuple(args, "OO", &faces_object, &labels_object))
        return NULL;
    Py_buffer faces, labels;
    if (umg_buffer(faces_object, &faces, 'i', -1, 0, "faces") < 0)
        return NULL;
    if (umg_buffer(labels_object, &labels, 'i', -1, 1, "labels") < 0) {
        PyBuffer_Release(&faces);
        return NULL;
    }
    const int32_t *face = faces.buf;
    int32_t *label = labels.buf, count = 0;
    Py_ssize_t face_count = faces.len / 12, vertex_count = labels.len / 4;
    int out_of_range = vertex_count > INT32_MAX;
    Py_BEGIN_ALLOW_THREADS
    for (Py_ssize_t i = 0; i < 3 * face_count; i++)
        out_of_range |= face[i] < 0 || face[i] >= vertex_count;
    if (!out_of_range) {
        for (Py_ssize_t i = 0; i < vertex_count; i++)
            label[i] = (int32_t)i;
        for (Py_ssize_t i = 0; i < face_count; i++) {
            join(label, face[3 * i], face[3 * i + 1]);
            join(label, face[3 * i], face[3 * i + 2]);
        }
        /* parents come before their children: by the time a vertex is reached its parent holds its label, as -1 - label */
        for (Py_ssize_t i = 0; i < vertex_count; i++)
            label[i] = label[i] == i ? -1 - count++ : label[label[i]];
        for (Py_ssize_t i = 0; i < vertex_count; i++)
            label[i] = -1 - label[i];
    }
    Py_END_ALLOW_THREADS
    PyBuffer_Release(&faces);
    PyBuffer_Release(&labels);
    if (out_of_range) {
        PyErr_SetString(PyExc_ValueError, "faces: expected indices below the number of vertices, got one out of range");
        return NULL;
    }
    return PyLong_FromLong(count);
}

PyMethodDef umg_components_methods[] = {
    {"vertex_components", vertex_components, METH_VARARGS,
     "vertex_components(faces, labels) -> count: label vertices so that those that faces join share a label, numbered by "
     "their first vertex."},
    {NULL, NULL, 0, NULL},
};
