/* Normal equations of cage registration: corotated stiffness of the tets and point-to-plane data, in 3x3 blocks. */
#include "umg.h"

/* The ten vertex pairs of a tet whose blocks are stored: (row, column) corners with row >= column in storage order. */
static const int PAIR[10][2] = {{0, 0}, {1, 1}, {2, 2}, {3, 3}, {0, 1}, {0, 2}, {0, 3}, {1, 2}, {1, 3}, {2, 3}};

static PyObject *corotated_stiffness(PyObject *self, PyObject *args) {
    (void)self;
    PyObject *gradients_object, *volumes_object, *rotations_object, *block_object, *flip_object, *blocks_object;
    if (!PyArg_ParseTuple(args, "OOOOOO", &gradients_object, &volumes_object, &rotations_object, &block_object, &flip_object,
                          &blocks_object))
        return NULL;
    Py_buffer volumes, gradients, rotations, block, flip, blocks;
    if (umg_buffer(volumes_object, &volumes, 'd', -1, 0, "volumes") < 0)
        return NULL;
    Py_ssize_t count = volumes.len / 8;
    if (umg_buffer(gradients_object, &gradients, 'd', 12 * count, 0, "gradients") < 0)
        goto volumes_only;
    if (umg_buffer(rotations_object, &rotations, 'd', 9 * count, 0, "rotations") < 0)
        goto gradients_too;
    if (umg_buffer(block_object, &block, 'i', 10 * count, 0, "block") < 0)
        goto rotations_too;
    if (umg_buffer(flip_object, &flip, 'B', 10 * count, 0, "flip") < 0)
        goto block_too;
    if (umg_buffer(blocks_object, &blocks, 'd', -1, 1, "blocks") < 0)
        goto flip_too;
    const double *g = gradients.buf, *v = volumes.buf, *r = rotations.buf;
    const int32_t *index = block.buf;
    const uint8_t *flipped = flip.buf;
    double *out = blocks.buf;
    int64_t stored = blocks.len / 72;
    int bad = 0;
    Py_BEGIN_ALLOW_THREADS
    for (Py_ssize_t q = 0; q < count && !bad; q++) {
        double turned[4][3];
        for (int i = 0; i < 4; i++)
            for (int a = 0; a < 3; a++)
                turned[i][a] = r[9 * q + 3 * a] * g[12 * q + 3 * i] + r[9 * q + 3 * a + 1] * g[12 * q + 3 * i + 1] +
                               r[9 * q + 3 * a + 2] * g[12 * q + 3 * i + 2];
        for (int p = 0; p < 10; p++) {
            int i = PAIR[p][0], j = PAIR[p][1];
            int64_t at = index[10 * q + p];
            if (at < 0 || at >= stored) {
                bad = 1;
                break;
            }
            if (flipped[10 * q + p]) {
                int swap = i;
                i = j;
                j = swap;
            }
            double *b = out + 9 * at, w = v[q];
            double dot = turned[i][0] * turned[j][0] + turned[i][1] * turned[j][1] + turned[i][2] * turned[j][2];
            for (int a = 0; a < 3; a++)
                for (int c = 0; c < 3; c++)
                    b[3 * a + c] += w * (turned[j][a] * turned[i][c] + (a == c ? dot : 0.0));
        }
    }
    Py_END_ALLOW_THREADS
    PyBuffer_Release(&blocks);
    PyBuffer_Release(&flip);
    PyBuffer_Release(&block);
    PyBuffer_Release(&rotations);
    PyBuffer_Release(&gradients);
    PyBuffer_Release(&volumes);
    if (bad) {
        PyErr_SetString(PyExc_IndexError, "block: index out of range");
        return NULL;
    }
    Py_RETURN_NONE;
flip_too:
    PyBuffer_Release(&flip);
block_too:
    PyBuffer_Release(&block);
rotations_too:
    PyBuffer_Release(&rotations);
gradients_too:
    PyBuffer_Release(&gradients);
volumes_only:
    PyBuffer_Release(&volumes);
    return NULL;
}

static PyObject *plane_blocks(PyObject *self, PyObject *args) {
    (void)self;
    PyObject *tet_object, *weights_object, *normals_object, *strength_object, *block_object, *blocks_object;
    if (!PyArg_ParseTuple(args, "OOOOOO", &tet_object, &weights_object, &normals_object, &strength_object, &block_object,
                          &blocks_object))
        return NULL;
    Py_buffer tet, weights, normals, strength, block, blocks;
    if (umg_buffer(tet_object, &tet, 'i', -1, 0, "tet") < 0)
        return NULL;
    Py_ssize_t count = tet.len / 4;
    if (umg_buffer(weights_object, &weights, 'd', 4 * count, 0, "weights") < 0)
        goto tet_only;
    if (umg_buffer(normals_object, &normals, 'd', 3 * count, 0, "normals") < 0)
        goto weights_too;
    if (umg_buffer(strength_object, &strength, 'd', count, 0, "strength") < 0)
        goto normals_too;
    if (umg_buffer(block_object, &block, 'i', -1, 0, "block") < 0)
        goto strength_too;
    if (umg_buffer(blocks_object, &blocks, 'd', -1, 1, "blocks") < 0)
        goto block_too;
    const int32_t *cell = tet.buf, *index = block.buf;
    const double *w = weights.buf, *n = normals.buf, *s = strength.buf;
    double *out = blocks.buf;
    int64_t stored = blocks.len / 72, cells = block.len / 40;
    int bad = 0;
    Py_BEGIN_ALLOW_THREADS
    for (Py_ssize_t q = 0; q < count; q++) {
        if (cell[q] < 0 || cell[q] >= cells) {
            bad = 1;
            break;
        }
        const double *normal = n + 3 * q, *weight = w + 4 * q;
        double outer[9];
        for (int a = 0; a < 3; a++)
            for (int c = 0; c < 3; c++)
                outer[3 * a + c] = s[q] * normal[a] * normal[c];
        for (int p = 0; p < 10 && !bad; p++) {
            int64_t at = index[10 * (int64_t)cell[q] + p];
            if (at < 0 || at >= stored) {
                bad = 1;
                break;
            }
            double *b = out + 9 * at, product = weight[PAIR[p][0]] * weight[PAIR[p][1]];
            for (int a = 0; a < 9; a++)
                b[a] += product * outer[a];
        }
    }
    Py_END_ALLOW_THREADS
    PyBuffer_Release(&blocks);
    PyBuffer_Release(&block);
    PyBuffer_Release(&strength);
    PyBuffer_Release(&normals);
    PyBuffer_Release(&weights);
    PyBuffer_Release(&tet);
    if (bad) {
        PyErr_SetString(PyExc_IndexError, "tet or block: index out of range");
        return NULL;
    }
    Py_RETURN_NONE;
block_too:
    PyBuffer_Release(&block);
strength_too:
    PyBuffer_Release(&strength);
normals_too:
    PyBuffer_Release(&normals);
weights_too:
    PyBuffer_Release(&weights);
tet_only:
    PyBuffer_Release(&tet);
    return NULL;
}

PyMethodDef umg_registration_methods[] = {
    {"corotated_stiffness", corotated_stiffness, METH_VARARGS,
     "corotated_stiffness(gradients, volumes, rotations, block, flip, blocks): add |tet| (g_i.g_j I + R g_j (R g_i)^T) of every "
     "tet's ten vertex pairs to the 3x3 blocks named by block; flip marks pairs stored as (j, i)."},
    {"plane_blocks", plane_blocks, METH_VARARGS,
     "plane_blocks(tet, weights, normals, strength, block, blocks): add strength w_i w_j n n^T of points embedded in tets."},
    {NULL, NULL, 0, NULL},
};
