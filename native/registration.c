/* Normal equations of cage registration: corotated stiffness of the tets and point-to-plane data, in 3x3 blocks. */
#include "arguments.h"
#include "rotations.h"

#include <math.h>

/* The ten vertex pairs of a tet whose blocks are stored: (row, column) corners with row >= column in storage order. */
static const int PAIR[10][2] = {{0, 0}, {1, 1}, {2, 2}, {3, 3}, {0, 1}, {0, 2}, {0, 3}, {1, 2}, {1, 3}, {2, 3}};

/* Whether all `count` indices are in 0..limit-1. */
static int in_range(const int32_t *index, Py_ssize_t count, Py_ssize_t limit) {
    for (Py_ssize_t i = 0; i < count; i++)
        if (index[i] < 0 || index[i] >= limit)
            return 0;
    return 1;
}

static void add_arap(Py_ssize_t count, const double *gradients, const double *weights, const double *x, const int32_t *tets,
                     const int32_t *block, const uint8_t *flip, double *blocks, double *right) {
    for (Py_ssize_t q = 0; q < count; q++) {
        const double *g = gradients + 12 * q;
        const int32_t *tet = tets + 4 * q;
        double f[9] = {0}, r[9], turned[4][3], w = weights[q];
        for (int i = 0; i < 4; i++)
            for (int a = 0; a < 3; a++)
                for (int b = 0; b < 3; b++)
                    f[3 * a + b] += x[3 * (Py_ssize_t)tet[i] + a] * g[3 * i + b];
        umg_nearest_rotation(f, r);
        for (int i = 0; i < 4; i++)
            for (int a = 0; a < 3; a++) {
                turned[i][a] = r[3 * a] * g[3 * i] + r[3 * a + 1] * g[3 * i + 1] + r[3 * a + 2] * g[3 * i + 2];
                double mapped = f[3 * a] * g[3 * i] + f[3 * a + 1] * g[3 * i + 1] + f[3 * a + 2] * g[3 * i + 2];
                right[3 * (Py_ssize_t)tet[i] + a] -= w * (mapped - turned[i][a]);
            }
        for (int p = 0; p < 10; p++) {
            int i = PAIR[p][0], j = PAIR[p][1];
            if (flip[10 * q + p]) {
                int swap = i;
                i = j;
                j = swap;
            }
            double *b = blocks + 9 * (Py_ssize_t)block[10 * q + p];
            double dot = turned[i][0] * turned[j][0] + turned[i][1] * turned[j][1] + turned[i][2] * turned[j][2];
            for (int a = 0; a < 3; a++)
                for (int c = 0; c < 3; c++)
                    b[3 * a + c] += w * (turned[j][a] * turned[i][c] + (a == c ? dot : 0.0));
        }
    }
}

static PyObject *arap_terms(PyObject *self, PyObject *args) {
    (void)self;
    PyObject *o[8];
    if (!PyArg_ParseTuple(args, "OOOOOOOO", &o[0], &o[1], &o[2], &o[3], &o[4], &o[5], &o[6], &o[7]))
        return NULL;
    Py_buffer views[8];
    if (umg_buffer(o[0], &views[0], 'd', -1, 0, "weights") < 0)
        return NULL;
    Py_ssize_t count = views[0].len / 8;
    Argument wanted[7] = {{'d', 12 * count, 0, "gradients"}, {'d', -1, 0, "vertices"},     {'i', 4 * count, 0, "tets"},
                          {'i', 10 * count, 0, "block"},     {'B', 10 * count, 0, "flip"}, {'d', -1, 1, "blocks"},
                          {'d', -1, 1, "right"}};
    if (take_arguments(o + 1, wanted, views + 1, 7) < 0) {
        PyBuffer_Release(&views[0]);
        return NULL;
    }
    int fits = views[2].len == views[7].len && in_range(views[3].buf, 4 * count, views[2].len / 24) &&
               in_range(views[4].buf, 10 * count, views[6].len / 72);
    if (fits) {
        Py_BEGIN_ALLOW_THREADS
        add_arap(count, views[1].buf, views[0].buf, views[2].buf, views[3].buf, views[4].buf, views[5].buf, views[6].buf,
                 views[7].buf);
        Py_END_ALLOW_THREADS
    }
    release_arguments(views, 8);
    if (!fits) {
        PyErr_SetString(PyExc_IndexError, "tets or block: index out of range");
        return NULL;
    }
    Py_RETURN_NONE;
}

static void add_planes(Py_ssize_t count, const int32_t *cell, const double *weights, const double *planes, const double *strength,
                       const double *offsets, const int32_t *tets, const int32_t *block, double *blocks, double *right) {
    for (Py_ssize_t q = 0; q < count; q++) {
        double s = strength[q];
        if (s == 0)
            continue;
        const double *n = planes + 3 * q, *w = weights + 4 * q;
        double outer[9];
        for (int a = 0; a < 3; a++)
            for (int c = 0; c < 3; c++)
                outer[3 * a + c] = s * n[a] * n[c];
        for (int i = 0; i < 4; i++)
            for (int a = 0; a < 3; a++)
                right[3 * (Py_ssize_t)tets[4 * (Py_ssize_t)cell[q] + i] + a] += s * offsets[q] * w[i] * n[a];
        for (int p = 0; p < 10; p++) {
            double *b = blocks + 9 * (Py_ssize_t)block[10 * (Py_ssize_t)cell[q] + p], product = w[PAIR[p][0]] * w[PAIR[p][1]];
            for (int a = 0; a < 9; a++)
                b[a] += product * outer[a];
        }
    }
}

static PyObject *plane_terms(PyObject *self, PyObject *args) {
    (void)self;
    PyObject *o[9];
    if (!PyArg_ParseTuple(args, "OOOOOOOOO", &o[0], &o[1], &o[2], &o[3], &o[4], &o[5], &o[6], &o[7], &o[8]))
        return NULL;
    Py_buffer views[9];
    if (umg_buffer(o[0], &views[0], 'i', -1, 0, "tet") < 0)
        return NULL;
    Py_ssize_t count = views[0].len / 4;
    Argument wanted[8] = {{'d', 4 * count, 0, "weights"}, {'d', 3 * count, 0, "planes"}, {'d', count, 0, "strength"},
                          {'d', count, 0, "offsets"},     {'i', -1, 0, "tets"},          {'i', -1, 0, "block"},
                          {'d', -1, 1, "blocks"},         {'d', -1, 1, "right"}};
    if (take_arguments(o + 1, wanted, views + 1, 8) < 0) {
        PyBuffer_Release(&views[0]);
        return NULL;
    }
    Py_ssize_t cells = views[5].len / 16;
    int fits = views[6].len == 40 * cells && in_range(views[0].buf, count, cells) &&
               in_range(views[5].buf, 4 * cells, views[8].len / 24) && in_range(views[6].buf, 10 * cells, views[7].len / 72);
    if (fits) {
        Py_BEGIN_ALLOW_THREADS
        add_planes(count, views[0].buf, views[1].buf, views[2].buf, views[3].buf, views[4].buf, views[5].buf, views[6].buf,
                   views[7].buf, views[8].buf);
        Py_END_ALLOW_THREADS
    }
    release_arguments(views, 9);
    if (!fits) {
        PyErr_SetString(PyExc_IndexError, "tet, tets or block: index out of range");
        return NULL;
    }
    Py_RETURN_NONE;
}

static void make_planes(Py_ssize_t count, const double *points, const double *normals, const double *goals,
                        const double *goal_normals, const double *shares, double width, double *planes, double *weights,
                        double *offsets) {
    for (Py_ssize_t q = 0; q < count; q++) {
        const double *n = normals + 3 * q, *m = goal_normals + 3 * q;
        double away[3], mean[3], squared = 0, cosine = 0, length = 0, offset = 0;
        for (int a = 0; a < 3; a++) {
            away[a] = goals[3 * q + a] - points[3 * q + a];
            mean[a] = n[a] + m[a];
            squared += away[a] * away[a];
            cosine += n[a] * m[a];
            length += mean[a] * mean[a];
        }
        double ratio = squared / (width * width), inverse = length > 0 ? 1 / sqrt(length) : 0;
        /* Beyond this a weight is below 1e-6 of its share. */
        weights[q] = cosine > 0.5 && ratio < 13.8 ? shares[q] * exp(-ratio) * cosine : 0;
        for (int a = 0; a < 3; a++) {
            planes[3 * q + a] = mean[a] * inverse;
            offset += planes[3 * q + a] * away[a];
        }
        offsets[q] = offset;
    }
}

static PyObject *symmetric_planes(PyObject *self, PyObject *args) {
    (void)self;
    PyObject *o[8];
    double width;
    if (!PyArg_ParseTuple(args, "OOOOOdOOO", &o[4], &o[0], &o[1], &o[2], &o[3], &width, &o[5], &o[6], &o[7]))
        return NULL;
    Py_buffer views[8];
    if (umg_buffer(o[4], &views[4], 'd', -1, 0, "shares") < 0)
        return NULL;
    Py_ssize_t count = views[4].len / 8;
    Argument inputs[4] = {{'d', 3 * count, 0, "points"},
                          {'d', 3 * count, 0, "normals"},
                          {'d', 3 * count, 0, "goals"},
                          {'d', 3 * count, 0, "goal_normals"}};
    Argument outputs[3] = {{'d', 3 * count, 1, "planes"}, {'d', count, 1, "weights"}, {'d', count, 1, "offsets"}};
    if (take_arguments(o, inputs, views, 4) < 0) {
        PyBuffer_Release(&views[4]);
        return NULL;
    }
    if (take_arguments(o + 5, outputs, views + 5, 3) < 0) {
        release_arguments(views, 5);
        return NULL;
    }
    Py_BEGIN_ALLOW_THREADS
    make_planes(count, views[0].buf, views[1].buf, views[2].buf, views[3].buf, views[4].buf, width, views[5].buf, views[6].buf,
                views[7].buf);
    Py_END_ALLOW_THREADS
    release_arguments(views, 8);
    Py_RETURN_NONE;
}

PyMethodDef umg_registration_methods[] = {
    {"arap_terms", arap_terms, METH_VARARGS,
     "arap_terms(weights, gradients, vertices, tets, block, flip, blocks, right): with F and its nearest rotation R in every "
     "tet, add weight (g_i.g_j I + R g_j (R g_i)^T) of its ten vertex pairs to the 3x3 blocks named by block (flip marks pairs "
     "stored as (j, i)) and subtract weight (F - R) g_i from right."},
    {"plane_terms", plane_terms, METH_VARARGS,
     "plane_terms(tet, weights, planes, strength, offsets, tets, block, blocks, right): add strength w_i w_j n n^T and strength "
     "offset w_i n of points embedded in tets."},
    {"symmetric_planes", symmetric_planes, METH_VARARGS,
     "symmetric_planes(shares, points, normals, goals, goal_normals, width, planes, weights, offsets): unit means of the two "
     "normals, share exp(-(d / width)^2) cos (0 where cos <= 1/2 or the rest is below 1e-6), and distances along the planes."},
    {NULL, NULL, 0, NULL},
};
