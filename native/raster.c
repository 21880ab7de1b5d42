/* Which face covers which texel, and the margin of texels around charts. */
#include "arguments.h"

#include <math.h>

typedef struct {
    double origin[2], to_b1[2], to_b2[2];
} Map;

/* Barycentric weights of corners 1 and 2 as affine functions of the place; 0 for a triangle without area. */
static int make_map(const double *p, Map *map) {
    double ux = p[2] - p[0], uy = p[3] - p[1], vx = p[4] - p[0], vy = p[5] - p[1];
    double area = ux * vy - uy * vx, size = fabs(ux) + fabs(uy) + fabs(vx) + fabs(vy);
    if (!(fabs(area) > 1e-12 * size * size) || !(fabs(area) > 1e-12))
        return 0;
    map->origin[0] = p[0];
    map->origin[1] = p[1];
    map->to_b1[0] = vy / area;
    map->to_b1[1] = -vx / area;
    map->to_b2[0] = -uy / area;
    map->to_b2[1] = ux / area;
    return 1;
}

/* Rows or columns whose centres lie in [low - margin, high + margin], cut to the image. */
static void span(double low, double high, double margin, int64_t size, int64_t *first, int64_t *last) {
    double a = ceil(low - margin - 0.5), b = floor(high + margin - 0.5);
    *first = a < 0 ? 0 : a > (double)size ? size : (int64_t)a;
    *last = b < 0 ? -1 : b >= (double)size ? size - 1 : (int64_t)b;
}

static double low3(double a, double b, double c) { return fmin(a, fmin(b, c)); }
static double high3(double a, double b, double c) { return fmax(a, fmax(b, c)); }

static int64_t cover(const double *places, int64_t faces, int64_t height, int64_t width, int32_t *owner, float *weights) {
    const double slack = 1e-9, inside = 1e-2;
    int64_t twice = 0;
    for (int64_t f = 0; f < faces; f++) {
        const double *p = places + 6 * f;
        Map map;
        if (!make_map(p, &map))
            continue;
        int64_t row0, row1, column0, column1;
        span(low3(p[0], p[2], p[4]), high3(p[0], p[2], p[4]), 1e-9, width, &column0, &column1);
        span(low3(p[1], p[3], p[5]), high3(p[1], p[3], p[5]), 1e-9, height, &row0, &row1);
        for (int64_t row = row0; row <= row1; row++) {
            double y = row + 0.5 - map.origin[1];
            for (int64_t column = column0; column <= column1; column++) {
                double x = column + 0.5 - map.origin[0];
                double b1 = map.to_b1[0] * x + map.to_b1[1] * y, b2 = map.to_b2[0] * x + map.to_b2[1] * y;
                double b0 = 1 - b1 - b2;
                if (b0 < -slack || b1 < -slack || b2 < -slack)
                    continue;
                int64_t t = row * width + column;
                if (owner[t] >= 0) {
                    double o1 = weights[2 * t], o2 = weights[2 * t + 1];
                    if (low3(b0, b1, b2) > inside && low3(1 - o1 - o2, o1, o2) > inside)
                        twice++;
                    continue;
                }
                owner[t] = (int32_t)f;
                weights[2 * t] = (float)b1;
                weights[2 * t + 1] = (float)b2;
            }
        }
    }
    return twice;
}

/* Nearest point to q on the segment a-b, as a fraction of it. */
static double segment_fraction(const double *a, const double *b, double x, double y) {
    double dx = b[0] - a[0], dy = b[1] - a[1], length = dx * dx + dy * dy;
    if (!(length > 0))
        return 0;
    double t = ((x - a[0]) * dx + (y - a[1]) * dy) / length;
    return t < 0 ? 0 : t > 1 ? 1 : t;
}

static void surround(const double *places, int64_t faces, int64_t height, int64_t width, double margin, const int32_t *covered,
                     int32_t *owner, float *weights, float *distance) {
    for (int64_t f = 0; f < faces; f++) {
        const double *p = places + 6 * f;
        Map map;
        if (!make_map(p, &map))
            continue;
        int64_t row0, row1, column0, column1;
        span(low3(p[0], p[2], p[4]), high3(p[0], p[2], p[4]), margin, width, &column0, &column1);
        span(low3(p[1], p[3], p[5]), high3(p[1], p[3], p[5]), margin, height, &row0, &row1);
        for (int64_t row = row0; row <= row1; row++)
            for (int64_t column = column0; column <= column1; column++) {
                int64_t t = row * width + column;
                if (covered[t] >= 0)
                    continue;
                double x = column + 0.5, y = row + 0.5, best = 1e300, fraction = 0;
                int edge = 0;
                for (int e = 0; e < 3; e++) {
                    const double *a = p + 2 * e, *b = p + 2 * ((e + 1) % 3);
                    double s = segment_fraction(a, b, x, y);
                    double dx = a[0] + s * (b[0] - a[0]) - x, dy = a[1] + s * (b[1] - a[1]) - y;
                    double squared = dx * dx + dy * dy;
                    if (squared < best) {
                        best = squared;
                        fraction = s;
                        edge = e;
                    }
                }
                if (best > margin * margin || !((float)best < distance[t]))
                    continue;
                distance[t] = (float)best;
                owner[t] = (int32_t)f;
                double at_edge[3] = {0, 0, 0};
                at_edge[edge] = 1 - fraction;
                at_edge[(edge + 1) % 3] = fraction;
                x -= map.origin[0];
                y -= map.origin[1];
                weights[4 * t] = (float)at_edge[1];
                weights[4 * t + 1] = (float)at_edge[2];
                weights[4 * t + 2] = (float)(map.to_b1[0] * x + map.to_b1[1] * y);
                weights[4 * t + 3] = (float)(map.to_b2[0] * x + map.to_b2[1] * y);
            }
    }
}

static PyObject *raster_faces(PyObject *self, PyObject *args) {
    (void)self;
    PyObject *objects[3];
    Py_ssize_t faces, height, width;
    if (!PyArg_ParseTuple(args, "OnnnOO", &objects[0], &faces, &height, &width, &objects[1], &objects[2]))
        return NULL;
    Argument wanted[3] = {
        {'d', 6 * faces, 0, "places"}, {'i', height * width, 1, "owner"}, {'f', 2 * height * width, 1, "weights"}};
    Py_buffer views[3];
    if (take_arguments(objects, wanted, views, 3) < 0)
        return NULL;
    int64_t twice;
    Py_BEGIN_ALLOW_THREADS
    twice = cover(views[0].buf, faces, height, width, views[1].buf, views[2].buf);
    Py_END_ALLOW_THREADS
    release_arguments(views, 3);
    return PyLong_FromLongLong(twice);
}

static PyObject *raster_margin(PyObject *self, PyObject *args) {
    (void)self;
    PyObject *objects[5];
    Py_ssize_t faces, height, width;
    double margin;
    if (!PyArg_ParseTuple(args, "OnnndOOOO", &objects[0], &faces, &height, &width, &margin, &objects[1], &objects[2],
                          &objects[3], &objects[4]))
        return NULL;
    Argument wanted[5] = {{'d', 6 * faces, 0, "places"},
                          {'i', height * width, 0, "covered"},
                          {'i', height * width, 1, "owner"},
                          {'f', 4 * height * width, 1, "weights"},
                          {'f', height * width, 1, "distance"}};
    Py_buffer views[5];
    if (take_arguments(objects, wanted, views, 5) < 0)
        return NULL;
    Py_BEGIN_ALLOW_THREADS
    surround(views[0].buf, faces, height, width, margin, views[1].buf, views[2].buf, views[3].buf, views[4].buf);
    Py_END_ALLOW_THREADS
    release_arguments(views, 5);
    Py_RETURN_NONE;
}

PyMethodDef umg_raster_methods[] = {
    {"raster_faces", raster_faces, METH_VARARGS,
     "raster_faces(places, faces, height, width, owner, weights): the first of the (faces, 3, 2) float64 pixel triangles that "
     "covers each texel centre to owner (height, width) int32 (left as it is elsewhere), weights of corners 1 and 2 to "
     "(height, width, 2) float32. Returns how often a texel lay well inside a second triangle."},
    {"raster_margin", raster_margin, METH_VARARGS,
     "raster_margin(places, faces, height, width, margin, covered, owner, weights, distance): for texels with covered < 0 the "
     "nearest triangle within margin pixels: owner, weights (height, width, 4) float32 = those of the nearest point of its rim, "
     "then those of the texel itself in the triangle's plane; distance (squared) starts as infinity."},
    {NULL, NULL, 0, NULL},
};
