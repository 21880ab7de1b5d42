/* Quantities carried from the corners of elements to points, and from faces to vertices. */
#include "arguments.h"

#include <math.h>
#include <string.h>

static int in_range(const int32_t *index, Py_ssize_t count, Py_ssize_t limit) {
    for (Py_ssize_t i = 0; i < count; i++)
        if (index[i] < 0 || index[i] >= limit)
            return 0;
    return 1;
}

UMG_VECTORISED
static void carry(Py_ssize_t count, int corners, int columns, const int32_t *elements, const int32_t *element,
                  const double *weights, const double *values, double *means) {
    for (Py_ssize_t p = 0; p < count; p++) {
        const int32_t *corner = elements + (Py_ssize_t)corners * element[p];
        double *mean = means + columns * p;
        for (int k = 0; k < columns; k++)
            mean[k] = 0;
        for (int c = 0; c < corners; c++) {
            const double w = weights[corners * p + c], *value = values + (Py_ssize_t)columns * corner[c];
            for (int k = 0; k < columns; k++)
                mean[k] += w * value[k];
        }
    }
}

static PyObject *weighted_means(PyObject *self, PyObject *args) {
    (void)self;
    PyObject *o[5];
    int corners, columns;
    if (!PyArg_ParseTuple(args, "iiOOOOO", &corners, &columns, &o[0], &o[1], &o[2], &o[3], &o[4]))
        return NULL;
    if (corners < 1 || columns < 1) {
        PyErr_SetString(PyExc_ValueError, "corners, columns: expected 1 or more");
        return NULL;
    }
    Py_buffer views[5];
    if (umg_buffer(o[0], &views[0], 'i', -1, 0, "element") < 0)
        return NULL;
    Py_ssize_t count = views[0].len / 4;
    Argument wanted[4] = {{'i', -1, 0, "elements"},
                          {'d', corners * count, 0, "weights"},
                          {'d', -1, 0, "values"},
                          {'d', columns * count, 1, "means"}};
    if (take_arguments(o + 1, wanted, views + 1, 4) < 0) {
        PyBuffer_Release(&views[0]);
        return NULL;
    }
    Py_ssize_t known = views[1].len / (4 * corners);
    int fits = in_range(views[0].buf, count, known) && in_range(views[1].buf, corners * known, views[3].len / (8 * columns));
    if (fits) {
        Py_BEGIN_ALLOW_THREADS
        carry(count, corners, columns, views[1].buf, views[0].buf, views[2].buf, views[3].buf, views[4].buf);
        Py_END_ALLOW_THREADS
    }
    release_arguments(views, 5);
    if (!fits) {
        PyErr_SetString(PyExc_IndexError, "element or elements: index out of range");
        return NULL;
    }
    Py_RETURN_NONE;
}

static PyObject *area_normals(PyObject *self, PyObject *args) {
    (void)self;
    PyObject *o[3];
    if (!PyArg_ParseTuple(args, "OOO", &o[0], &o[1], &o[2]))
        return NULL;
    Py_buffer views[3];
    if (umg_buffer(o[0], &views[0], 'd', -1, 0, "vertices") < 0)
        return NULL;
    Py_ssize_t count = views[0].len / 24;
    Argument wanted[2] = {{'i', -1, 0, "faces"}, {'d', 3 * count, 1, "normals"}};
    if (take_arguments(o + 1, wanted, views + 1, 2) < 0) {
        PyBuffer_Release(&views[0]);
        return NULL;
    }
    Py_ssize_t faces = views[1].len / 12;
    int fits = in_range(views[1].buf, 3 * faces, count);
    if (fits) {
        const double *x = views[0].buf;
        const int32_t *face = views[1].buf;
        double *normals = views[2].buf;
        Py_BEGIN_ALLOW_THREADS
        memset(normals, 0, sizeof(double) * 3 * count);
        for (Py_ssize_t f = 0; f < faces; f++) {
            const double *a = x + 3 * (Py_ssize_t)face[3 * f], *b = x + 3 * (Py_ssize_t)face[3 * f + 1];
            const double *c = x + 3 * (Py_ssize_t)face[3 * f + 2];
            double u[3], v[3], n[3];
            for (int i = 0; i < 3; i++) {
                u[i] = b[i] - a[i];
                v[i] = c[i] - a[i];
            }
            n[0] = u[1] * v[2] - u[2] * v[1];
            n[1] = u[2] * v[0] - u[0] * v[2];
            n[2] = u[0] * v[1] - u[1] * v[0];
            for (int corner = 0; corner < 3; corner++)
                for (int i = 0; i < 3; i++)
                    normals[3 * (Py_ssize_t)face[3 * f + corner] + i] += n[i];
        }
        for (Py_ssize_t v = 0; v < count; v++) {
            double *n = normals + 3 * v, length = sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
            if (length > 0)
                for (int i = 0; i < 3; i++)
                    n[i] /= length;
        }
        Py_END_ALLOW_THREADS
    }
    release_arguments(views, 3);
    if (!fits) {
        PyErr_SetString(PyExc_IndexError, "faces: index out of range");
        return NULL;
    }
    Py_RETURN_NONE;
}

PyMethodDef umg_surface_methods[] = {
    {"weighted_means", weighted_means, METH_VARARGS,
     "weighted_means(corners, columns, element, elements, weights, values, means): for each point, the sum over its element's "
     "corners of weight times value."},
    {"area_normals", area_normals, METH_VARARGS,
     "area_normals(vertices, faces, normals): the unit of every vertex's sum of face normals times area; 0 where there is none."},
    {NULL, NULL, 0, NULL},
};
