/* Multifrontal Cholesky factors of a sparse symmetric matrix of 3x3 blocks; the symbolic part is made in Python.
 *
 * A front of a supernode with p pivot nodes and m further nodes is a dense lower triangle of 3 (p + m) rows. Fronts come in
 * postorder; the part that is passed on to the parent waits on a stack. The first 3 p columns of each front are the factor. */
#include "umg.h"

#include <math.h>
#include <string.h>

typedef struct {
    const int32_t *pivots, *others, *parent, *relative, *entry_start, *entries;
    const int64_t *relative_start, *factor_start;
    Py_ssize_t count;
} Fronts;

/* row[0..length) -= sum_k left[k] * panel[k * stride ..]: four columns at a time, each element rounded in one fixed order. */
UMG_VECTORISED
static void subtract_columns(double *restrict row, const double *restrict left, const double *restrict panel, Py_ssize_t stride,
                             Py_ssize_t columns, Py_ssize_t length) {
    Py_ssize_t k = 0;
    for (; k + 4 <= columns; k += 4) {
        const double a = left[k], b = left[k + 1], c = left[k + 2], d = left[k + 3];
        const double *restrict p = panel + k * stride, *restrict q = p + stride, *restrict r = q + stride, *restrict s = r + stride;
        for (Py_ssize_t j = 0; j < length; j++)
            row[j] -= (a * p[j] + b * q[j]) + (c * r[j] + d * s[j]);
    }
    for (; k < columns; k++) {
        const double a = left[k];
        const double *restrict p = panel + k * stride;
        for (Py_ssize_t j = 0; j < length; j++)
            row[j] -= a * p[j];
    }
}

/* subtract_columns for two rows at once, which read the panel once; the second row is one longer. */
UMG_VECTORISED
static void subtract_from_two(double *restrict row, double *restrict below, const double *restrict left,
                              const double *restrict under, const double *restrict panel, Py_ssize_t stride, Py_ssize_t columns,
                              Py_ssize_t length) {
    Py_ssize_t k = 0;
    for (; k + 4 <= columns; k += 4) {
        const double a = left[k], b = left[k + 1], c = left[k + 2], d = left[k + 3];
        const double e = under[k], f = under[k + 1], g = under[k + 2], h = under[k + 3];
        const double *restrict p = panel + k * stride, *restrict q = p + stride, *restrict r = q + stride, *restrict s = r + stride;
        for (Py_ssize_t j = 0; j < length; j++) {
            row[j] -= (a * p[j] + b * q[j]) + (c * r[j] + d * s[j]);
            below[j] -= (e * p[j] + f * q[j]) + (g * r[j] + h * s[j]);
        }
        below[length] -= (e * p[length] + f * q[length]) + (g * r[length] + h * s[length]);
    }
    for (; k < columns; k++) {
        const double a = left[k], e = under[k];
        const double *restrict p = panel + k * stride;
        for (Py_ssize_t j = 0; j < length; j++) {
            row[j] -= a * p[j];
            below[j] -= e * p[j];
        }
        below[length] -= e * p[length];
    }
}

/* Sum of products in one fixed order: four sums side by side. */
UMG_VECTORISED
static double product(const double *restrict a, const double *restrict b, Py_ssize_t length) {
    double sum[4] = {0, 0, 0, 0};
    Py_ssize_t k = 0;
    for (; k + 4 <= length; k += 4)
        for (int i = 0; i < 4; i++)
            sum[i] += a[k + i] * b[k + i];
    for (; k < length; k++)
        sum[0] += a[k] * b[k];
    return (sum[0] + sum[1]) + (sum[2] + sum[3]);
}

UMG_VECTORISED
static void scale(double *restrict row, double factor, Py_ssize_t length) {
    for (Py_ssize_t j = 0; j < length; j++)
        row[j] *= factor;
}

/* Factor the first `width` columns of the n x n lower triangle (row-major) and update the rest. `panel` holds width x n.
 * Columns are taken in strips; below a strip's own triangle all work is on rows of the panel, its transpose, so that nearly
 * everything is in the vectorised subtractions. Returns 0 where a pivot is not positive. */
static int factor_front(double *front, Py_ssize_t n, Py_ssize_t width, double *panel) {
    enum { STRIP = 24 };
    for (Py_ssize_t begin = 0; begin < width; begin += STRIP) {
        Py_ssize_t end = begin + STRIP < width ? begin + STRIP : width;
        for (Py_ssize_t i = end; i < n; i++)
            for (Py_ssize_t k = begin; k < end; k++)
                panel[k * n + i] = front[i * n + k];
        for (Py_ssize_t k = begin; k < end; k++) {
            const double *own = front + k * n + begin;
            for (Py_ssize_t i = k; i < end; i++)
                front[i * n + k] -= product(front + i * n + begin, own, k - begin);
            double pivot = front[k * n + k];
            if (!(pivot > 0))
                return 0;
            pivot = sqrt(pivot);
            front[k * n + k] = pivot;
            double inverse = 1 / pivot;
            for (Py_ssize_t i = k + 1; i < end; i++)
                front[i * n + k] *= inverse;
            subtract_columns(panel + k * n + end, own, panel + begin * n + end, n, k - begin, n - end);
            scale(panel + k * n + end, inverse, n - end);
        }
        for (Py_ssize_t i = end; i < n; i++)
            for (Py_ssize_t k = begin; k < end; k++)
                front[i * n + k] = panel[k * n + i];
        Py_ssize_t i = end;
        for (; i + 1 < n; i += 2)
            subtract_from_two(front + i * n + end, front + (i + 1) * n + end, front + i * n + begin, front + (i + 1) * n + begin,
                              panel + begin * n + end, n, end - begin, i + 1 - end);
        for (; i < n; i++)
            subtract_columns(front + i * n + end, front + i * n + begin, panel + begin * n + end, n, end - begin, i + 1 - end);
    }
    return 1;
}

static int factor_all(const Fronts *f, const double *blocks, double damping, double *factor, double *stack, double *front,
                      double *panel) {
    double *top = stack;
    for (Py_ssize_t s = 0; s < f->count; s++) {
        Py_ssize_t nodes = f->pivots[s] + f->others[s], n = 3 * nodes, width = 3 * f->pivots[s];
        memset(front, 0, sizeof(double) * n * n);
        for (int32_t e = f->entry_start[s]; e < f->entry_start[s + 1]; e++) {
            /* block index, local row, local column, 1 where the block is stored transposed */
            const int32_t *entry = f->entries + 4 * (Py_ssize_t)e;
            const double *b = blocks + 9 * (Py_ssize_t)entry[0];
            double *at = front + 3 * entry[1] * n + 3 * entry[2];
            for (int i = 0; i < 3; i++)
                for (int j = 0; j < 3; j++)
                    at[i * n + j] = entry[3] ? b[3 * j + i] : b[3 * i + j];
        }
        for (Py_ssize_t k = 0; k < width; k++)
            front[k * n + k] += damping;
        /* Children wait on the stack in order; the last one is on top. */
        for (Py_ssize_t c = s - 1; c >= 0; c--) {
            if (f->parent[c] != s)
                continue;
            Py_ssize_t m = f->others[c], size = 3 * m;
            const int32_t *place = f->relative + f->relative_start[c];
            top -= size * size;
            for (Py_ssize_t i = 0; i < m; i++)
                for (Py_ssize_t j = 0; j <= i; j++) {
                    double *at = front + 3 * place[i] * n + 3 * place[j];
                    const double *from = top + 3 * i * size + 3 * j;
                    for (int a = 0; a < 3; a++)
                        for (int b = 0; b < 3; b++)
                            at[a * n + b] += from[a * size + b];
                }
        }
        if (!factor_front(front, n, width, panel))
            return 0;
        double *kept = factor + f->factor_start[s];
        for (Py_ssize_t i = 0; i < n; i++)
            memcpy(kept + i * width, front + i * n, sizeof(double) * width);
        Py_ssize_t size = n - width;
        if (f->parent[s] >= 0)
            for (Py_ssize_t i = 0; i < size; i++) {
                memcpy(top, front + (width + i) * n + width, sizeof(double) * size);
                top += size;
            }
    }
    return 1;
}

static void solve_all(const Fronts *f, const int32_t *node, const int64_t *node_start, const double *factor, double *x,
                      double *local) {
    for (Py_ssize_t s = 0; s < f->count; s++) {
        Py_ssize_t nodes = f->pivots[s] + f->others[s], n = 3 * nodes, width = 3 * f->pivots[s];
        const int32_t *index = node + node_start[s];
        const double *l = factor + f->factor_start[s];
        double *own = x + 3 * (Py_ssize_t)index[0];
        for (Py_ssize_t i = 0; i < width; i++) {
            own[i] = (own[i] - product(l + i * width, own, i)) / l[i * width + i];
        }
        for (Py_ssize_t i = width; i < n; i++) {
            x[3 * (Py_ssize_t)index[i / 3] + i % 3] -= product(l + i * width, own, width);
        }
    }
    for (Py_ssize_t s = f->count - 1; s >= 0; s--) {
        Py_ssize_t nodes = f->pivots[s] + f->others[s], n = 3 * nodes, width = 3 * f->pivots[s];
        const int32_t *index = node + node_start[s];
        const double *l = factor + f->factor_start[s];
        double *own = x + 3 * (Py_ssize_t)index[0];
        for (Py_ssize_t i = 0; i < n; i++)
            local[i] = x[3 * (Py_ssize_t)index[i / 3] + i % 3];
        subtract_columns(local, local + width, l + width * width, width, n - width, width);
        for (Py_ssize_t i = width - 1; i >= 0; i--) {
            local[i] /= l[i * width + i];
            for (Py_ssize_t k = 0; k < i; k++)
                local[k] -= l[i * width + k] * local[i];
        }
        memcpy(own, local, sizeof(double) * width);
    }
}

enum { PIVOTS, OTHERS, PARENT, RELATIVE, RELATIVE_START, ENTRY_START, ENTRIES, NODE, NODE_START, FACTOR_START, INPUTS };
static const char INPUT_TYPE[INPUTS] = {'i', 'i', 'i', 'i', 'l', 'i', 'i', 'i', 'l', 'l'};
static const char *const INPUT_NAME[INPUTS] = {"pivots",  "others", "parent",     "relative",    "relative_start", "entry_start",
                                               "entries", "node",   "node_start", "factor_start"};

static PyObject *cholesky_solve(PyObject *self, PyObject *args) {
    (void)self;
    PyObject *symbolic, *blocks_object, *right_object, *work_object;
    double damping;
    Py_ssize_t stack_size, largest_front, panel_size;
    if (!PyArg_ParseTuple(args, "OOdOOnnn", &symbolic, &blocks_object, &damping, &right_object, &work_object, &stack_size,
                          &largest_front, &panel_size))
        return NULL;
    Py_buffer in[INPUTS], blocks, right, work;
    int held = 0, done = 0;
    for (; held < INPUTS; held++) {
        PyObject *item = PySequence_GetItem(symbolic, held);
        if (item == NULL)
            goto release;
        int status = umg_buffer(item, &in[held], INPUT_TYPE[held], -1, 0, INPUT_NAME[held]);
        Py_DECREF(item);
        if (status < 0)
            goto release;
    }
    if (umg_buffer(blocks_object, &blocks, 'd', -1, 0, "blocks") < 0)
        goto release;
    if (umg_buffer(right_object, &right, 'd', -1, 1, "right") < 0)
        goto blocks_too;
    if (umg_buffer(work_object, &work, 'd', -1, 1, "work") < 0)
        goto right_too;
    Fronts f = {in[PIVOTS].buf,     in[OTHERS].buf,  in[PARENT].buf,         in[RELATIVE].buf,    in[ENTRY_START].buf,
                in[ENTRIES].buf, in[RELATIVE_START].buf, in[FACTOR_START].buf, in[PIVOTS].len / 4};
    Py_ssize_t factor_size = in[FACTOR_START].len / 8 == f.count + 1 ? (Py_ssize_t)f.factor_start[f.count] : -1;
    if (factor_size < 0 || work.len / 8 < factor_size + stack_size + largest_front * largest_front + panel_size + largest_front) {
        PyErr_SetString(PyExc_ValueError, "work: too small for the factor, the stack and a front");
        goto work_too;
    }
    double *factor = work.buf, *stack = factor + factor_size, *front = stack + stack_size;
    double *panel = front + largest_front * largest_front, *local = panel + panel_size;
    int positive;
    Py_BEGIN_ALLOW_THREADS
    positive = factor_all(&f, blocks.buf, damping, factor, stack, front, panel);
    if (positive)
        solve_all(&f, in[NODE].buf, in[NODE_START].buf, factor, right.buf, local);
    Py_END_ALLOW_THREADS
    if (positive)
        done = 1;
    else
        PyErr_SetString(PyExc_ValueError, "blocks: expected a positive definite matrix");
work_too:
    PyBuffer_Release(&work);
right_too:
    PyBuffer_Release(&right);
blocks_too:
    PyBuffer_Release(&blocks);
release:
    for (int i = 0; i < held; i++)
        PyBuffer_Release(&in[i]);
    if (!done)
        return NULL;
    Py_RETURN_NONE;
}

PyMethodDef umg_block_cholesky_methods[] = {
    {"cholesky_solve", cholesky_solve, METH_VARARGS,
     "cholesky_solve(symbolic, blocks, damping, right, work, stack_size, largest_front, panel_size): factor the matrix of 3x3 "
     "blocks plus damping on its diagonal, and solve for right (in elimination order) in place."},
    {NULL, NULL, 0, NULL},
};
