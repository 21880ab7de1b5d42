/* Which triangle of an atlas covers each texel, and the spread of covered texels into the gutters between charts. */
#include "umg.h"

#include <math.h>

static PyObject *raster_charts(PyObject *self, PyObject *args) {
    (void)self;
    PyObject *corners_object, *owner_object, *weights_object, *overlap_object;
    Py_ssize_t width, height;
    if (!PyArg_ParseTuple(args, "OOOOnn", &corners_object, &owner_object, &weights_object, &overlap_object, &width, &height))
        return NULL;
    if (width <= 0 || height <= 0 || width > 1 << 15 || height > 1 << 15)
        return PyErr_Format(PyExc_ValueError, "width, height: expected 1..32768");
    Py_buffer corners, owner, weights, overlap;
    if (umg_buffer(corners_object, &corners, 'd', -1, 0, "corners") < 0)
        return NULL;
    Py_ssize_t count = corners.len / 48;
    if (umg_buffer(owner_object, &owner, 'i', width * height, 1, "owner") < 0)
        goto release_corners;
    if (umg_buffer(weights_object, &weights, 'f', width * height * 3, 1, "weights") < 0)
        goto release_owner;
    if (umg_buffer(overlap_object, &overlap, 'B', count, 1, "overlap") < 0)
        goto release_weights;
    Py_BEGIN_ALLOW_THREADS
    int *own = owner.buf;
    float *bary = weights.buf;
    uint8_t *clash = overlap.buf;
    for (Py_ssize_t f = 0; f < count; f++) {
        const double *t = (const double *)corners.buf + 6 * f;
        double ux = t[2] - t[0], uy = t[3] - t[1], vx = t[4] - t[0], vy = t[5] - t[1];
        double twice = ux * vy - uy * vx;
        if (!(fabs(twice) > 1e-12))
            continue;
        double left = fmin(t[0], fmin(t[2], t[4])), right = fmax(t[0], fmax(t[2], t[4]));
        double top = fmin(t[1], fmin(t[3], t[5])), bottom = fmax(t[1], fmax(t[3], t[5]));
        Py_ssize_t x0 = (Py_ssize_t)fmax(0, ceil(left - 0.5)), x1 = (Py_ssize_t)fmin((double)width - 1, floor(right - 0.5));
        Py_ssize_t y0 = (Py_ssize_t)fmax(0, ceil(top - 0.5)), y1 = (Py_ssize_t)fmin((double)height - 1, floor(bottom - 0.5));
        for (Py_ssize_t y = y0; y <= y1; y++)
            for (Py_ssize_t x = x0; x <= x1; x++) {
                double px = (double)x + 0.5 - t[0], py = (double)y + 0.5 - t[1];
                double b = (px * vy - py * vx) / twice, c = (ux * py - uy * px) / twice, a = 1 - b - c;
                double inside = fmin(a, fmin(b, c));
                if (inside < -1e-9)
                    continue;
                Py_ssize_t texel = y * width + x;
                if (own[texel] >= 0) {
                    float *w = bary + 3 * texel;
                    if (inside > 1e-4 && fminf(w[0], fminf(w[1], w[2])) > 1e-4f)
                        clash[f] = 1;
                    continue;
                }
                own[texel] = (int)f;
                bary[3 * texel] = (float)a;
                bary[3 * texel + 1] = (float)b;
                bary[3 * texel + 2] = (float)c;
            }
    }
    Py_END_ALLOW_THREADS
    PyBuffer_Release(&overlap);
    PyBuffer_Release(&weights);
    PyBuffer_Release(&owner);
    PyBuffer_Release(&corners);
    Py_RETURN_NONE;
release_weights:
    PyBuffer_Release(&weights);
release_owner:
    PyBuffer_Release(&owner);
release_corners:
    PyBuffer_Release(&corners);
    return NULL;
}

/* Take over the nearer of the own and a neighbour's source texel. */
static void adopt(int *source, Py_ssize_t width, Py_ssize_t x, Py_ssize_t y, Py_ssize_t neighbour) {
    int other = source[neighbour], mine = source[y * width + x];
    if (other < 0)
        return;
    Py_ssize_t dx = other % width - x, dy = other / width - y;
    if (mine >= 0) {
        Py_ssize_t ex = mine % width - x, ey = mine / width - y;
        if (ex * ex + ey * ey <= dx * dx + dy * dy)
            return;
    }
    source[y * width + x] = other;
}

static PyObject *spread_texels(PyObject *self, PyObject *args) {
    (void)self;
    PyObject *source_object;
    Py_ssize_t width, height;
    if (!PyArg_ParseTuple(args, "Onn", &source_object, &width, &height))
        return NULL;
    if (width <= 0 || height <= 0 || width > 1 << 15 || height > 1 << 15)
        return PyErr_Format(PyExc_ValueError, "width, height: expected 1..32768");
    Py_buffer source;
    if (umg_buffer(source_object, &source, 'i', width * height, 1, "source") < 0)
        return NULL;
    Py_BEGIN_ALLOW_THREADS
    int *s = source.buf;
    for (Py_ssize_t y = 0; y < height; y++) {
        for (Py_ssize_t x = 0; x < width; x++) {
            if (y > 0)
                adopt(s, width, x, y, (y - 1) * width + x);
            if (x > 0)
                adopt(s, width, x, y, y * width + x - 1);
        }
        for (Py_ssize_t x = width - 2; x >= 0; x--)
            adopt(s, width, x, y, y * width + x + 1);
    }
    for (Py_ssize_t y = height - 2; y >= 0; y--) {
        for (Py_ssize_t x = 0; x < width; x++) {
            adopt(s, width, x, y, (y + 1) * width + x);
            if (x > 0)
                adopt(s, width, x, y, y * width + x - 1);
        }
        for (Py_ssize_t x = width - 2; x >= 0; x--)
            adopt(s, width, x, y, y * width + x + 1);
    }
    Py_END_ALLOW_THREADS
    PyBuffer_Release(&source);
    Py_RETURN_NONE;
}

PyMethodDef umg_chart_raster_methods[] = {
    {"raster_charts", raster_charts, METH_VARARGS,
     "raster_charts(corners, owner, weights, overlap, width, height): first triangle over each texel centre, its weights, and "
     "which triangles found their place taken."},
    {"spread_texels", spread_texels, METH_VARARGS,
     "spread_texels(source, width, height): fill each -1 of `source` with the (nearly) nearest texel's source."},
    {NULL, NULL, 0, NULL},
};
