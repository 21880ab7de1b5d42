/* Random edge collapses and Delaunay-like flips on closed manifold triangle meshes, for re-meshing a surface anew.
 *
 * A mesh is a corner table: half-edge h = 3 f + c runs from corner c of face f to the next corner, and opposite[h] is
 * the same edge seen from the other face. Every change keeps the surface a closed manifold of the same genus. */
#include "umg.h"

#include <math.h>
#include <stdlib.h>

static int next_of(int h) { return h % 3 == 2 ? h - 2 : h + 1; }
static int previous_of(int h) { return h % 3 == 0 ? h + 2 : h - 1; }

static uint64_t draw(uint64_t *state) { /* splitmix64 */
    uint64_t z = (*state += 0x9E3779B97F4A7C15u);
    z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9u;
    z = (z ^ (z >> 27)) * 0x94D049BB133111EBu;
    return z ^ (z >> 31);
}

static double distance(const double *a, const double *b) {
    double x = a[0] - b[0], y = a[1] - b[1], z = a[2] - b[2];
    return sqrt(x * x + y * y + z * z);
}

static void normal_of(const double *a, const double *b, const double *c, double *n) {
    double u[3] = {b[0] - a[0], b[1] - a[1], b[2] - a[2]}, v[3] = {c[0] - a[0], c[1] - a[1], c[2] - a[2]};
    n[0] = u[1] * v[2] - u[2] * v[1];
    n[1] = u[2] * v[0] - u[0] * v[2];
    n[2] = u[0] * v[1] - u[1] * v[0];
}

static double dot(const double *a, const double *b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

/* Whether new triangle normal `n` turns by less than `cosine` allows from `m`. */
static int agrees(const double *n, const double *m, double cosine) {
    double d = dot(n, m);
    return d > 0 && d * d > cosine * cosine * dot(n, n) * dot(m, m);
}

typedef struct {
    int *faces, *opposite, *outgoing, *stamp;
    const double *points, *sizes;
    int clock;
} Mesh;

static int valence(const Mesh *s, int vertex) {
    int start = s->outgoing[vertex], h = start, count = 0;
    do {
        count++;
        h = s->opposite[previous_of(h)];
    } while (h != start);
    return count;
}

/* Whether the end u of half-edge h = u -> v may move onto v: link condition, no turned or thin triangle, no long edge. */
static int may_collapse(Mesh *s, int h, double longest) {
    int u = s->faces[h], v = s->faces[next_of(h)], common = 0;
    int a = s->faces[previous_of(h)], b = s->faces[previous_of(s->opposite[h])];
    if (valence(s, a) <= 3 || valence(s, b) <= 3)
        return 0;
    s->clock++;
    int start = s->outgoing[v], g = start;
    do {
        s->stamp[s->faces[next_of(g)]] = s->clock;
        g = s->opposite[previous_of(g)];
    } while (g != start);
    start = g = s->outgoing[u];
    do {
        common += s->stamp[s->faces[next_of(g)]] == s->clock;
        g = s->opposite[previous_of(g)];
    } while (g != start);
    if (common != 2)
        return 0;
    const double *to = s->points + 3 * v;
    do {
        int i = s->faces[next_of(g)], j = s->faces[previous_of(g)];
        if (i != v && j != v) {
            const double *p = s->points + 3 * i, *q = s->points + 3 * j;
            double before[3], after[3];
            normal_of(s->points + 3 * u, p, q, before);
            normal_of(to, p, q, after);
            double x = distance(to, p), y = distance(p, q), z = distance(q, to);
            double quality = 3.4641016151377544 * sqrt(dot(after, after)) / (x * x + y * y + z * z);
            if (!agrees(after, before, 0.5) || quality < 0.2)
                return 0;
            if (x > longest * 0.5 * (s->sizes[v] + s->sizes[i]))
                return 0;
        }
        g = s->opposite[previous_of(g)];
    } while (g != start);
    return 1;
}

static void glue(Mesh *s, int g, int h) {
    s->opposite[g] = h;
    s->opposite[h] = g;
}

static void collapse(Mesh *s, int h) {
    int u = s->faces[h], v = s->faces[next_of(h)], start = s->outgoing[u], g = start;
    do {
        s->faces[g] = v;
        g = s->opposite[previous_of(g)];
    } while (g != start);
    for (int side = 0; side < 2; side++) {
        int k = side ? s->opposite[h] : h;
        int near = s->opposite[side ? previous_of(k) : next_of(k)], far = s->opposite[side ? next_of(k) : previous_of(k)];
        int apex = s->faces[previous_of(k)]; /* near runs apex -> v or v -> apex, far the other way */
        int from_apex = side ? far : near, from_v = side ? near : far;
        glue(s, near, far);
        s->outgoing[apex] = from_apex;
        s->outgoing[v] = from_v;
    }
    int f0 = h / 3, f1 = s->opposite[h] / 3;
    for (int c = 0; c < 3; c++)
        s->faces[3 * f0 + c] = s->faces[3 * f1 + c] = -1;
}

static PyObject *coarsen(PyObject *self, PyObject *args) {
    (void)self;
    PyObject *faces_object, *opposite_object, *points_object, *sizes_object;
    unsigned long long seed;
    Py_ssize_t target;
    if (!PyArg_ParseTuple(args, "OOOOKn", &faces_object, &opposite_object, &points_object, &sizes_object, &seed, &target))
        return NULL;
    Py_buffer faces, opposite, points, sizes;
    if (umg_buffer(faces_object, &faces, 'i', -1, 1, "faces") < 0)
        return NULL;
    Py_ssize_t corners = faces.len / 4;
    if (umg_buffer(opposite_object, &opposite, 'i', corners, 1, "opposite") < 0)
        goto release_faces;
    if (umg_buffer(sizes_object, &sizes, 'd', -1, 0, "sizes") < 0)
        goto release_opposite;
    Py_ssize_t count = sizes.len / 8;
    if (umg_buffer(points_object, &points, 'd', 3 * count, 0, "points") < 0)
        goto release_sizes;
    int *work = malloc(((size_t)count * 2 + (size_t)corners) * sizeof(int));
    if (work == NULL) {
        PyErr_NoMemory();
        goto release_points;
    }
    Py_ssize_t live = corners / 3;
    Py_BEGIN_ALLOW_THREADS
    Mesh s = {faces.buf, opposite.buf, work, work + count, points.buf, sizes.buf, 0};
    int *edges = work + 2 * count;
    uint64_t state = seed;
    for (Py_ssize_t i = 0; i < count; i++)
        s.stamp[i] = 0;
    for (Py_ssize_t h = 0; h < corners; h++)
        s.outgoing[s.faces[h]] = (int)h;
    /* Short edges go first, longer ones in later passes, each pass in a random order of its own. */
    for (double ratio = 0.4; live > target && ratio < 3.0; ratio += ratio < 1.0 ? 0.15 : 0.1) {
        Py_ssize_t edge_count = 0;
        for (Py_ssize_t h = 0; h < corners; h++)
            if (s.faces[h] >= 0 && h < s.opposite[h])
                edges[edge_count++] = (int)h;
        for (Py_ssize_t i = edge_count - 1; i > 0; i--) {
            Py_ssize_t j = (Py_ssize_t)(draw(&state) % (uint64_t)(i + 1));
            int swap = edges[i];
            edges[i] = edges[j];
            edges[j] = swap;
        }
        for (Py_ssize_t i = 0; i < edge_count && live > target; i++) {
            int h = edges[i];
            if (s.faces[h] < 0)
                continue;
            if (draw(&state) & 1)
                h = s.opposite[h];
            int u = s.faces[h], v = s.faces[next_of(h)];
            double length = distance(s.points + 3 * u, s.points + 3 * v);
            if (length > ratio * 0.5 * (s.sizes[u] + s.sizes[v]))
                continue;
            if (!may_collapse(&s, h, 1.5 * fmax(ratio, 1))) {
                h = s.opposite[h];
                if (!may_collapse(&s, h, 1.5 * fmax(ratio, 1)))
                    continue;
            }
            collapse(&s, h);
            live -= 2;
        }
    }
    Py_END_ALLOW_THREADS
    free(work);
    PyBuffer_Release(&points);
    PyBuffer_Release(&sizes);
    PyBuffer_Release(&opposite);
    PyBuffer_Release(&faces);
    return PyLong_FromSsize_t(live);
release_points:
    PyBuffer_Release(&points);
release_sizes:
    PyBuffer_Release(&sizes);
release_opposite:
    PyBuffer_Release(&opposite);
release_faces:
    PyBuffer_Release(&faces);
    return NULL;
}

static double cotangent(const double *apex, const double *p, const double *q) {
    double u[3] = {p[0] - apex[0], p[1] - apex[1], p[2] - apex[2]}, v[3] = {q[0] - apex[0], q[1] - apex[1], q[2] - apex[2]};
    double n[3];
    normal_of(apex, p, q, n);
    return dot(u, v) / (sqrt(dot(n, n)) + 1e-300);
}

static int may_flip(const Mesh *s, int h) {
    int u = s->faces[h], v = s->faces[next_of(h)], a = s->faces[previous_of(h)], b = s->faces[previous_of(s->opposite[h])];
    const double *pu = s->points + 3 * u, *pv = s->points + 3 * v, *pa = s->points + 3 * a, *pb = s->points + 3 * b;
    if (cotangent(pa, pu, pv) + cotangent(pb, pu, pv) > -1e-9) /* the opposite angles sum to less than pi */
        return 0;
    double left[3], right[3], first[3], second[3];
    normal_of(pu, pv, pa, left);
    normal_of(pv, pu, pb, right);
    normal_of(pa, pb, pv, first);
    normal_of(pb, pa, pu, second);
    if (!agrees(left, right, 0.6) || !agrees(first, second, 0.6) || !agrees(first, left, 0.6) || !agrees(second, right, 0.6))
        return 0;
    if (valence(s, u) <= 3 || valence(s, v) <= 3)
        return 0;
    int start = s->outgoing[a], g = start;
    do {
        if (s->faces[next_of(g)] == b)
            return 0;
        g = s->opposite[previous_of(g)];
    } while (g != start);
    return 1;
}

static void flip(Mesh *s, int h) {
    int h1 = next_of(h), h2 = previous_of(h), g = s->opposite[h], g1 = next_of(g), g2 = previous_of(g);
    int u = s->faces[h], v = s->faces[h1], a = s->faces[h2], b = s->faces[g2];
    int o1 = s->opposite[h1], o2 = s->opposite[h2], p1 = s->opposite[g1], p2 = s->opposite[g2];
    s->faces[h] = a, s->faces[h1] = b, s->faces[h2] = v;
    s->faces[g] = b, s->faces[g1] = a, s->faces[g2] = u;
    glue(s, h1, p2), glue(s, h2, o1), glue(s, g1, o2), glue(s, g2, p1);
    s->outgoing[a] = h, s->outgoing[b] = g, s->outgoing[v] = h2, s->outgoing[u] = g2;
}

static PyObject *flip_edges(PyObject *self, PyObject *args) {
    (void)self;
    PyObject *faces_object, *opposite_object, *points_object;
    int passes;
    if (!PyArg_ParseTuple(args, "OOOi", &faces_object, &opposite_object, &points_object, &passes))
        return NULL;
    Py_buffer faces, opposite, points;
    if (umg_buffer(faces_object, &faces, 'i', -1, 1, "faces") < 0)
        return NULL;
    Py_ssize_t corners = faces.len / 4, flipped = 0;
    if (umg_buffer(opposite_object, &opposite, 'i', corners, 1, "opposite") < 0) {
        PyBuffer_Release(&faces);
        return NULL;
    }
    if (umg_buffer(points_object, &points, 'd', -1, 0, "points") < 0) {
        PyBuffer_Release(&opposite);
        PyBuffer_Release(&faces);
        return NULL;
    }
    int *outgoing = malloc((size_t)(points.len / 24) * sizeof(int));
    if (outgoing != NULL) {
        Py_BEGIN_ALLOW_THREADS
        Mesh s = {faces.buf, opposite.buf, outgoing, NULL, points.buf, NULL, 0};
        for (Py_ssize_t h = 0; h < corners; h++)
            outgoing[s.faces[h]] = (int)h;
        for (int pass = 0; pass < passes; pass++) {
            Py_ssize_t before = flipped;
            for (Py_ssize_t h = 0; h < corners; h++)
                if (h < s.opposite[h] && may_flip(&s, (int)h)) {
                    flip(&s, (int)h);
                    flipped++;
                }
            if (flipped == before)
                break;
        }
        Py_END_ALLOW_THREADS
        free(outgoing);
    } else
        PyErr_NoMemory();
    PyBuffer_Release(&points);
    PyBuffer_Release(&opposite);
    PyBuffer_Release(&faces);
    return outgoing == NULL ? NULL : PyLong_FromSsize_t(flipped);
}

PyMethodDef umg_remesh_methods[] = {
    {"coarsen", coarsen, METH_VARARGS,
     "coarsen(faces, opposite, points, sizes, seed, target): collapse random short edges of a closed manifold in place until "
     "`target` faces are left; removed faces become -1. Returns the number of faces left."},
    {"flip_edges", flip_edges, METH_VARARGS,
     "flip_edges(faces, opposite, points, passes): flip edges in place towards the Delaunay condition. Returns the flips."},
    {NULL, NULL, 0, NULL},
};
