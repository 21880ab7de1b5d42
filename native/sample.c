/* Bicubic samples of an image at many places. */
#include "arguments.h"
#include "bicubic.h"

UMG_VECTORISED
static void sample_all(const float *image, int64_t height, int64_t width, const double *places, int64_t count, int wrap,
                       float *colors) {
    for (int64_t i = 0; i < count; i++)
        sample_bicubic(image, height, width, places[2 * i], places[2 * i + 1], wrap, colors + 4 * i);
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

PyMethodDef umg_sample_methods[] = {
    {"sample_image", sample_image, METH_VARARGS,
     "sample_image(image, height, width, places, wrap, colors): Catmull-Rom samples of a (height, width, 4) float32 image at "
     "(count, 2) float64 pixel places (column, row; centres at half-integers), written to (count, 4) float32."},
    {NULL, NULL, 0, NULL},
};
