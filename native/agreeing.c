/* Closest points among the faces whose normals agree with the query's: a box tree over Morton-ordered faces. */
#include "arguments.h"

#include <math.h>

typedef struct {
    const double *boxes; /* (2 * leaves - 1, 6) complete binary tree, children of i at 2i+1 and 2i+2; low then high */
    const double *corners; /* (leaves * leaf_size, 9), padded with faces of no normal */
    const double *normals; /* (leaves * leaf_size, 3), zero where the face has none */
    int64_t leaves, leaf_size;
} Tree;

UMG_INLINE double dot(const double *a, const double *b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

/* Squared distance to a triangle and the weights of the closest point: by Voronoi regions of its corners and edges. */
UMG_INLINE double closest_on_triangle(const double *p, const double *t, double *w) {
    double ab[3], ac[3], ap[3];
    for (int i = 0; i < 3; i++) {
        ab[i] = t[3 + i] - t[i];
        ac[i] = t[6 + i] - t[i];
        ap[i] = p[i] - t[i];
    }
    double d1 = dot(ab, ap), d2 = dot(ac, ap), bb = dot(ab, ab), cc = dot(ac, ac), bc = dot(ab, ac);
    double d3 = d1 - bb, d4 = d2 - bc, d5 = d1 - bc, d6 = d2 - cc;
    double va = d3 * d6 - d5 * d4, vb = d5 * d2 - d1 * d6, vc = d1 * d4 - d3 * d2;
    if (d1 <= 0 && d2 <= 0) {
        w[1] = w[2] = 0;
    } else if (d3 >= 0 && d4 <= d3) {
        w[1] = 1;
        w[2] = 0;
    } else if (d6 >= 0 && d5 <= d6) {
        w[1] = 0;
        w[2] = 1;
    } else if (vc <= 0 && d1 >= 0 && d3 <= 0) {
        w[1] = d1 / (d1 - d3);
        w[2] = 0;
    } else if (vb <= 0 && d2 >= 0 && d6 <= 0) {
        w[1] = 0;
        w[2] = d2 / (d2 - d6);
    } else if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0) {
        w[2] = (d4 - d3) / ((d4 - d3) + (d5 - d6));
        w[1] = 1 - w[2];
    } else {
        double sum = va + vb + vc;
        w[1] = vb / sum;
        w[2] = vc / sum;
    }
    w[0] = 1 - w[1] - w[2];
    double squared = 0;
    for (int i = 0; i < 3; i++) {
        double r = ap[i] - w[1] * ab[i] - w[2] * ac[i];
        squared += r * r;
    }
    return squared;
}

UMG_INLINE double box_distance(const double *box, const double *p) {
    double sum = 0;
    for (int i = 0; i < 3; i++) {
        double below = box[i] - p[i], above = p[i] - box[3 + i], d = below > above ? below : above;
        sum += d > 0 ? d * d : 0;
    }
    return sum;
}

UMG_INLINE void try_face(const Tree *tree, int64_t slot, const double *p, const double *n, double agreement, double *best,
                     int64_t *found, double *weights) {
    if (!(dot(tree->normals + 3 * slot, n) >= agreement))
        return;
    double w[3], squared = closest_on_triangle(p, tree->corners + 9 * slot, w);
    if (squared < *best) {
        *best = squared;
        *found = slot;
        for (int i = 0; i < 3; i++)
            weights[i] = w[i];
    }
}

UMG_VECTORISED
static void search(const Tree *tree, const double *points, const double *normals, int64_t count, double limit, double agreement,
                   int32_t *slots, double *weights, double *squared) {
    int64_t last = -1;
    for (int64_t q = 0; q < count; q++) {
        const double *p = points + 3 * q, *n = normals + 3 * q;
        double best = limit * limit, w[3] = {0, 0, 0};
        int64_t found = -1;
        if (last >= 0) /* neighbours in the query order are neighbours in space: a good first bound */
            try_face(tree, last, p, n, agreement, &best, &found, w);
        int64_t stack[64];
        double reach[64];
        int top = 0;
        stack[top] = 0;
        reach[top++] = box_distance(tree->boxes, p);
        while (top > 0 && best > 0) {
            int64_t node = stack[--top];
            if (reach[top] >= best)
                continue;
            if (node >= tree->leaves - 1) {
                int64_t first = (node - tree->leaves + 1) * tree->leaf_size;
                for (int64_t slot = first; slot < first + tree->leaf_size; slot++)
                    try_face(tree, slot, p, n, agreement, &best, &found, w);
                continue;
            }
            int64_t left = 2 * node + 1, right = 2 * node + 2;
            double near = box_distance(tree->boxes + 6 * left, p), far = box_distance(tree->boxes + 6 * right, p);
            if (far < near) {
                double swap = near;
                near = far;
                far = swap;
                left = right;
                right = 2 * node + 1;
            }
            if (far < best) {
                stack[top] = right;
                reach[top++] = far;
            }
            if (near < best) {
                stack[top] = left;
                reach[top++] = near;
            }
        }
        slots[q] = (int32_t)found;
        squared[q] = found < 0 ? INFINITY : best;
        for (int i = 0; i < 3; i++)
            weights[3 * q + i] = w[i];
        if (found >= 0)
            last = found;
    }
}

static PyObject *closest_agreeing(PyObject *self, PyObject *args) {
    (void)self;
    PyObject *o[8];
    Py_ssize_t leaves, leaf_size, count;
    double limit, agreement;
    if (!PyArg_ParseTuple(args, "nnOOOnOOddOOO", &leaves, &leaf_size, &o[0], &o[1], &o[2], &count, &o[3], &o[4], &limit,
                          &agreement, &o[5], &o[6], &o[7]))
        return NULL;
    Argument wanted[8] = {{'d', 6 * (2 * leaves - 1), 0, "boxes"},
                          {'d', 9 * leaves * leaf_size, 0, "corners"},
                          {'d', 3 * leaves * leaf_size, 0, "normals"},
                          {'d', 3 * count, 0, "points"},
                          {'d', 3 * count, 0, "point_normals"},
                          {'i', count, 1, "slots"},
                          {'d', 3 * count, 1, "weights"},
                          {'d', count, 1, "squared"}};
    Py_buffer views[8];
    if (take_arguments(o, wanted, views, 8) < 0)
        return NULL;
    Tree tree = {views[0].buf, views[1].buf, views[2].buf, leaves, leaf_size};
    Py_BEGIN_ALLOW_THREADS
    search(&tree, views[3].buf, views[4].buf, count, limit, agreement, views[5].buf, views[6].buf, views[7].buf);
    Py_END_ALLOW_THREADS
    release_arguments(views, 8);
    Py_RETURN_NONE;
}

PyMethodDef umg_agreeing_methods[] = {
    {"closest_agreeing", closest_agreeing, METH_VARARGS,
     "closest_agreeing(leaves, leaf_size, boxes, corners, normals, count, points, point_normals, limit, agreement, slots, "
     "weights, squared): for each point the closest face nearer than limit whose normal's dot product with the point's is at "
     "least agreement: its slot or -1, barycentric weights, squared distance."},
    {NULL, NULL, 0, NULL},
};
