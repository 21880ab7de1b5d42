/* Distances of poses given triangle by triangle (Boukhayma and Boyer 2015, equations 1 to 3). */
#include "arguments.h"

#include <math.h>
#include <stdlib.h>

#define LANES 16

/* What a pair of triangles comes to before a yaw is chosen: of the unit quaternion of its turn, x^2 + y^2, z and w. */
typedef struct {
    float *level, *z, *w;
} Turns;

/* Rows of `count` triangles each: x, y, z, w, a, b, c; u and v floats apart. Returns the mean of |S - I| of both ways. */
UMG_VECTORISED
static double prepare(Py_ssize_t count, const float *restrict s, Py_ssize_t u, const float *restrict t, Py_ssize_t v,
                      float *restrict level, float *restrict z, float *restrict w) {
    float sums[LANES] = {0};
    for (Py_ssize_t first = 0; first < count; first += LANES)
        for (Py_ssize_t lane = 0; lane < LANES; lane++) {
            const Py_ssize_t m = first + lane;
            /* The map in the plane, [p q; 0 r], and its polar factors. */
            float p = t[m + 4 * v] / s[m + 4 * u], r = t[m + 6 * v] / s[m + 6 * u];
            float q = (t[m + 5 * v] - p * s[m + 5 * u]) / s[m + 6 * u];
            float across = sqrtf((p + r) * (p + r) + q * q), det = p * r, squares = p * p + q * q + r * r;
            float there = squares - 2 * across + 2, back = squares / (det * det) - 2 * across / det + 2;
            sums[lane] += sqrtf(there > 0 ? there : 0) + sqrtf(back > 0 ? back : 0);
            /* Half its turn about the normal. */
            float half_cos = sqrtf(0.5f + 0.5f * (p + r) / across), half_sin = -0.5f * q / (across * half_cos);
            /* t's frame, that turn, s's frame backwards. */
            float tx = t[m], ty = t[m + v], tz = t[m + 2 * v], tw = t[m + 3 * v];
            float ux = tx * half_cos + ty * half_sin, uy = ty * half_cos - tx * half_sin;
            float uz = tz * half_cos + tw * half_sin, uw = tw * half_cos - tz * half_sin;
            float sx = s[m], sy = s[m + u], sz = s[m + 2 * u], sw = s[m + 3 * u];
            float x = sw * ux - uw * sx - uy * sz + uz * sy, y = sw * uy - uw * sy - uz * sx + ux * sz;
            level[m] = x * x + y * y;
            z[m] = sw * uz - uw * sz - ux * sy + uy * sx;
            w[m] = sw * uw + ux * sx + uy * sy + uz * sz;
        }
    double sum = 0;
    for (int lane = 0; lane < LANES; lane++)
        sum += sums[lane];
    return sum / (2 * (double)count);
}

/* Mean angle of the turns followed by a yaw, given the cosine and sine of half of it. Half an angle is asin(sine of the half)
 * or pi / 2 - asin(cosine of the half), whichever has the smaller argument, with a polynomial good to 5e-8. */
UMG_VECTORISED
static double mean_angle(Py_ssize_t count, const float *restrict level, const float *restrict z, const float *restrict w, float c,
                         float s) {
    float sums[LANES] = {0};
    for (Py_ssize_t first = 0; first < count; first += LANES)
        for (Py_ssize_t lane = 0; lane < LANES; lane++) {
            const Py_ssize_t m = first + lane;
            float turned_z = z[m] * c + w[m] * s, turned_w = w[m] * c - z[m] * s;
            float sine = level[m] + turned_z * turned_z, cosine = turned_w * turned_w;
            float least = sine < cosine ? sine : cosine, root = sqrtf(least);
            float half = 0.118192922f;
            half = half * least - 0.082973022f;
            half = half * least + 0.0783105656f;
            half = half * least + 0.0336318385f;
            half = half * least + 0.0762626345f;
            half = half * least + 0.166603728f;
            half = half * least + 1.0000009f;
            half *= root;
            sums[lane] += sine < cosine ? half : 1.57079633f - half;
        }
    double sum = 0;
    for (int lane = 0; lane < LANES; lane++)
        sum += sums[lane];
    return 2 * sum / (double)count;
}

static PyObject *pose_distances(PyObject *self, PyObject *args) {
    (void)self;
    PyObject *objects[5];
    double stretch;
    int upper;
    if (!PyArg_ParseTuple(args, "OOOOOdp", &objects[0], &objects[1], &objects[2], &objects[3], &objects[4], &stretch, &upper))
        return NULL;
    const Argument wanted[5] = {
        {'f', -1, 0, "source"}, {'f', -1, 0, "target"}, {'d', -1, 0, "yaw"}, {'d', -1, 0, "weights"}, {'d', -1, 1, "squares"}};
    Py_buffer views[5];
    if (take_arguments(objects, wanted, views, 5) < 0)
        return NULL;
    /* Shapes: (7, rows + window - 1, count), (7, columns + window - 1, count), (rows, columns) twice, (window). */
    const Py_ssize_t window = views[3].len / 8;
    Py_ssize_t tall = views[0].ndim == 3 ? views[0].shape[1] : 0, wide = views[1].ndim == 3 ? views[1].shape[1] : 0;
    Py_ssize_t count = views[0].ndim == 3 ? views[0].shape[2] : 0;
    const Py_ssize_t rows = tall - window + 1, columns = wide - window + 1;
    if (count < LANES || count % LANES || rows < 1 || columns < 1 || views[0].shape[0] != 7 || views[1].shape[0] != 7 ||
        views[1].shape[2] != count || views[2].len != 8 * rows * columns || views[4].len != views[2].len) {
        release_arguments(views, 5);
        return PyErr_Format(PyExc_ValueError, "pose_distances: expected (7, frames, %d m) twice and (rows, columns) twice", LANES);
    }
    float *memory = malloc((size_t)(3 * count) * sizeof(float));
    if (memory == NULL) {
        release_arguments(views, 5);
        return PyErr_NoMemory();
    }
    const float *source = views[0].buf, *target = views[1].buf;
    const double *yaw = views[2].buf, *weights = views[3].buf;
    double *squares = views[4].buf;
    Turns turns = {memory, memory + count, memory + 2 * count};
    Py_BEGIN_ALLOW_THREADS
    for (Py_ssize_t n = 0; n < rows * columns; n++)
        squares[n] = 0;
    /* One pair of frames serves all windows it lies in, each with a yaw of its own. */
    for (Py_ssize_t i = 0; i < tall; i++)
        for (Py_ssize_t j = upper ? i : 0; j < wide; j++) {
            double stretched = -1;
            for (Py_ssize_t l = 0; l < window; l++) {
                Py_ssize_t row = i - l, column = j - l;
                if (row < 0 || column < 0 || row >= rows || column >= columns)
                    continue;
                if (stretched < 0) {
                    const float *s = source + i * count, *t = target + j * count;
                    stretched = prepare(count, s, tall * count, t, wide * count, turns.level, turns.z, turns.w);
                }
                double half = yaw[row * columns + column] / 2;
                double d = mean_angle(count, turns.level, turns.z, turns.w, (float)cos(half), (float)sin(half)) + stretch * stretched;
                squares[row * columns + column] += weights[l] * d * d;
            }
        }
    Py_END_ALLOW_THREADS
    free(memory);
    release_arguments(views, 5);
    Py_RETURN_NONE;
}

PyMethodDef umg_pose_methods[] = {
    {"pose_distances", pose_distances, METH_VARARGS,
     "pose_distances(source, target, yaw, weights, squares, stretch, upper): squares[r, c] = sum_l weights[l] d(r + l, c + l)^2, "
     "the latter's triangles turned by yaw[r, c]; where upper, only for c >= r. Turns and edges of triangles, (7, frames, count) "
     "float32, count a multiple of 16."},
    {NULL, NULL, 0, NULL},
};
