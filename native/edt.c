/* A surface on a cylindrical grid: its area as a measure, and the squared distance to it. */
#include "arguments.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Grid point (radius j, height i, angle a) lies at r = (j + 1/2) dr, z = bottom + i dz, angle 2 pi a / angles, and is
 * stored at (j * heights + i) * angles + a: rows of angles are contiguous. */
typedef struct {
    Py_ssize_t angles, radii, heights;
    double radius_step, bottom, height_step;
} Grid;

/* The nearest site known so far to every grid point: squared distance, position, and the triangle it lies on. */
typedef struct {
    float *square, *x, *y, *z;
    int32_t *triangle;
} Sites;

static float height(const Grid *g, Py_ssize_t i) { return (float)(g->bottom + (double)i * g->height_step); }

/* Offer the sites of one row of grid points to another row, all at height z. */
UMG_VECTORISED
static void relax(Py_ssize_t count, const float *restrict px, const float *restrict py, float pz, float *restrict square,
                  float *restrict x, float *restrict y, float *restrict z, int32_t *restrict triangle,
                  const float *restrict from_x, const float *restrict from_y, const float *restrict from_z,
                  const int32_t *restrict from_triangle) {
    for (Py_ssize_t a = 0; a < count; a++) {
        float dx = px[a] - from_x[a], dy = py[a] - from_y[a], dz = pz - from_z[a];
        float candidate = dx * dx + dy * dy + dz * dz;
        int better = candidate < square[a];
        square[a] = better ? candidate : square[a];
        x[a] = better ? from_x[a] : x[a];
        y[a] = better ? from_y[a] : y[a];
        z[a] = better ? from_z[a] : z[a];
        triangle[a] = better ? from_triangle[a] : triangle[a];
    }
}

static void relax_rows(Sites *s, const float *px, const float *py, float pz, Py_ssize_t to, Py_ssize_t from, Py_ssize_t count) {
    relax(count, px, py, pz, s->square + to, s->x + to, s->y + to, s->z + to, s->triangle + to, s->x + from, s->y + from,
          s->z + from, s->triangle + from);
}

/* The same for one point. Without a branch: which site is nearer is not predictable. */
static void relax_point(Sites *s, float px, float py, float pz, Py_ssize_t to, Py_ssize_t from) {
    float dx = px - s->x[from], dy = py - s->y[from], dz = pz - s->z[from];
    float candidate = dx * dx + dy * dy + dz * dz;
    Py_ssize_t best = candidate < s->square[to] ? from : to;
    s->square[to] = candidate < s->square[to] ? candidate : s->square[to];
    s->x[to] = s->x[best];
    s->y[to] = s->y[best];
    s->z[to] = s->z[best];
    s->triangle[to] = s->triangle[best];
}

/* One round of handing sites on to neighbours, along height, angle and radius, both ways each. A handed-on site is a point
 * of the surface, so a distance is never too small. */
static void sweep(const Grid *g, Sites *s, const float *px, const float *py) {
    const Py_ssize_t A = g->angles, R = g->radii, Z = g->heights;
    for (Py_ssize_t j = 0; j < R; j++) {
        const float *x = px + j * A, *y = py + j * A;
        for (Py_ssize_t step = 1; step < Z; step++)
            relax_rows(s, x, y, height(g, step), (j * Z + step) * A, (j * Z + step - 1) * A,
                       A);
        for (Py_ssize_t step = Z - 2; step >= 0; step--)
            relax_rows(s, x, y, height(g, step), (j * Z + step) * A, (j * Z + step + 1) * A,
                       A);
        /* One and a half turns each way, so that a site gets half way round from anywhere. Heights innermost: a step waits
         * for the step before it, but not for other heights. */
        for (Py_ssize_t step = 1; step < A + A / 2; step++)
            for (Py_ssize_t i = 0; i < Z; i++)
                relax_point(s, x[step % A], y[step % A], height(g, i), (j * Z + i) * A + step % A, (j * Z + i) * A + (step - 1) % A);
        for (Py_ssize_t step = A + A / 2 - 2; step >= 0; step--)
            for (Py_ssize_t i = 0; i < Z; i++)
                relax_point(s, x[step % A], y[step % A], height(g, i), (j * Z + i) * A + step % A, (j * Z + i) * A + (step + 1) % A);
    }
    for (Py_ssize_t i = 0; i < Z; i++) {
        const float z = height(g, i);
        for (Py_ssize_t j = R - 2; j >= 0; j--)
            relax_rows(s, px + j * A, py + j * A, z, (j * Z + i) * A, ((j + 1) * Z + i) * A, A);
        /* Across the axis to the opposite angle. */
        for (Py_ssize_t a = 0; a < A; a++)
            relax_point(s, px[a], py[a], z, i * A + a, i * A + (a + A / 2) % A);
        for (Py_ssize_t j = 1; j < R; j++)
            relax_rows(s, px + j * A, py + j * A, z, (j * Z + i) * A, ((j - 1) * Z + i) * A, A);
    }
}

static double clamp(double value, double least, double most) {
    return value < least ? least : value > most ? most : value;
}

/* Cubic convolution (Keys 1981, a = -1/2): reproduces quadratics, hence the squared distance to a plane. */
static void cubic_weights(double t, float *w) {
    w[0] = (float)(0.5 * t * (-1 + t * (2 - t)));
    w[1] = (float)(0.5 * (2 + t * t * (-5 + 3 * t)));
    w[2] = (float)(0.5 * t * (1 + t * (4 - 3 * t)));
    w[3] = (float)(0.5 * t * t * (t - 1));
}

/* Rows of the indicator while it is filled: one angle more before the first and two after the last, folded back at the end. */
#define PADDED(angles) ((angles) + 3)

UMG_VECTORISED
static void add_sample(const Grid *g, float *restrict indicator, Sites *s, const float *px, const float *py, const double *p,
                       double area, int32_t triangle) {
    const Py_ssize_t A = g->angles, Z = g->heights;
    double turns = atan2(p[1], p[0]) / 6.283185307179586;
    double u = (turns < 0 ? turns + 1 : turns) * (double)A;
    double v = clamp(sqrt(p[0] * p[0] + p[1] * p[1]) / g->radius_step - 0.5, -0.5, (double)g->radii - 2.001);
    double w = clamp((p[2] - g->bottom) / g->height_step, 1, (double)Z - 2.001);
    Py_ssize_t a0 = (Py_ssize_t)u, j0 = (Py_ssize_t)(v + 1) - 1, i0 = (Py_ssize_t)w;
    float wa[4], wr[4], wz[4];
    cubic_weights(u - (double)a0, wa);
    cubic_weights(v - (double)j0, wr);
    cubic_weights(w - (double)i0, wz);
    a0 = a0 < A ? a0 : a0 - A;
    for (int dj = 0; dj < 4; dj++) {
        Py_ssize_t j = j0 - 1 + dj, start = a0;
        if (j < 0) { /* the other side of the axis */
            j = -1 - j;
            start = a0 < A / 2 ? a0 + A / 2 : a0 - A / 2;
        }
        for (int di = 0; di < 4; di++) {
            float *restrict row = indicator + (j * Z + i0 - 1 + di) * PADDED(A) + start;
            float mass = (float)area * wr[dj] * wz[di];
            for (int da = 0; da < 4; da++)
                row[da] += mass * wa[da];
        }
        if (dj == 0 || dj == 3)
            continue;
        for (Py_ssize_t i = i0; i < i0 + 2; i++)
            for (Py_ssize_t step = start; step < start + 2; step++) {
                Py_ssize_t a = step < A ? step : step - A, index = (j * Z + i) * A + a;
                float dx = px[j * A + a] - (float)p[0], dy = py[j * A + a] - (float)p[1], dz = height(g, i) - (float)p[2];
                float square = dx * dx + dy * dy + dz * dz;
                if (square < s->square[index]) {
                    s->square[index] = square;
                    s->x[index] = (float)p[0];
                    s->y[index] = (float)p[1];
                    s->z[index] = (float)p[2];
                    s->triangle[index] = triangle;
                }
            }
    }
}

static double dot(const double *a, const double *b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

/* Squared distance from p to triangle abc (Ericson, Real-Time Collision Detection, 5.1.5). */
static double triangle_square(const double *p, const double *a, const double *b, const double *c) {
    double ab[3], ac[3], ap[3], bp[3], cp[3];
    for (int d = 0; d < 3; d++) {
        ab[d] = b[d] - a[d];
        ac[d] = c[d] - a[d];
        ap[d] = p[d] - a[d];
        bp[d] = p[d] - b[d];
        cp[d] = p[d] - c[d];
    }
    double d1 = dot(ab, ap), d2 = dot(ac, ap), d3 = dot(ab, bp), d4 = dot(ac, bp), d5 = dot(ab, cp), d6 = dot(ac, cp);
    double va = d3 * d6 - d5 * d4, vb = d5 * d2 - d1 * d6, vc = d1 * d4 - d3 * d2, s, t;
    if (d1 <= 0 && d2 <= 0)
        s = t = 0;
    else if (d3 >= 0 && d4 <= d3)
        s = 1, t = 0;
    else if (vc <= 0 && d1 >= 0 && d3 <= 0)
        s = d1 / (d1 - d3), t = 0;
    else if (d6 >= 0 && d5 <= d6)
        s = 0, t = 1;
    else if (vb <= 0 && d2 >= 0 && d6 <= 0)
        s = 0, t = d2 / (d2 - d6);
    else if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0) {
        t = (d4 - d3) / ((d4 - d3) + (d5 - d6));
        s = 1 - t;
    } else {
        double total = va + vb + vc;
        s = vb / total;
        t = vc / total;
    }
    double square = 0;
    for (int d = 0; d < 3; d++) {
        double difference = ap[d] - s * ab[d] - t * ac[d];
        square += difference * difference;
    }
    return square;
}

static void add_triangle(const Grid *g, float *restrict indicator, Sites *s, const float *px, const float *py, const double *a,
                         const double *b, const double *c, double spacing, int32_t triangle) {
    double ab[3], ac[3], bc[3];
    for (int d = 0; d < 3; d++) {
        ab[d] = b[d] - a[d];
        ac[d] = c[d] - a[d];
        bc[d] = c[d] - b[d];
    }
    double n[3] = {ab[1] * ac[2] - ab[2] * ac[1], ab[2] * ac[0] - ab[0] * ac[2], ab[0] * ac[1] - ab[1] * ac[0]};
    double area = 0.5 * sqrt(dot(n, n)), longest = fmax(dot(ab, ab), fmax(dot(ac, ac), dot(bc, bc)));
    if (!(area > 0))
        return;
    int parts = (int)clamp(ceil(sqrt(longest) / spacing), 1, 1024);
    double part_area = area / ((double)parts * parts);
    for (int row = 0; row < parts; row++)
        for (int column = 0; column < 2 * (parts - row) - 1; column++) {
            /* Barycentres of the parts^2 similar triangles, upright and inverted in turn. */
            double third = column % 2 ? 2.0 / 3 : 1.0 / 3;
            double t = (row + third) / parts, u = (column / 2 + third) / parts, p[3];
            for (int d = 0; d < 3; d++)
                p[d] = a[d] + u * ab[d] + t * ac[d];
            add_sample(g, indicator, s, px, py, p, part_area, triangle);
        }
}

static int describe(const Grid *g, const double *vertices, const int32_t *faces, Py_ssize_t face_count, double spacing, int rounds,
                    float *indicator, float *square, int32_t *triangles) {
    const Py_ssize_t A = g->angles, R = g->radii, Z = g->heights, count = A * R * Z;
    float *positions = malloc((size_t)(2 * A * R + 3 * count) * sizeof(float));
    float *padded = calloc((size_t)(PADDED(A) * R * Z), sizeof(float));
    if (positions == NULL || padded == NULL) {
        free(positions);
        free(padded);
        return -1;
    }
    float *px = positions, *py = px + A * R;
    Sites s = {square, py + A * R, py + A * R + count, py + A * R + 2 * count, triangles};
    for (Py_ssize_t n = 0; n < count; n++) {
        /* Far enough to lose against every true site, near enough for its square to be finite. */
        s.square[n] = INFINITY;
        s.x[n] = s.y[n] = s.z[n] = 1e15f;
        s.triangle[n] = -1;
    }
    for (Py_ssize_t j = 0; j < R; j++)
        for (Py_ssize_t a = 0; a < A; a++) {
            double angle = 6.283185307179586 * (double)a / (double)A, radius = ((double)j + 0.5) * g->radius_step;
            px[j * A + a] = (float)(radius * cos(angle));
            py[j * A + a] = (float)(radius * sin(angle));
        }
    for (Py_ssize_t f = 0; f < face_count; f++)
        add_triangle(g, padded, &s, px, py, vertices + 3 * faces[3 * f], vertices + 3 * faces[3 * f + 1],
                     vertices + 3 * faces[3 * f + 2], spacing, (int32_t)f);
    for (Py_ssize_t row = 0; row < R * Z; row++) {
        const float *from = padded + row * PADDED(A);
        float *to = indicator + row * A;
        memcpy(to, from + 1, (size_t)A * sizeof(float));
        to[A - 1] += from[0];
        to[0] += from[A + 1];
        to[1] += from[A + 2];
    }
    for (int round = 0; round < rounds; round++)
        sweep(g, &s, px, py);
    /* From the samples to their triangles: farther away a sample's own place in its triangle makes no difference. */
    const double step = fmax(g->radius_step, g->height_step), near = 9 * step * step;
    for (Py_ssize_t j = 0; j < R; j++)
        for (Py_ssize_t i = 0; i < Z; i++)
            for (Py_ssize_t a = 0; a < A; a++) {
                Py_ssize_t n = (j * Z + i) * A + a, f = s.triangle[n];
                if (f < 0 || square[n] > near)
                    continue;
                double p[3] = {px[j * A + a], py[j * A + a], g->bottom + (double)i * g->height_step};
                square[n] = (float)triangle_square(p, vertices + 3 * faces[3 * f], vertices + 3 * faces[3 * f + 1],
                                                   vertices + 3 * faces[3 * f + 2]);
            }
    free(positions);
    free(padded);
    return 0;
}

static PyObject *cylindrical_edt(PyObject *self, PyObject *args) {
    (void)self;
    PyObject *objects[5];
    Grid g;
    double spacing;
    int rounds;
    if (!PyArg_ParseTuple(args, "OOOOOnnnddddi", &objects[0], &objects[1], &objects[2], &objects[3], &objects[4], &g.radii, &g.heights, &g.angles,
                          &g.radius_step, &g.bottom, &g.height_step, &spacing, &rounds))
        return NULL;
    if (g.radii < 4 || g.heights < 4 || g.angles < 4 || g.angles % 2 || g.radii > 4096 || g.heights > 4096 || g.angles > 4096)
        return PyErr_Format(PyExc_ValueError, "cylindrical_edt: expected 4 to 4096 grid points a side, an even number of angles");
    Py_ssize_t count = g.radii * g.heights * g.angles;
    const Argument wanted[5] = {{'d', -1, 0, "vertices"},
                                {'i', -1, 0, "faces"},
                                {'f', count, 1, "indicator"},
                                {'f', count, 1, "square"},
                                {'i', count, 1, "nearest"}};
    Py_buffer views[5];
    if (take_arguments(objects, wanted, views, 5) < 0)
        return NULL;
    int status;
    Py_BEGIN_ALLOW_THREADS
    status = describe(&g, views[0].buf, views[1].buf, views[1].len / 12, spacing, rounds, views[2].buf, views[3].buf, views[4].buf);
    Py_END_ALLOW_THREADS
    release_arguments(views, 5);
    if (status < 0)
        return PyErr_NoMemory();
    Py_RETURN_NONE;
}

PyMethodDef umg_edt_methods[] = {
    {"cylindrical_edt", cylindrical_edt, METH_VARARGS,
     "cylindrical_edt(vertices, faces, indicator, square, nearest, radii, heights, angles, radius_step, bottom, height_step, "
     "spacing, rounds): area measure and squared distance of a triangle surface, written to (radii, heights, angles) float32, "
     "and its nearest triangle, int32."},
    {NULL, NULL, 0, NULL},
};
