/* Windows along the diagonals of correlation matrices, and the best yaw of a correlation given as a Fourier series. */
#include "umg.h"

#include <math.h>

/* out[r] += w in[r], over rows of interleaved real and imaginary parts. */
UMG_VECTORISED
static void add_scaled(Py_ssize_t count, float weight, const float *restrict in, float *restrict out) {
    for (Py_ssize_t n = 0; n < count; n++)
        out[n] += weight * in[n];
}

static PyObject *window_diagonals(PyObject *self, PyObject *args) {
    (void)self;
    PyObject *values_object, *weights_object, *windowed_object;
    Py_ssize_t rows, columns;
    if (!PyArg_ParseTuple(args, "OOOnn", &values_object, &weights_object, &windowed_object, &rows, &columns))
        return NULL;
    Py_buffer values, weights, windowed;
    if (umg_buffer(weights_object, &weights, 'f', -1, 0, "weights") < 0)
        return NULL;
    /* No array has more rows or columns than this, and the products below cannot overflow. */
    const Py_ssize_t most = INT32_MAX / 4;
    if (rows < 0 || columns < 0 || rows > most || columns > most || weights.len / 4 > most) {
        PyErr_Format(PyExc_ValueError, "rows, columns: expected 0 to %zd, got %zd and %zd", most, rows, columns);
        PyBuffer_Release(&weights);
        return NULL;
    }
    Py_ssize_t count = weights.len / 4, wide = columns + count - 1;
    if (umg_buffer(values_object, &values, 'f', 2 * (rows + count - 1) * wide, 0, "values") < 0) {
        PyBuffer_Release(&weights);
        return NULL;
    }
    if (umg_buffer(windowed_object, &windowed, 'f', 2 * rows * columns, 1, "windowed") < 0) {
        PyBuffer_Release(&values);
        PyBuffer_Release(&weights);
        return NULL;
    }
    const float *in = values.buf, *w = weights.buf;
    float *out = windowed.buf;
    Py_BEGIN_ALLOW_THREADS
    for (Py_ssize_t row = 0; row < rows; row++) {
        float *sums = out + 2 * row * columns;
        for (Py_ssize_t n = 0; n < 2 * columns; n++)
            sums[n] = 0;
        for (Py_ssize_t l = 0; l < count; l++)
            add_scaled(2 * columns, w[l], in + 2 * ((row + l) * wide + l), sums);
    }
    Py_END_ALLOW_THREADS
    PyBuffer_Release(&windowed);
    PyBuffer_Release(&values);
    PyBuffer_Release(&weights);
    Py_RETURN_NONE;
}

/* Value and first two derivatives of c_0 + 2 Re sum_m c_m e^(i m yaw). */
static void evaluate(const float *c, Py_ssize_t frequencies, double yaw, double *value, double *slope, double *bend) {
    double step_re = cos(yaw), step_im = sin(yaw), re = 1, im = 0;
    *value = c[0] / 2;
    *slope = *bend = 0;
    for (Py_ssize_t m = 1; m < frequencies; m++) {
        double next = re * step_re - im * step_im;
        im = re * step_im + im * step_re;
        re = next;
        double a = c[2 * m], b = c[2 * m + 1], even = a * re - b * im, odd = a * im + b * re, order = (double)m;
        *value += even;
        *slope -= order * odd;
        *bend -= order * order * even;
    }
    *value *= 2;
    *slope *= 2;
    *bend *= 2;
}

/* Newton's method, kept within half a grid step either side of where it started, the best grid yaw. */
static PyObject *refine_yaw(PyObject *self, PyObject *args) {
    (void)self;
    PyObject *series_object, *yaw_object, *least_object;
    Py_ssize_t frequencies;
    double reach;
    if (!PyArg_ParseTuple(args, "OOOnd", &series_object, &yaw_object, &least_object, &frequencies, &reach))
        return NULL;
    Py_buffer series, yaw, least;
    if (umg_buffer(yaw_object, &yaw, 'd', -1, 1, "yaw") < 0)
        return NULL;
    Py_ssize_t count = yaw.len / 8;
    if (umg_buffer(least_object, &least, 'd', count, 1, "least") < 0) {
        PyBuffer_Release(&yaw);
        return NULL;
    }
    if (frequencies < 1 || umg_buffer(series_object, &series, 'f', 2 * frequencies * count, 0, "series") < 0) {
        PyBuffer_Release(&least);
        PyBuffer_Release(&yaw);
        return frequencies < 1 ? PyErr_Format(PyExc_ValueError, "frequencies: expected at least 1") : NULL;
    }
    const float *c = series.buf;
    double *angle = yaw.buf, *best = least.buf;
    Py_BEGIN_ALLOW_THREADS
    for (Py_ssize_t n = 0; n < count; n++) {
        double start = angle[n], here = start, value, slope, bend;
        evaluate(c + 2 * frequencies * n, frequencies, start, &value, &slope, &bend);
        best[n] = value;
        for (int step = 0; step < 4 && bend > 0; step++) {
            double move = slope / bend;
            here = fmin(fmax(here - move, start - reach), start + reach);
            evaluate(c + 2 * frequencies * n, frequencies, here, &value, &slope, &bend);
            if (value < best[n]) {
                best[n] = value;
                angle[n] = here;
            }
            if (fabs(move) < 1e-5)
                break;
        }
    }
    Py_END_ALLOW_THREADS
    PyBuffer_Release(&series);
    PyBuffer_Release(&least);
    PyBuffer_Release(&yaw);
    Py_RETURN_NONE;
}

PyMethodDef umg_correlation_methods[] = {
    {"window_diagonals", window_diagonals, METH_VARARGS,
     "window_diagonals(values, weights, windowed, rows, columns): windowed[r, c] = sum_l weights[l] values[r + l, c + l], "
     "complex64 given as float32 pairs."},
    {"refine_yaw", refine_yaw, METH_VARARGS,
     "refine_yaw(series, yaw, least, frequencies, reach): minimum of each Fourier series (count, frequencies) near its yaw."},
    {NULL, NULL, 0, NULL},
};
