/* Fewer triangles by half-edge collapses that keep a texture atlas: vertices and uvs are left out, none is moved.
 *
 * A wedge is a vertex as one chart of the atlas sees it. A vertex may move onto a neighbour where each of its wedges then
 * is one of the neighbour's: inside a chart, or along a seam. The cheapest collapse goes first; its cost is quadratic:
 * distances to the planes of the faces that were collapsed into the vertex (summed over poses), to the planes that stand on
 * seams and boundaries, and the way that the texture slides on the surface. */
#include "arguments.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define MOST_FACES 32  /* around a vertex: more is neither collapsed nor collapsed into */
#define MOST_VALENCE 16
#define PLANE 10 /* coefficients of a sum of squared distances to planes */
#define WEDGE 19 /* PLANE, and for u and v each gradient (3) and offset, and the weight */

typedef struct {
    int vertices, poses, faces;
    const double *points, *uv;
    int *face, *wedge;
    double sliding; /* metres a uv unit, times how much sliding counts */
    double *plane, *slide, *area;
    int *next, *head; /* the corners at each vertex, as lists */
    int *stamp, clock;
    double *cost;
    int *heap, *place, heaped;
} Mesh;

typedef struct {
    int count, corner[MOST_FACES]; /* the corners of live faces at a vertex; count is MOST_FACES + 1 where there are more */
} Star;

static double dot(const double *a, const double *b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

static int next_corner(int c) { return c % 3 == 2 ? c - 2 : c + 1; }
static int previous_corner(int c) { return c % 3 == 0 ? c + 2 : c - 1; }

static void difference(const double *a, const double *b, double *out) {
    for (int i = 0; i < 3; i++)
        out[i] = a[i] - b[i];
}

static void cross(const double *a, const double *b, double *out) {
    out[0] = a[1] * b[2] - a[2] * b[1];
    out[1] = a[2] * b[0] - a[0] * b[2];
    out[2] = a[0] * b[1] - a[1] * b[0];
}

static const double *point(const Mesh *s, int pose, int vertex) {
    return s->points + 3 * ((size_t)pose * (size_t)s->vertices + (size_t)vertex);
}

static void add_plane(double *q, const double *n, double d, double weight) {
    const double r[4] = {n[0], n[1], n[2], d};
    int k = 0;
    for (int i = 0; i < 4; i++)
        for (int j = i; j < 4; j++)
            q[k++] += weight * r[i] * r[j];
}

static double plane_error(const double *q, const double *p) {
    return q[0] * p[0] * p[0] + q[4] * p[1] * p[1] + q[7] * p[2] * p[2] + q[9] +
           2 * (q[1] * p[0] * p[1] + q[2] * p[0] * p[2] + q[5] * p[1] * p[2] + q[3] * p[0] + q[6] * p[1] + q[8] * p[2]);
}

/* Sum over faces of weight times (g . p + d - s)^2 for both coordinates s of a wedge at p. */
static double slide_error(const double *q, const double *p, const double *uv) {
    double error = plane_error(q, p);
    for (int i = 0; i < 2; i++) {
        const double *g = q + PLANE + 4 * i;
        error += uv[i] * (q[PLANE + 8] * uv[i] - 2 * (dot(g, p) + g[3]));
    }
    return error;
}

static void gather(Mesh *s, int vertex, Star *star) {
    int *link = &s->head[vertex];
    star->count = 0;
    while (*link >= 0) {
        int c = *link;
        if (s->face[c] < 0) { /* of a face that is gone */
            *link = s->next[c];
            continue;
        }
        if (star->count < MOST_FACES)
            star->corner[star->count] = c;
        star->count += star->count <= MOST_FACES;
        link = &s->next[c];
    }
}

/* Whether corner c may be moved to `vertex` and `wedge`: no triangle may turn or vanish, in space or in the atlas. */
static int may_move(const Mesh *s, int c, int vertex, int wedge) {
    int b = s->face[next_corner(c)], a = s->face[previous_corner(c)];
    for (int pose = 0; pose < s->poses; pose++) {
        double x[3], y[3], old[3], new[3];
        const double *base = point(s, pose, b);
        difference(point(s, pose, a), base, x);
        difference(point(s, pose, s->face[c]), base, y);
        cross(x, y, old);
        difference(point(s, pose, vertex), base, y);
        cross(x, y, new);
        double was = dot(old, old), is = dot(new, new), along = dot(old, new);
        if (was > 0 && (along <= 0 || along * along < 0.04 * was * is))
            return 0;
    }
    const double *p = s->uv + 2 * (size_t)s->wedge[next_corner(c)], *q = s->uv + 2 * (size_t)s->wedge[previous_corner(c)];
    const double *from = s->uv + 2 * (size_t)s->wedge[c], *to = s->uv + 2 * (size_t)wedge;
    double was = (q[0] - p[0]) * (from[1] - p[1]) - (q[1] - p[1]) * (from[0] - p[0]);
    double is = (q[0] - p[0]) * (to[1] - p[1]) - (q[1] - p[1]) * (to[0] - p[0]);
    return was == 0 || was * is > 0;
}

typedef struct {
    int vertex, faces, pairs, from[2], to[2]; /* the edge's faces, and what becomes of the wedges */
} Edge;

/* The ways from a vertex: its edges, with the wedges that they would join. Returns their number, 0 where there are too many. */
static int edges_of(const Mesh *s, const Star *star, Edge *edges) {
    int count = 0;
    for (int i = 0; i < star->count; i++) {
        int c = star->corner[i], sides[2] = {next_corner(c), previous_corner(c)};
        for (int k = 0; k < 2; k++) {
            int v = s->face[sides[k]], e = 0;
            while (e < count && edges[e].vertex != v)
                e++;
            if (e == count) {
                if (count == MOST_FACES + 1)
                    return 0;
                edges[count++] = (Edge){v, 0, 0, {-1, -1}, {-1, -1}};
            }
            if (edges[e].faces++ < 2) {
                edges[e].from[edges[e].faces - 1] = s->wedge[c];
                edges[e].to[edges[e].faces - 1] = s->wedge[sides[k]];
            }
        }
    }
    return count;
}

/* Whether all wedges around the star are carried over the edge, and to one each. */
static int carries(const Mesh *s, const Star *star, Edge *e) {
    if (e->faces > 2)
        return 0;
    e->pairs = e->faces;
    if (e->faces == 2 && e->from[0] == e->from[1]) {
        if (e->to[0] != e->to[1])
            return 0;
        e->pairs = 1;
    } else if (e->faces == 2 && e->to[0] == e->to[1]) {
        return 0; /* two charts would become one at this vertex: the seam's end would move */
    }
    for (int i = 0; i < star->count; i++) {
        int w = s->wedge[star->corner[i]];
        if (w != e->from[0] && !(e->pairs == 2 && w == e->from[1]))
            return 0;
    }
    return 1;
}

static int linked(Mesh *s, const Edge *edges, int count, const Edge *e, const Star *other) {
    s->clock++;
    for (int i = 0; i < count; i++)
        s->stamp[edges[i].vertex] = s->clock;
    int common = 0;
    for (int i = 0; i < other->count; i++) {
        int sides[2] = {s->face[next_corner(other->corner[i])], s->face[previous_corner(other->corner[i])]};
        for (int k = 0; k < 2; k++)
            if (s->stamp[sides[k]] == s->clock) {
                s->stamp[sides[k]] = 0;
                common++;
            }
    }
    return common == e->faces;
}

static double collapse_cost(const Mesh *s, int u, const Edge *e) {
    double cost = 0, away[3];
    for (int pose = 0; pose < s->poses; pose++) {
        const double *p = point(s, pose, e->vertex);
        size_t at = (size_t)pose * (size_t)s->vertices;
        cost += plane_error(s->plane + PLANE * (at + (size_t)u), p) + plane_error(s->plane + PLANE * (at + (size_t)e->vertex), p);
        /* where nothing bends and nothing slides, short edges go first, so that triangles stay well shaped */
        difference(p, point(s, pose, u), away);
        cost += 1e-3 * s->area[u] * dot(away, away);
    }
    cost /= s->poses;
    const double *p = point(s, 0, e->vertex);
    for (int i = 0; i < e->pairs; i++) {
        const double *uv = s->uv + 2 * (size_t)e->to[i];
        cost += slide_error(s->slide + WEDGE * (size_t)e->from[i], p, uv) + slide_error(s->slide + WEDGE * (size_t)e->to[i], p, uv);
    }
    return cost;
}

/* The cheapest way for a vertex to vanish: 1 and the edge, or 0. */
static int best_way(Mesh *s, int u, Edge *best, double *best_cost) {
    Star star, other;
    Edge edges[MOST_FACES + 1];
    double costs[MOST_FACES + 1];
    gather(s, u, &star);
    if (star.count == 0 || star.count > MOST_FACES)
        return 0;
    int count = edges_of(s, &star, edges), open = 0;
    for (int i = 0; i < count; i++)
        open += edges[i].faces == 1;
    if (open != 0 && open != 2)
        return 0;
    for (int i = 0; i < count; i++) {
        costs[i] = -1;
        if ((open && edges[i].faces != 1) || !carries(s, &star, &edges[i]))
            continue;
        gather(s, edges[i].vertex, &other);
        if (other.count > MOST_FACES || star.count + other.count - 2 * edges[i].faces > MOST_VALENCE)
            continue;
        /* what is left must be a surface, not two triangles back to back */
        if (star.count == edges[i].faces || !linked(s, edges, count, &edges[i], &other))
            continue;
        double cost = collapse_cost(s, u, &edges[i]);
        costs[i] = cost > 0 ? cost : 0;
    }
    for (;;) {
        int least = -1;
        for (int i = 0; i < count; i++)
            if (costs[i] >= 0 &&
                (least < 0 || costs[i] < costs[least] || (costs[i] == costs[least] && edges[i].vertex < edges[least].vertex)))
                least = i;
        if (least < 0)
            return 0;
        Edge *e = &edges[least];
        int free = 1;
        for (int i = 0; free && i < star.count; i++) {
            int c = star.corner[i];
            if (s->face[next_corner(c)] != e->vertex && s->face[previous_corner(c)] != e->vertex)
                free = may_move(s, c, e->vertex, s->wedge[c] == e->from[0] ? e->to[0] : e->to[1]);
        }
        if (free) {
            *best = *e;
            *best_cost = costs[least];
            return 1;
        }
        costs[least] = -1;
    }
}

static int before(const Mesh *s, int u, int v) { return s->cost[u] < s->cost[v] || (s->cost[u] == s->cost[v] && u < v); }

static void put(Mesh *s, int at, int vertex) {
    s->heap[at] = vertex;
    s->place[vertex] = at;
}

static void settle(Mesh *s, int at) {
    int vertex = s->heap[at];
    for (; at > 0 && before(s, vertex, s->heap[(at - 1) / 2]); at = (at - 1) / 2)
        put(s, at, s->heap[(at - 1) / 2]);
    for (;;) {
        int child = 2 * at + 1;
        if (child + 1 < s->heaped && before(s, s->heap[child + 1], s->heap[child]))
            child++;
        if (child >= s->heaped || !before(s, s->heap[child], vertex))
            break;
        put(s, at, s->heap[child]);
        at = child;
    }
    put(s, at, vertex);
}

static void drop(Mesh *s, int vertex) {
    int at = s->place[vertex];
    if (at < 0)
        return;
    s->place[vertex] = -1;
    int last = s->heap[--s->heaped];
    if (last != vertex) {
        put(s, at, last);
        settle(s, at);
    }
}

static void weigh(Mesh *s, int vertex) {
    Edge e;
    double cost;
    if (!best_way(s, vertex, &e, &cost)) {
        drop(s, vertex);
        return;
    }
    s->cost[vertex] = cost;
    if (s->place[vertex] < 0)
        put(s, s->heaped++, vertex);
    settle(s, s->place[vertex]);
}

static int collapse(Mesh *s, int u, const Edge *e) {
    Star star;
    int v = e->vertex, gone = 0;
    gather(s, u, &star);
    for (int i = 0; i < star.count; i++) {
        int c = star.corner[i], f = c - c % 3;
        if (s->face[next_corner(c)] == v || s->face[previous_corner(c)] == v) {
            s->face[f] = s->face[f + 1] = s->face[f + 2] = -1;
            gone++;
        } else {
            s->face[c] = v;
            s->wedge[c] = s->wedge[c] == e->from[0] ? e->to[0] : e->to[1];
            s->next[c] = s->head[v];
            s->head[v] = c;
        }
    }
    s->head[u] = -1;
    for (int pose = 0; pose < s->poses; pose++) {
        size_t at = (size_t)pose * (size_t)s->vertices;
        for (int i = 0; i < PLANE; i++)
            s->plane[PLANE * (at + (size_t)v) + (size_t)i] += s->plane[PLANE * (at + (size_t)u) + (size_t)i];
    }
    for (int k = 0; k < e->pairs; k++)
        for (int i = 0; i < WEDGE; i++)
            s->slide[WEDGE * (size_t)e->to[k] + (size_t)i] += s->slide[WEDGE * (size_t)e->from[k] + (size_t)i];
    s->area[v] += s->area[u];
    return gone;
}

/* The planes, slides and areas that each face brings to its corners; seams and boundaries stand on their edges. */
static void measure(Mesh *s, double seam, double boundary) {
    for (int f = 0; f < s->faces; f++) {
        const int *corner = s->face + 3 * (size_t)f;
        for (int pose = 0; pose < s->poses; pose++) {
            const double *p[3];
            double x[3], y[3], n[3];
            for (int i = 0; i < 3; i++)
                p[i] = point(s, pose, corner[i]);
            difference(p[1], p[0], x);
            difference(p[2], p[0], y);
            cross(x, y, n);
            double length = sqrt(dot(n, n));
            if (length == 0)
                continue;
            double area = length / 2, unit[3] = {n[0] / length, n[1] / length, n[2] / length};
            for (int i = 0; i < 3; i++) {
                add_plane(s->plane + PLANE * ((size_t)pose * (size_t)s->vertices + (size_t)corner[i]), unit, -dot(unit, p[0]), area);
                s->area[corner[i]] += area / s->poses;
            }
            for (int i = 0; i < 3; i++) { /* the edge from corner i to the next */
                int c = 3 * f + i, to = next_corner(c), u = corner[i], v = s->face[to], twins = 0, alike = 0;
                for (int d = s->head[u]; d >= 0; d = s->next[d]) {
                    int sides[2] = {next_corner(d), previous_corner(d)};
                    for (int k = 0; k < 2; k++)
                        if (s->face[sides[k]] == v && d / 3 != f) {
                            twins++;
                            alike += s->wedge[d] == s->wedge[c] && s->wedge[sides[k]] == s->wedge[to];
                        }
                }
                if (twins == 1 && alike == 1)
                    continue;
                double along[3], side[3];
                difference(p[(i + 1) % 3], p[i], along);
                cross(along, unit, side);
                double size = sqrt(dot(side, side));
                if (size == 0)
                    continue;
                for (int k = 0; k < 3; k++)
                    side[k] /= size;
                double weight = size * size * (twins == 1 ? seam : boundary);
                int ends[2] = {u, v};
                for (int k = 0; k < 2; k++)
                    add_plane(s->plane + PLANE * ((size_t)pose * (size_t)s->vertices + (size_t)ends[k]), side, -dot(side, p[i]), weight);
            }
            if (pose > 0)
                continue;
            /* gradients g with g . x = du, g . y = dv in the face's plane */
            double yn[3], nx[3];
            cross(y, n, yn);
            cross(n, x, nx);
            const double *uv[3];
            for (int i = 0; i < 3; i++)
                uv[i] = s->uv + 2 * (size_t)s->wedge[3 * f + i];
            double square = dot(n, n), scale = s->sliding * s->sliding;
            double q[WEDGE] = {0};
            for (int k = 0; k < 2; k++) {
                double a = uv[1][k] - uv[0][k], b = uv[2][k] - uv[0][k], g[3];
                for (int i = 0; i < 3; i++)
                    g[i] = (a * yn[i] + b * nx[i]) / square;
                double d = uv[0][k] - dot(g, p[0]);
                add_plane(q, g, d, area * scale);
                for (int i = 0; i < 3; i++)
                    q[PLANE + 4 * k + i] = area * scale * g[i];
                q[PLANE + 4 * k + 3] = area * scale * d;
            }
            q[PLANE + 8] = area * scale;
            for (int i = 0; i < 3; i++)
                for (int k = 0; k < WEDGE; k++)
                    s->slide[WEDGE * (size_t)s->wedge[3 * f + i] + (size_t)k] += q[k];
        }
    }
}

static int run(Mesh *s, int goal, double seam, double boundary) {
    for (int v = 0; v < s->vertices; v++)
        s->head[v] = s->place[v] = -1;
    for (int c = 3 * s->faces - 1; c >= 0; c--) {
        s->next[c] = s->head[s->face[c]];
        s->head[s->face[c]] = c;
    }
    measure(s, seam, boundary);
    int live = s->faces;
    if (live <= goal)
        return live;
    for (int v = 0; v < s->vertices; v++)
        weigh(s, v);
    while (live > goal && s->heaped > 0) {
        int u = s->heap[0];
        Edge e;
        double cost;
        if (!best_way(s, u, &e, &cost)) {
            drop(s, u);
            continue;
        }
        if (cost > s->cost[u]) { /* the neighbourhood has changed since */
            s->cost[u] = cost;
            settle(s, 0);
            if (s->heap[0] != u)
                continue;
        }
        drop(s, u);
        live -= collapse(s, u, &e);
        Star star;
        gather(s, e.vertex, &star);
        int around[2 * MOST_FACES + 1], count = 0;
        around[count++] = e.vertex;
        for (int i = 0; i < star.count && i < MOST_FACES; i++) {
            around[count++] = s->face[next_corner(star.corner[i])];
            around[count++] = s->face[previous_corner(star.corner[i])];
        }
        for (int i = 0; i < count; i++) {
            int seen = 0;
            for (int k = 0; k < i; k++)
                seen |= around[k] == around[i];
            if (!seen)
                weigh(s, around[i]);
        }
    }
    return live;
}

static PyObject *decimate(PyObject *self, PyObject *args) {
    (void)self;
    PyObject *objects[4];
    double sliding, seam, boundary;
    int poses, goal;
    if (!PyArg_ParseTuple(args, "OOOOidddi", &objects[0], &objects[1], &objects[2], &objects[3], &poses, &sliding, &seam, &boundary,
                          &goal))
        return NULL;
    Py_buffer views[4];
    const Argument wanted[4] = {{'d', -1, 0, "points"}, {'d', -1, 0, "uv"}, {'i', -1, 1, "faces"}, {'i', -1, 1, "wedges"}};
    if (take_arguments(objects, wanted, views, 4) < 0)
        return NULL;
    Py_ssize_t corners = views[2].len / 4, uvs = views[1].len / 16, all = views[0].len / 24;
    PyObject *result = NULL;
    if (poses < 1 || views[0].len % (24 * (Py_ssize_t)poses) || views[1].len % 16 || corners % 3 || views[3].len / 4 != corners ||
        corners > INT32_MAX / 4 || all / poses > INT32_MAX / 4 || uvs > INT32_MAX / 4) {
        PyErr_SetString(PyExc_ValueError, "decimate: expected points (poses, n, 3), uv (q, 2), faces (m, 3), wedges (m, 3)");
        goto release;
    }
    Py_ssize_t n = all / poses;
    const int *face = views[2].buf, *wedge = views[3].buf;
    for (Py_ssize_t c = 0; c < corners; c++)
        if (face[c] < 0 || face[c] >= n || wedge[c] < 0 || wedge[c] >= uvs) {
            PyErr_SetString(PyExc_ValueError, "decimate: faces or wedges: an index is out of range");
            goto release;
        }
    double *numbers = calloc((size_t)(all * PLANE + uvs * WEDGE + 2 * n) + 1, sizeof(double));
    int *integers = calloc((size_t)(corners + 5 * n) + 1, sizeof(int));
    if (numbers == NULL || integers == NULL) {
        free(numbers);
        free(integers);
        PyErr_NoMemory();
        goto release;
    }
    int live;
    Py_BEGIN_ALLOW_THREADS
    Mesh s = {.vertices = (int)n, .poses = poses, .faces = (int)(corners / 3), .points = views[0].buf, .uv = views[1].buf,
              .face = views[2].buf, .wedge = views[3].buf, .sliding = sliding};
    s.plane = numbers;
    s.slide = s.plane + all * PLANE;
    s.area = s.slide + uvs * WEDGE;
    s.cost = s.area + n;
    s.next = integers;
    s.head = s.next + corners;
    s.stamp = s.head + n;
    s.heap = s.stamp + n;
    s.place = s.heap + n;
    live = run(&s, goal, seam, boundary);
    Py_END_ALLOW_THREADS
    free(numbers);
    free(integers);
    result = PyLong_FromLong(live);
release:
    release_arguments(views, 4);
    return result;
}

PyMethodDef umg_decimate_methods[] = {
    {"decimate", decimate, METH_VARARGS,
     "decimate(points, uv, faces, wedges, poses, sliding, seam, boundary, goal) -> faces left: collapse edges in place; faces "
     "that are gone are -1."},
    {NULL, NULL, 0, NULL},
};
