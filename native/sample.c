/* Cubic spline coefficients of an image, and samples at many places. */
#include "arguments.h"
#include "spline.h"

UMG_VECTORISED
static void sample_all(const float *image, int64_t height, int64_t width, const double *places, int64_t count, int wrap,
                       float *colors) {
    for (int64_t i = 0; i < count; i++)
        sample_spline(image, height, width, places[2 * i], places[2 * i + 1], wrap, colors + 4 * i);
}

static PyObject *sample_image(PyObject *self, PyObject *args) {
    (void)self;
    PyObject *objects[3];
    Py_ssize_t height, width;
    int wrap;
    if (!PyArg_ParseTuple(args, "OnnOiO", &objects[0], &height, &width, &objects[1], &wrap, &objects[2]))
        return NULL;
    Py_buffer views[3];
    Argument image = {'f', height * width * 4, 0, "image"};
    Argument places = {'d', -1, 0, "places"};
    if (take_arguments(objects, &image, views, 1) < 0)
        return NULL;
    if (take_arguments(objects + 1, &places, views + 1, 1) < 0) {
        release_arguments(views, 1);
        return NULL;
    }
    Py_ssize_t count = views[1].len / 16;
    Argument colors = {'f', count * 4, 1, "colors"};
    if (take_arguments(objects + 2, &colors, views + 2, 1) < 0) {
        release_arguments(views, 2);
        return NULL;
    }
    Py_BEGIN_ALLOW_THREADS
    sample_all(views[0].buf, height, width, views[1].buf, count, wrap, views[2].buf);
    Py_END_ALLOW_THREADS
    release_arguments(views, 3);
    Py_RETURN_NONE;
}

/* Turn texels into spline coefficients along one line of `count` texels, `stride` floats apart, for `lanes` neighbouring
 * floats at once: a causal and an anticausal recursion with the pole sqrt(3) - 2. */
UMG_INLINE void filter_line(float *line, int64_t count, int64_t stride, int64_t lanes, float *power) {
    const float pole = -0.26794919243112270647f;
    if (count < 2)
        return;
    for (int64_t c = 0; c < lanes; c++)
        power[c] = 0;
    float factor = 1;
    for (int64_t k = 0; k < 16; k++, factor *= pole) {
        const float *texel = line + stride * mirror_index(k, count);
        for (int64_t c = 0; c < lanes; c++)
            power[c] += factor * texel[c];
    }
    for (int64_t c = 0; c < lanes; c++)
        line[c] = power[c];
    for (int64_t k = 1; k < count; k++) {
        float *here = line + stride * k;
        for (int64_t c = 0; c < lanes; c++)
            here[c] += pole * here[c - stride];
    }
    float *last = line + stride * (count - 1);
    for (int64_t c = 0; c < lanes; c++)
        last[c] = pole / (pole * pole - 1) * (last[c] + pole * last[c - stride]);
    for (int64_t k = count - 2; k >= 0; k--) {
        float *here = line + stride * k;
        for (int64_t c = 0; c < lanes; c++)
            here[c] = pole * (here[c + stride] - here[c]);
    }
    for (int64_t k = 0; k < count; k++)
        for (int64_t c = 0; c < lanes; c++)
            line[stride * k + c] *= 6;
}

enum { LANES = 64 };

UMG_VECTORISED
static void filter_all(float *image, int64_t height, int64_t width) {
    float power[LANES];
    for (int64_t row = 0; row < height; row++)
        filter_line(image + 4 * width * row, width, 4, 4, power);
    for (int64_t first = 0; first < 4 * width; first += LANES) {
        int64_t lanes = 4 * width - first < LANES ? 4 * width - first : LANES;
        filter_line(image + first, height, 4 * width, lanes, power);
    }
}

static PyObject *spline_filter(PyObject *self, PyObject *args) {
    (void)self;
    PyObject *object;
    Py_ssize_t height, width;
    if (!PyArg_ParseTuple(args, "Onn", &object, &height, &width))
        return NULL;
    Argument wanted = {'f', 4 * height * width, 1, "image"};
    Py_buffer view;
    if (take_arguments(&object, &wanted, &view, 1) < 0)
        return NULL;
    Py_BEGIN_ALLOW_THREADS
    filter_all(view.buf, height, width);
    Py_END_ALLOW_THREADS
    release_arguments(&view, 1);
    Py_RETURN_NONE;
}

PyMethodDef umg_sample_methods[] = {
    {"sample_image", sample_image, METH_VARARGS,
     "sample_image(coefficients, height, width, places, wrap, colors): samples of a spline with (height, width, 4) float32 "
     "coefficients at (count, 2) float64 pixel places (column, row; centres at half-integers), to (count, 4) float32."},
    {"spline_filter", spline_filter, METH_VARARGS,
     "spline_filter(image, height, width): replace the texels (height, width, 4) float32 by the coefficients of the cubic "
     "spline through them."},
    {NULL, NULL, 0, NULL},
};
