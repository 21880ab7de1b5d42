/* Conjugate gradients with a Jacobi preconditioner for sparse symmetric positive definite systems. */
#include "arguments.h"

#include <math.h>
#include <stdlib.h>

UMG_VECTORISED
static void multiply(const int32_t *first, const int32_t *column, const double *value, int64_t size, const double *x, double *y) {
    for (int64_t i = 0; i < size; i++) {
        double sum = 0;
        for (int32_t k = first[i]; k < first[i + 1]; k++)
            sum += value[k] * x[column[k]];
        y[i] = sum;
    }
}

static double inner(const double *a, const double *b, int64_t size) {
    double sum = 0;
    for (int64_t i = 0; i < size; i++)
        sum += a[i] * b[i];
    return sum;
}

/* Solve one column from the start in x; returns the number of iterations. */
static int64_t solve(const int32_t *first, const int32_t *column, const double *value, const double *inverse, int64_t size,
                     const double *right, double *x, double tolerance, int64_t most, double *work) {
    double *residual = work, *scaled = work + size, *direction = work + 2 * size, *image = work + 3 * size;
    multiply(first, column, value, size, x, image);
    double goal = 0;
    for (int64_t i = 0; i < size; i++) {
        residual[i] = right[i] - image[i];
        goal += right[i] * inverse[i] * right[i];
    }
    goal *= tolerance * tolerance;
    double energy = 0;
    for (int64_t i = 0; i < size; i++) {
        scaled[i] = inverse[i] * residual[i];
        direction[i] = scaled[i];
        energy += residual[i] * scaled[i];
    }
    int64_t iteration = 0;
    while (iteration < most && energy > goal) {
        multiply(first, column, value, size, direction, image);
        double step = energy / inner(direction, image, size), next = 0;
        for (int64_t i = 0; i < size; i++) {
            x[i] += step * direction[i];
            residual[i] -= step * image[i];
            scaled[i] = inverse[i] * residual[i];
            next += residual[i] * scaled[i];
        }
        double ratio = next / energy;
        for (int64_t i = 0; i < size; i++)
            direction[i] = scaled[i] + ratio * direction[i];
        energy = next;
        iteration++;
    }
    return iteration;
}

static PyObject *conjugate_gradients(PyObject *self, PyObject *args) {
    (void)self;
    PyObject *o[6];
    Py_ssize_t size, entries, most;
    double tolerance;
    if (!PyArg_ParseTuple(args, "nnOOOOOdnO", &size, &entries, &o[0], &o[1], &o[2], &o[3], &o[4], &tolerance, &most, &o[5]))
        return NULL;
    Argument wanted[6] = {{'i', size + 1, 0, "indptr"}, {'i', entries, 0, "indices"}, {'d', entries, 0, "data"},
                          {'d', size, 0, "inverse_diagonal"}, {'d', size, 0, "right"}, {'d', size, 1, "x"}};
    Py_buffer views[6];
    if (take_arguments(o, wanted, views, 6) < 0)
        return NULL;
    double *work = malloc(sizeof(double) * 4 * (size_t)(size > 0 ? size : 1));
    int64_t iterations = 0;
    if (work != NULL) {
        Py_BEGIN_ALLOW_THREADS
        iterations = solve(views[0].buf, views[1].buf, views[2].buf, views[3].buf, size, views[4].buf, views[5].buf, tolerance,
                           most, work);
        Py_END_ALLOW_THREADS
        free(work);
    }
    release_arguments(views, 6);
    return work == NULL ? PyErr_NoMemory() : PyLong_FromLongLong(iterations);
}

PyMethodDef umg_conjugate_methods[] = {
    {"conjugate_gradients", conjugate_gradients, METH_VARARGS,
     "conjugate_gradients(size, entries, indptr, indices, data, inverse_diagonal, right, tolerance, most, x): solve a CSR system "
     "from the start in x, in place, until the preconditioned residual has fallen to tolerance of that of zero. Returns the "
     "number of iterations."},
    {NULL, NULL, 0, NULL},
};
