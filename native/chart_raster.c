/* Which triangle of an atlas covers each texel, and the spread of covered texels into the gutters between charts. */
#include "umg.h"

#include <math.h>

/* Barycentric weight i of texel centre (x, y) is at[i] + x * across[i] + y * down[i]. */
typedef struct {
    double at[3], across[3], down[3];
    double left, right;
    Py_ssize_t top, bottom; /* rows whose texel centres may lie inside, both ends included */
} Triangle;

static int set_up(const double *t, Py_ssize_t width, Py_ssize_t height, Triangle *s) {
    double ux = t[2] - t[0], uy = t[3] - t[1], vx = t[4] - t[0], vy = t[5] - t[1], twice = ux * vy - uy * vx;
    if (!(fabs(twice) > 1e-12))
        return 0;
    s->across[1] = vy / twice, s->down[1] = -vx / twice;
    s->across[2] = -uy / twice, s->down[2] = ux / twice;
    for (int i = 1; i < 3; i++)
        s->at[i] = (0.5 - t[0]) * s->across[i] + (0.5 - t[1]) * s->down[i];
    s->at[0] = 1 - s->at[1] - s->at[2];
    s->across[0] = -s->across[1] - s->across[2];
    s->down[0] = -s->down[1] - s->down[2];
    s->left = fmax(0, ceil(fmin(t[0], fmin(t[2], t[4])) - 0.5));
    s->right = fmin((double)width - 1, floor(fmax(t[0], fmax(t[2], t[4])) - 0.5));
    s->top = (Py_ssize_t)fmax(0, ceil(fmin(t[1], fmin(t[3], t[5])) - 0.5));
    s->bottom = (Py_ssize_t)fmin((double)height - 1, floor(fmax(t[1], fmax(t[3], t[5])) - 0.5));
    return 1;
}

/* Columns first..last of row y in which all weights are at least `least`; none where last < first. */
static void span(const Triangle *s, Py_ssize_t y, double least, Py_ssize_t *first, Py_ssize_t *last) {
    double low = s->left, high = s->right;
    for (int i = 0; i < 3; i++) {
        double start = s->at[i] + (double)y * s->down[i] - least, step = s->across[i];
        if (step > 0)
            low = fmax(low, ceil(-start / step));
        else if (step < 0)
            high = fmin(high, floor(-start / step));
        else if (start < 0)
            high = -1;
    }
    *first = (Py_ssize_t)low;
    *last = high < low ? *first - 1 : (Py_ssize_t)high;
}

static PyObject *raster_charts(PyObject *self, PyObject *args) {
    (void)self;
    PyObject *corners_object, *owner_object, *weights_object;
    Py_ssize_t width, height;
    if (!PyArg_ParseTuple(args, "OOOnn", &corners_object, &owner_object, &weights_object, &width, &height))
        return NULL;
    if (width <= 0 || height <= 0 || width > 1 << 15 || height > 1 << 15)
        return PyErr_Format(PyExc_ValueError, "width, height: expected 1..32768");
    Py_buffer corners, owner, weights;
    if (umg_buffer(corners_object, &corners, 'd', -1, 0, "corners") < 0)
        return NULL;
    if (umg_buffer(owner_object, &owner, 'i', width * height, 1, "owner") < 0) {
        PyBuffer_Release(&corners);
        return NULL;
    }
    if (umg_buffer(weights_object, &weights, 'f', width * height * 3, 1, "weights") < 0) {
        PyBuffer_Release(&owner);
        PyBuffer_Release(&corners);
        return NULL;
    }
    Py_BEGIN_ALLOW_THREADS
    int *own = owner.buf;
    float *bary = weights.buf;
    Py_ssize_t count = corners.len / 48;
    for (Py_ssize_t f = 0; f < count; f++) {
        Triangle s;
        if (!set_up((const double *)corners.buf + 6 * f, width, height, &s))
            continue;
        for (Py_ssize_t y = s.top; y <= s.bottom; y++) {
            Py_ssize_t first, last;
            span(&s, y, -1e-9, &first, &last);
            for (Py_ssize_t x = first; x <= last; x++) {
                Py_ssize_t texel = y * width + x;
                if (own[texel] >= 0)
                    continue;
                own[texel] = (int)f;
                for (int i = 0; i < 3; i++)
                    bary[3 * texel + i] = (float)(s.at[i] + (double)x * s.across[i] + (double)y * s.down[i]);
            }
        }
    }
    Py_END_ALLOW_THREADS
    PyBuffer_Release(&weights);
    PyBuffer_Release(&owner);
    PyBuffer_Release(&corners);
    Py_RETURN_NONE;
}

static PyObject *find_overlaps(PyObject *self, PyObject *args) {
    (void)self;
    PyObject *corners_object, *taken_object, *overlap_object;
    Py_ssize_t width, height;
    if (!PyArg_ParseTuple(args, "OOOnn", &corners_object, &taken_object, &overlap_object, &width, &height))
        return NULL;
    if (width <= 0 || height <= 0 || width > 1 << 15 || height > 1 << 15)
        return PyErr_Format(PyExc_ValueError, "width, height: expected 1..32768");
    Py_buffer corners, taken, overlap;
    if (umg_buffer(corners_object, &corners, 'd', -1, 0, "corners") < 0)
        return NULL;
    Py_ssize_t count = corners.len / 48;
    if (umg_buffer(taken_object, &taken, 'B', width * height, 1, "taken") < 0) {
        PyBuffer_Release(&corners);
        return NULL;
    }
    if (umg_buffer(overlap_object, &overlap, 'B', count, 1, "overlap") < 0) {
        PyBuffer_Release(&taken);
        PyBuffer_Release(&corners);
        return NULL;
    }
    Py_BEGIN_ALLOW_THREADS
    uint8_t *used = taken.buf, *clash = overlap.buf;
    for (Py_ssize_t f = 0; f < count; f++) {
        Triangle s;
        if (!set_up((const double *)corners.buf + 6 * f, width, height, &s))
            continue;
        for (int marking = 0; marking < 2 && !clash[f]; marking++)
            for (Py_ssize_t y = s.top; y <= s.bottom; y++) {
                Py_ssize_t first, last;
                span(&s, y, 1e-3, &first, &last); /* a texel on a common edge belongs to both */
                uint8_t *row = used + y * width;
                for (Py_ssize_t x = first; x <= last; x++)
                    if (marking)
                        row[x] = 1;
                    else
                        clash[f] |= row[x];
            }
    }
    Py_END_ALLOW_THREADS
    PyBuffer_Release(&overlap);
    PyBuffer_Release(&taken);
    PyBuffer_Release(&corners);
    Py_RETURN_NONE;
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
     "raster_charts(corners, owner, weights, width, height): first triangle over each texel centre, and its weights."},
    {"find_overlaps", find_overlaps, METH_VARARGS,
     "find_overlaps(corners, taken, overlap, width, height): which triangles lie over earlier ones that overlap none."},
    {"spread_texels", spread_texels, METH_VARARGS,
     "spread_texels(source, width, height): fill each -1 of `source` with the (nearly) nearest texel's source."},
    {NULL, NULL, 0, NULL},
};
