/* Straightest paths and streamlines on a triangle surface, by unfolding one face after the other into the plane. */
#include "arguments.h"
#include "spline.h"

#include <stdlib.h>

typedef struct {
    const int32_t *neighbor; /* (f, 3) face across the edge opposite corner i, or -1 */
    const int32_t *entry;    /* (f, 3) the neighbour's corner opposite that edge */
    const double *to_weights; /* (f, 4) displacement in the face's plane to change of weights 1 and 2 */
    const double *turn;      /* (f, 3, 2) cosine and sine from this face's plane axes to the neighbour's */
} Surface;

enum { MOST_CROSSINGS = 1000 };

/* Move (face, b) by displacement d, given in the face's plane axes, straight on across edges; stop at a boundary. */
UMG_INLINE void walk(const Surface *s, int32_t *face, double *b, double dx, double dy) {
    int32_t f = *face;
    int entered = -1;
    for (int crossing = 0; crossing < MOST_CROSSINGS; crossing++) {
        const double *m = s->to_weights + 4 * (int64_t)f;
        double change[3];
        change[1] = m[0] * dx + m[1] * dy;
        change[2] = m[2] * dx + m[3] * dy;
        change[0] = -change[1] - change[2];
        double part = 1;
        int edge = -1;
        for (int i = 0; i < 3; i++)
            /* Rounding may point back over the edge just crossed: never take it at once. */
            if (change[i] < 0 && i != entered && b[i] + part * change[i] < 0) {
                part = b[i] / -change[i];
                edge = i;
            }
        for (int i = 0; i < 3; i++) {
            b[i] += part * change[i];
            if (b[i] < 0)
                b[i] = 0;
        }
        if (edge < 0)
            break;
        b[edge] = 0;
        int32_t next = s->neighbor[3 * (int64_t)f + edge];
        if (next < 0)
            break;
        int corner = s->entry[3 * (int64_t)f + edge];
        const double *turn = s->turn + 2 * (3 * (int64_t)f + edge);
        double left = b[(edge + 1) % 3], right = b[(edge + 2) % 3], rx = (1 - part) * dx, ry = (1 - part) * dy;
        b[corner] = 0;
        b[(corner + 2) % 3] = left;
        b[(corner + 1) % 3] = right;
        dx = turn[0] * rx - turn[1] * ry;
        dy = turn[1] * rx + turn[0] * ry;
        f = next;
        entered = corner;
    }
    double sum = b[0] + b[1] + b[2];
    for (int i = 0; i < 3; i++)
        b[i] /= sum;
    *face = f;
}

/* One step of a streamline: the midpoint rule, exact for the affine field inside a face. */
UMG_INLINE void flow_step(const Surface *s, const double *field, int32_t *face, double *b, double time) {
    const double *v = field + 6 * (int64_t)*face, *m = s->to_weights + 4 * (int64_t)*face;
    double x = b[0] * v[0] + b[1] * v[2] + b[2] * v[4], y = b[0] * v[1] + b[1] * v[3] + b[2] * v[5];
    double c1 = 0.5 * time * (m[0] * x + m[1] * y), c2 = 0.5 * time * (m[2] * x + m[3] * y);
    double x1 = x + c1 * (v[2] - v[0]) + c2 * (v[4] - v[0]), y1 = y + c1 * (v[3] - v[1]) + c2 * (v[5] - v[1]);
    if (x1 == 0 && y1 == 0)
        return;
    walk(s, face, b, time * x1, time * y1);
}

UMG_VECTORISED
static void trace_straight(const Surface *s, int32_t *face, double *weights, const double *displacement, int64_t count) {
    for (int64_t i = 0; i < count; i++)
        walk(s, face + i, weights + 3 * i, displacement[2 * i], displacement[2 * i + 1]);
}

UMG_VECTORISED
static void trace_along(const Surface *s, const double *field, const int32_t *face, const double *weights, int64_t count,
                        double time, int64_t steps, int32_t *faces_out, double *weights_out) {
    for (int64_t i = 0; i < count; i++) {
        int32_t f = face[i];
        double b[3] = {weights[3 * i], weights[3 * i + 1], weights[3 * i + 2]};
        for (int64_t k = 0; k < steps; k++) {
            flow_step(s, field, &f, b, time);
            faces_out[k * count + i] = f;
            for (int c = 0; c < 3; c++)
                weights_out[3 * (k * count + i) + c] = b[c];
        }
    }
}

/* For every vertex the corner whose face the field (its negative for a negative sign) points into, or nearly so: the one
 * where the smaller of the two other weights grows fastest. */
static void leave(const Surface *s, const int32_t *faces, const double *field, int64_t count, double sign, double *best,
                  int32_t *face, int32_t *corner) {
    for (int64_t f = 0; f < count; f++) {
        const double *m = s->to_weights + 4 * f;
        for (int i = 0; i < 3; i++) {
            double x = sign * field[6 * f + 2 * i], y = sign * field[6 * f + 2 * i + 1], change[3];
            change[1] = m[0] * x + m[1] * y;
            change[2] = m[2] * x + m[3] * y;
            change[0] = -change[1] - change[2];
            double least = fmin(change[(i + 1) % 3], change[(i + 2) % 3]);
            int32_t vertex = faces[3 * f + i];
            if (least > best[vertex]) {
                best[vertex] = least;
                face[vertex] = (int32_t)f;
                corner[vertex] = i;
            }
        }
    }
}

UMG_INLINE void look_up(const float *image, int64_t height, int64_t width, const float *places, int32_t f, const double *b,
                           float *color) {
    const float *p = places + 6 * (int64_t)f;
    sample_spline(image, height, width, b[0] * p[0] + b[1] * p[2] + b[2] * p[4], b[0] * p[1] + b[1] * p[3] + b[2] * p[5], 0,
                   color);
}

/* Blend of both ends at steps 1 .. steps of each texel, from one streamline through it. */
UMG_VECTORISED
static void advect(const Surface *s, const double *field, const float *places, const int32_t *face, const float *weights,
                   const int64_t *texel, int64_t count, const float *start, const float *end, int64_t height, int64_t width,
                   int64_t steps, float *sums, uint8_t *images) {
    double time = 1.0 / (double)(steps + 1);
    for (int64_t i = 0; i < count; i++) {
        float color[4];
        int32_t f = face[i];
        double b1 = weights[2 * i], b2 = weights[2 * i + 1];
        double b[3] = {1 - b1 - b2, b1, b2};
        for (int64_t k = 1; k <= steps; k++) {
            flow_step(s, field, &f, b, -time);
            look_up(start, height, width, places, f, b, color);
            float share = (float)(1 - time * (double)k);
            for (int c = 0; c < 3; c++)
                sums[3 * (k - 1) + c] = share * color[c];
        }
        f = face[i];
        b[0] = 1 - b1 - b2;
        b[1] = b1;
        b[2] = b2;
        for (int64_t k = steps; k >= 1; k--) {
            flow_step(s, field, &f, b, time);
            look_up(end, height, width, places, f, b, color);
            float share = (float)(time * (double)k);
            for (int c = 0; c < 3; c++) {
                float value = sums[3 * (k - 1) + c] + share * color[c];
                value = value < 0 ? 0 : value > 255 ? 255 : value;
                images[3 * ((k - 1) * height * width + texel[i]) + c] = (uint8_t)(value + 0.5f);
            }
        }
    }
}

/* The four tables of a surface: always the first arguments. */
#define TABLES(faces)                                                                                                            \
    {'i', 3 * (faces), 0, "neighbor"}, {'i', 3 * (faces), 0, "entry"}, {'d', 4 * (faces), 0, "to_weights"},                      \
        {'d', 6 * (faces), 0, "turn"}

static Surface surface_of(const Py_buffer *views) {
    Surface s = {views[0].buf, views[1].buf, views[2].buf, views[3].buf};
    return s;
}

static int faces_in_range(const Py_buffer *view, Py_ssize_t faces) {
    const int32_t *face = view->buf;
    for (Py_ssize_t i = 0; i < view->len / 4; i++)
        if (face[i] < 0 || face[i] >= faces) {
            PyErr_Format(PyExc_ValueError, "face: expected indices in 0..%zd, got %d", faces - 1, (int)face[i]);
            return 0;
        }
    return 1;
}

static PyObject *trace_displacements(PyObject *self, PyObject *args) {
    (void)self;
    PyObject *o[7];
    Py_ssize_t faces, count;
    if (!PyArg_ParseTuple(args, "nOOOOnOOO", &faces, &o[0], &o[1], &o[2], &o[3], &count, &o[4], &o[5], &o[6]))
        return NULL;
    Argument wanted[7] = {TABLES(faces),
                          {'i', count, 1, "face"},
                          {'d', 3 * count, 1, "weights"},
                          {'d', 2 * count, 0, "displacement"}};
    Py_buffer views[7];
    if (take_arguments(o, wanted, views, 7) < 0)
        return NULL;
    if (!faces_in_range(&views[4], faces)) {
        release_arguments(views, 7);
        return NULL;
    }
    Surface s = surface_of(views);
    Py_BEGIN_ALLOW_THREADS
    trace_straight(&s, views[4].buf, views[5].buf, views[6].buf, count);
    Py_END_ALLOW_THREADS
    release_arguments(views, 7);
    Py_RETURN_NONE;
}

static PyObject *trace_streamlines(PyObject *self, PyObject *args) {
    (void)self;
    PyObject *o[9];
    Py_ssize_t faces, count, steps;
    double time;
    if (!PyArg_ParseTuple(args, "nOOOOOnOOdnOO", &faces, &o[0], &o[1], &o[2], &o[3], &o[4], &count, &o[5], &o[6], &time, &steps,
                          &o[7], &o[8]))
        return NULL;
    Argument wanted[9] = {TABLES(faces),
                          {'d', 6 * faces, 0, "field"},
                          {'i', count, 0, "face"},
                          {'d', 3 * count, 0, "weights"},
                          {'i', steps * count, 1, "faces_out"},
                          {'d', 3 * steps * count, 1, "weights_out"}};
    Py_buffer views[9];
    if (take_arguments(o, wanted, views, 9) < 0)
        return NULL;
    if (!faces_in_range(&views[5], faces)) {
        release_arguments(views, 9);
        return NULL;
    }
    Surface s = surface_of(views);
    Py_BEGIN_ALLOW_THREADS
    trace_along(&s, views[4].buf, views[5].buf, views[6].buf, count, time, steps, views[7].buf, views[8].buf);
    Py_END_ALLOW_THREADS
    release_arguments(views, 9);
    Py_RETURN_NONE;
}

static PyObject *leave_vertices(PyObject *self, PyObject *args) {
    (void)self;
    PyObject *o[9];
    Py_ssize_t faces, vertices;
    double sign;
    if (!PyArg_ParseTuple(args, "nOOOOOOdnOOO", &faces, &o[0], &o[1], &o[2], &o[3], &o[4], &o[5], &sign, &vertices, &o[6], &o[7],
                          &o[8]))
        return NULL;
    Argument wanted[9] = {TABLES(faces),
                          {'i', 3 * faces, 0, "faces"},
                          {'d', 6 * faces, 0, "field"},
                          {'d', vertices, 1, "best"},
                          {'i', vertices, 1, "face"},
                          {'i', vertices, 1, "corner"}};
    Py_buffer views[9];
    if (take_arguments(o, wanted, views, 9) < 0)
        return NULL;
    Surface s = surface_of(views);
    Py_BEGIN_ALLOW_THREADS
    leave(&s, views[4].buf, views[5].buf, faces, sign, views[6].buf, views[7].buf, views[8].buf);
    Py_END_ALLOW_THREADS
    release_arguments(views, 9);
    Py_RETURN_NONE;
}

static PyObject *advect_texels(PyObject *self, PyObject *args) {
    (void)self;
    PyObject *o[12];
    Py_ssize_t faces, count, height, width, steps;
    if (!PyArg_ParseTuple(args, "nOOOOOOnOOOOOnnnO", &faces, &o[0], &o[1], &o[2], &o[3], &o[4], &o[5], &count, &o[6], &o[7],
                          &o[8], &o[9], &o[10], &height, &width, &steps, &o[11]))
        return NULL;
    Argument wanted[12] = {TABLES(faces),
                           {'d', 6 * faces, 0, "field"},
                           {'f', 6 * faces, 0, "places"},
                           {'i', count, 0, "face"},
                           {'f', 2 * count, 0, "weights"},
                           {'l', count, 0, "texel"},
                           {'f', 4 * height * width, 0, "start"},
                           {'f', 4 * height * width, 0, "end"},
                           {'B', 3 * steps * height * width, 1, "images"}};
    Py_buffer views[12];
    if (take_arguments(o, wanted, views, 12) < 0)
        return NULL;
    const int64_t *texel = views[8].buf;
    int sound = faces_in_range(&views[6], faces);
    for (Py_ssize_t i = 0; sound && i < count; i++)
        if (texel[i] < 0 || texel[i] >= height * width) {
            PyErr_Format(PyExc_ValueError, "texel: expected indices in 0..%zd", height * width - 1);
            sound = 0;
        }
    float *sums = sound ? malloc(sizeof(float) * 3 * (size_t)(steps > 0 ? steps : 1)) : NULL;
    if (sums == NULL) {
        release_arguments(views, 12);
        return sound ? PyErr_NoMemory() : NULL;
    }
    Surface s = surface_of(views);
    Py_BEGIN_ALLOW_THREADS
    advect(&s, views[4].buf, views[5].buf, views[6].buf, views[7].buf, texel, count, views[9].buf, views[10].buf, height, width,
           steps, sums, views[11].buf);
    Py_END_ALLOW_THREADS
    free(sums);
    release_arguments(views, 12);
    Py_RETURN_NONE;
}

PyMethodDef umg_trace_methods[] = {
    {"trace_displacements", trace_displacements, METH_VARARGS,
     "trace_displacements(faces, neighbor, entry, to_weights, turn, count, face, weights, displacement): move surface points "
     "(face, weights) in place, straight on by displacement (count, 2) given in the axes of their faces."},
    {"trace_streamlines", trace_streamlines, METH_VARARGS,
     "trace_streamlines(faces, neighbor, entry, to_weights, turn, field, count, face, weights, time, steps, faces_out, "
     "weights_out): the points after 1 .. steps steps of length time along field (faces, 3, 2)."},
    {"leave_vertices", leave_vertices, METH_VARARGS,
     "leave_vertices(faces, neighbor, entry, to_weights, turn, faces, field, sign, vertices, best, face, corner): for every "
     "vertex the face, and its corner there, into which sign times the field points; best starts as minus infinity."},
    {"advect_texels", advect_texels, METH_VARARGS,
     "advect_texels(faces, neighbor, entry, to_weights, turn, field, places, count, face, weights, texel, start, end, height, "
     "width, steps, images): from the spline coefficients start and end, at every texel the blend of both end images along the streamline through it, for all steps."},
    {NULL, NULL, 0, NULL},
};
