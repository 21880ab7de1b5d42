/* Sums over the corners of elements (triangles or tets): deformation gradients, their adjoint, and the local step of
 * the two-sided as-rigid-as-possible energy. */
#include "rotations.h"
#include "umg.h"

static void release(Py_buffer *views, int count) {
    for (int i = 0; i < count; i++)
        PyBuffer_Release(views + i);
}

static PyObject *element_deformations(PyObject *self, PyObject *args) {
    (void)self;
    PyObject *objects[4];
    int corners;
    if (!PyArg_ParseTuple(args, "OOOiO", &objects[0], &objects[1], &objects[2], &corners, &objects[3]))
        return NULL;
    Py_buffer views[4];
    if (umg_buffer(objects[0], &views[0], 'd', -1, 0, "vertices") < 0)
        return NULL;
    if (umg_buffer(objects[1], &views[1], 'i', -1, 0, "elements") < 0) {
        release(views, 1);
        return NULL;
    }
    Py_ssize_t count = views[1].len / (4 * corners);
    if (umg_buffer(objects[2], &views[2], 'd', count * corners * 3, 0, "gradients") < 0) {
        release(views, 2);
        return NULL;
    }
    if (umg_buffer(objects[3], &views[3], 'd', count * 9, 1, "deformations") < 0) {
        release(views, 3);
        return NULL;
    }
    const double *vertices = views[0].buf, *gradients = views[2].buf;
    const int32_t *elements = views[1].buf;
    double *deformations = views[3].buf;
    Py_BEGIN_ALLOW_THREADS
    for (Py_ssize_t e = 0; e < count; e++) {
        double f[9] = {0};
        for (int i = 0; i < corners; i++) {
            const double *x = vertices + 3 * (Py_ssize_t)elements[corners * e + i];
            const double *g = gradients + 3 * (corners * e + i);
            for (int a = 0; a < 3; a++)
                for (int b = 0; b < 3; b++)
                    f[3 * a + b] += x[a] * g[b];
        }
        for (int i = 0; i < 9; i++)
            deformations[9 * e + i] = f[i];
    }
    Py_END_ALLOW_THREADS
    release(views, 4);
    Py_RETURN_NONE;
}

static PyObject *element_forces(PyObject *self, PyObject *args) {
    (void)self;
    PyObject *objects[5];
    int corners;
    if (!PyArg_ParseTuple(args, "OOOOiO", &objects[0], &objects[1], &objects[2], &objects[3], &corners, &objects[4]))
        return NULL;
    Py_buffer views[5];
    if (umg_buffer(objects[0], &views[0], 'i', -1, 0, "elements") < 0)
        return NULL;
    Py_ssize_t count = views[0].len / (4 * corners);
    if (umg_buffer(objects[1], &views[1], 'd', count * corners * 3, 0, "gradients") < 0) {
        release(views, 1);
        return NULL;
    }
    if (umg_buffer(objects[2], &views[2], 'd', count, 0, "sizes") < 0) {
        release(views, 2);
        return NULL;
    }
    if (umg_buffer(objects[3], &views[3], 'd', count * 9, 0, "shapes") < 0) {
        release(views, 3);
        return NULL;
    }
    if (umg_buffer(objects[4], &views[4], 'd', -1, 1, "forces") < 0) {
        release(views, 4);
        return NULL;
    }
    const int32_t *elements = views[0].buf;
    const double *gradients = views[1].buf, *sizes = views[2].buf, *shapes = views[3].buf;
    double *forces = views[4].buf;
    Py_BEGIN_ALLOW_THREADS
    for (Py_ssize_t e = 0; e < count; e++) {
        const double *s = shapes + 9 * e;
        for (int i = 0; i < corners; i++) {
            const double *g = gradients + 3 * (corners * e + i);
            double *out = forces + 3 * (Py_ssize_t)elements[corners * e + i];
            for (int a = 0; a < 3; a++)
                out[a] += sizes[e] * (s[3 * a] * g[0] + s[3 * a + 1] * g[1] + s[3 * a + 2] * g[2]);
        }
    }
    Py_END_ALLOW_THREADS
    release(views, 5);
    Py_RETURN_NONE;
}

/* wanted += share R rest, R the rotation nearest to now rest^T. */
static void add_turned(const double *now, const double *rest, double share, double *wanted) {
    double product[9], r[9];
    for (int a = 0; a < 3; a++)
        for (int b = 0; b < 3; b++)
            product[3 * a + b] =
                now[3 * a] * rest[3 * b] + now[3 * a + 1] * rest[3 * b + 1] + now[3 * a + 2] * rest[3 * b + 2];
    umg_nearest_rotation(product, r);
    for (int a = 0; a < 3; a++)
        for (int b = 0; b < 3; b++)
            wanted[3 * a + b] += share * (r[3 * a] * rest[b] + r[3 * a + 1] * rest[3 + b] + r[3 * a + 2] * rest[6 + b]);
}

static PyObject *two_sided_targets(PyObject *self, PyObject *args) {
    (void)self;
    PyObject *objects[4];
    double weight;
    if (!PyArg_ParseTuple(args, "OOOdO", &objects[0], &objects[1], &objects[2], &weight, &objects[3]))
        return NULL;
    static const char *names[] = {"new", "source", "target", "wanted"};
    Py_buffer views[4];
    Py_ssize_t items = -1;
    for (int i = 0; i < 4; i++) {
        if (umg_buffer(objects[i], &views[i], 'd', items, i == 3, names[i]) < 0) {
            release(views, i);
            return NULL;
        }
        items = views[0].len / 8;
    }
    const double *now = views[0].buf, *source = views[1].buf, *target = views[2].buf;
    double *wanted = views[3].buf;
    Py_BEGIN_ALLOW_THREADS
    for (Py_ssize_t i = 0; i + 9 <= items; i += 9) {
        double sum[9] = {0};
        add_turned(now + i, source + i, 1 - weight, sum);
        add_turned(now + i, target + i, weight, sum);
        for (int j = 0; j < 9; j++)
            wanted[i + j] = sum[j];
    }
    Py_END_ALLOW_THREADS
    release(views, 4);
    Py_RETURN_NONE;
}

PyMethodDef umg_elements_methods[] = {
    {"element_deformations", element_deformations, METH_VARARGS,
     "element_deformations(vertices, elements, gradients, corners, deformations): sum over corners of x g^T, an element."},
    {"element_forces", element_forces, METH_VARARGS,
     "element_forces(elements, gradients, sizes, shapes, corners, forces): adds size shape g to every corner's row."},
    {"two_sided_targets", two_sided_targets, METH_VARARGS,
     "two_sided_targets(new, source, target, weight, wanted): (1-l) R_s F_s + l R_t F_t for (count, 3, 3) float64."},
    {NULL, NULL, 0, NULL},
};
