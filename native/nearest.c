/* Nearest points on triangles: a tree of boxes, eight children a node, over triangles in an order of their own. */
#include "arguments.h"

#include <math.h>

enum { WIDE = 8, DEEPEST = 12 };

typedef struct {
    const double *boxes;     /* (nodes, 6, WIDE): low x, y, z and high x, y, z of every child; levels from the root down */
    const double *triangles; /* (slots, 9): a corner and the two sides from it */
    int64_t first[DEEPEST];  /* the first node of every level */
    int levels;
    int64_t slots;
} Tree;

UMG_INLINE double dot(const double *a, const double *b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

UMG_INLINE double clamped(double numerator, double denominator) {
    double along = denominator > 0 ? numerator / denominator : 0;
    return along < 0 ? 0 : along > 1 ? 1 : along;
}

/* Squared distance of p to the triangle a, a + u, a + v; st gets the weights of u and v at the nearest point. */
UMG_INLINE double triangle_distance(const double *triangle, const double *p, double *st) {
    const double *a = triangle, *u = triangle + 3, *v = triangle + 6;
    double w[3] = {p[0] - a[0], p[1] - a[1], p[2] - a[2]};
    double uu = dot(u, u), uv = dot(u, v), vv = dot(v, v), wu = dot(w, u), wv = dot(w, v);
    double determinant = uu * vv - uv * uv, s = vv * wu - uv * wv, t = uu * wv - uv * wu;
    if (determinant > 1e-14 * uu * vv && s >= 0 && t >= 0 && s + t <= determinant) {
        st[0] = s / determinant;
        st[1] = t / determinant;
        double q[3];
        for (int i = 0; i < 3; i++)
            q[i] = w[i] - st[0] * u[i] - st[1] * v[i];
        return dot(q, q);
    }
    /* Else the nearest point of its edges, of which the first to be as near counts. */
    double side = clamped(wv - wu + uu - uv, uu - 2 * uv + vv), best = INFINITY;
    double try[3][2] = {{clamped(wu, uu), 0}, {0, clamped(wv, vv)}, {1 - side, side}};
    for (int e = 0; e < 3; e++) {
        double q[3];
        for (int i = 0; i < 3; i++)
            q[i] = w[i] - try[e][0] * u[i] - try[e][1] * v[i];
        double squared = dot(q, q);
        if (squared < best) {
            best = squared;
            st[0] = try[e][0];
            st[1] = try[e][1];
        }
    }
    return best;
}

/* Twice the larger of x and 0, without a branch, which would keep the loop below from being vectorised. */
UMG_INLINE double twice_positive(double x) { return x + fabs(x); }

/* Four times the squared distances of p to a node's boxes; p is on one side of a box at most. */
UMG_INLINE void box_distances(const double *restrict box, const double *restrict p, double *restrict out) {
    const double x = p[0], y = p[1], z = p[2];
    for (int c = 0; c < WIDE; c++) {
        double a = twice_positive(box[c] - x) + twice_positive(x - box[3 * WIDE + c]);
        double b = twice_positive(box[WIDE + c] - y) + twice_positive(y - box[4 * WIDE + c]);
        double d = twice_positive(box[2 * WIDE + c] - z) + twice_positive(z - box[5 * WIDE + c]);
        out[c] = a * a + b * b + d * d;
    }
}

UMG_VECTORISED
static void search(const Tree *tree, const double *points, int64_t count, int32_t *slots, double *weights, double *squared) {
    int64_t node[WIDE * DEEPEST];
    int level[WIDE * DEEPEST];
    double reach[WIDE * DEEPEST];
    int64_t last = 0;
    for (int64_t q = 0; q < count; q++) {
        const double *p = points + 3 * q;
        /* A guess, or else the answer of the point before, bounds the search. */
        int64_t found = slots[q] >= 0 && slots[q] < tree->slots ? slots[q] : last;
        double st[2] = {0, 0}, best_st[2] = {0, 0}, best = triangle_distance(tree->triangles + 9 * found, p, best_st);
        int top = 1;
        node[0] = 0;
        level[0] = 0;
        reach[0] = 0;
        while (top > 0) {
            top--;
            if (reach[top] >= 4 * best)
                continue;
            int64_t own = node[top];
            int depth = level[top];
            double d[WIDE];
            box_distances(tree->boxes + 6 * WIDE * (tree->first[depth] + own), p, d);
            if (depth == tree->levels - 1) {
                for (int c = 0; c < WIDE; c++) {
                    if (!(d[c] < 4 * best))
                        continue;
                    double now = triangle_distance(tree->triangles + 9 * (WIDE * own + c), p, st);
                    if (now < best) {
                        best = now;
                        found = WIDE * own + c;
                        best_st[0] = st[0];
                        best_st[1] = st[1];
                    }
                }
                continue;
            }
            /* Children go onto the stack farthest first. */
            int base = top;
            for (int c = 0; c < WIDE; c++) {
                if (!(d[c] < 4 * best))
                    continue;
                int at = top++;
                for (; at > base && reach[at - 1] < d[c]; at--) {
                    reach[at] = reach[at - 1];
                    node[at] = node[at - 1];
                }
                reach[at] = d[c];
                node[at] = WIDE * own + c;
                level[top - 1] = depth + 1;
            }
        }
        slots[q] = (int32_t)found;
        weights[3 * q] = 1 - best_st[0] - best_st[1];
        weights[3 * q + 1] = best_st[0];
        weights[3 * q + 2] = best_st[1];
        squared[q] = best;
        last = found;
    }
}

static PyObject *nearest_on_triangles(PyObject *self, PyObject *args) {
    (void)self;
    PyObject *o[6];
    Py_ssize_t triangles, count;
    if (!PyArg_ParseTuple(args, "nnOOOOOO", &triangles, &count, &o[0], &o[1], &o[2], &o[3], &o[4], &o[5]))
        return NULL;
    int64_t size[DEEPEST], nodes = 0;
    Tree tree = {NULL, NULL, {0}, 0, triangles};
    for (int64_t rest = triangles; tree.levels < DEEPEST && (tree.levels == 0 || rest > 1); tree.levels++) {
        rest = (rest + WIDE - 1) / WIDE;
        size[tree.levels] = rest;
        nodes += rest;
    }
    if (triangles < 1 || size[tree.levels - 1] != 1) {
        PyErr_Format(PyExc_ValueError, "triangles: expected 1 to %d^%d, got %zd", WIDE, DEEPEST, triangles);
        return NULL;
    }
    for (int level = 1; level < tree.levels; level++)
        tree.first[level] = tree.first[level - 1] + size[tree.levels - level];
    Argument wanted[6] = {{'d', 6 * WIDE * (Py_ssize_t)nodes, 0, "boxes"},
                          {'d', 9 * triangles, 0, "corners"},
                          {'d', 3 * count, 0, "points"},
                          {'i', count, 1, "slots"},
                          {'d', 3 * count, 1, "weights"},
                          {'d', count, 1, "squared"}};
    Py_buffer views[6];
    if (take_arguments(o, wanted, views, 6) < 0)
        return NULL;
    tree.boxes = views[0].buf;
    tree.triangles = views[1].buf;
    Py_BEGIN_ALLOW_THREADS
    search(&tree, views[2].buf, count, views[3].buf, views[4].buf, views[5].buf);
    Py_END_ALLOW_THREADS
    release_arguments(views, 6);
    Py_RETURN_NONE;
}

PyMethodDef umg_nearest_methods[] = {
    {"nearest_on_triangles", nearest_on_triangles, METH_VARARGS,
     "nearest_on_triangles(triangles, count, boxes, corners, points, slots, weights, squared): for each point the slot of its "
     "nearest triangle (given as a corner and two sides), barycentric weights there and the squared distance; slots comes in "
     "with guesses, -1 for none."},
    {NULL, NULL, 0, NULL},
};
