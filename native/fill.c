/* Push-pull: fill the unknown texels of an image smoothly from the known ones. */
#include "arguments.h"

#include <stdlib.h>

/* Halve: each parent gets the mean of its known children, known if any is. */
static void push(const float *fine, int64_t height, int64_t width, float *coarse, int64_t rows, int64_t columns) {
    for (int64_t r = 0; r < rows; r++)
        for (int64_t k = 0; k < columns; k++) {
            float sum[3] = {0, 0, 0}, weight = 0;
            for (int64_t y = 2 * r; y < 2 * r + 2 && y < height; y++)
                for (int64_t x = 2 * k; x < 2 * k + 2 && x < width; x++) {
                    const float *p = fine + 4 * (y * width + x);
                    if (p[3] > 0) {
                        for (int c = 0; c < 3; c++)
                            sum[c] += p[c];
                        weight += 1;
                    }
                }
            float *out = coarse + 4 * (r * columns + k);
            for (int c = 0; c < 3; c++)
                out[c] = weight > 0 ? sum[c] / weight : 0;
            out[3] = weight > 0;
        }
}

/* Unknown texels take the bilinear value of the (wholly known) parent level. */
static void pull(float *fine, int64_t height, int64_t width, const float *coarse, int64_t rows, int64_t columns) {
    for (int64_t y = 0; y < height; y++)
        for (int64_t x = 0; x < width; x++) {
            float *p = fine + 4 * (y * width + x);
            if (p[3] > 0)
                continue;
            int64_t r = y / 2, k = x / 2;
            int64_t r2 = r + (y % 2 ? 1 : -1), k2 = k + (x % 2 ? 1 : -1);
            r2 = r2 < 0 ? 0 : r2 >= rows ? rows - 1 : r2;
            k2 = k2 < 0 ? 0 : k2 >= columns ? columns - 1 : k2;
            const float *a = coarse + 4 * (r * columns + k), *b = coarse + 4 * (r * columns + k2);
            const float *d = coarse + 4 * (r2 * columns + k), *e = coarse + 4 * (r2 * columns + k2);
            for (int c = 0; c < 3; c++)
                p[c] = 0.5625f * a[c] + 0.1875f * (b[c] + d[c]) + 0.0625f * e[c];
            p[3] = 1;
        }
}

static int fill(float *image, int64_t height, int64_t width) {
    if (height <= 1 && width <= 1)
        return 0;
    int64_t rows = (height + 1) / 2, columns = (width + 1) / 2;
    float *coarse = malloc(sizeof(float) * 4 * (size_t)(rows * columns));
    if (coarse == NULL)
        return -1;
    push(image, height, width, coarse, rows, columns);
    int failed = fill(coarse, rows, columns);
    if (!failed)
        pull(image, height, width, coarse, rows, columns);
    free(coarse);
    return failed;
}

static PyObject *fill_unknown(PyObject *self, PyObject *args) {
    (void)self;
    PyObject *object;
    Py_ssize_t height, width;
    if (!PyArg_ParseTuple(args, "Onn", &object, &height, &width))
        return NULL;
    Argument wanted = {'f', 4 * height * width, 1, "image"};
    Py_buffer view;
    if (take_arguments(&object, &wanted, &view, 1) < 0)
        return NULL;
    int failed;
    Py_BEGIN_ALLOW_THREADS
    failed = fill(view.buf, height, width);
    Py_END_ALLOW_THREADS
    release_arguments(&view, 1);
    if (failed)
        return PyErr_NoMemory();
    Py_RETURN_NONE;
}

PyMethodDef umg_fill_methods[] = {
    {"fill_unknown", fill_unknown, METH_VARARGS,
     "fill_unknown(image, height, width): in a (height, width, 4) float32 image give texels whose fourth channel is 0 a smooth "
     "colour from the known ones, in place; the fourth channel becomes 1."},
    {NULL, NULL, 0, NULL},
};
