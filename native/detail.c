/* Local energy of fine detail, and its restoration where blending averaged it away. */
#include "arguments.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { SMOOTH = 3 }; /* radius of the boxes that, applied twice, are the low-pass filter */

UMG_INLINE int64_t inside(int64_t i, int64_t size) { return i < 0 ? 0 : i >= size ? size - 1 : i; }

/* Means over boxes of 2 radius + 1 texels a side, in place; `rows` is scratch of the same size. Sums in double: no drift. */
UMG_INLINE void box_mean(float *values, int64_t height, int64_t width, int64_t channels, int64_t radius, float *rows,
                         double *sums) {
    double scale = 1.0 / (double)(2 * radius + 1);
    int64_t line = width * channels;
    for (int64_t y = 0; y < height; y++) {
        const float *in = values + line * y;
        float *out = rows + line * y;
        double sum[3] = {0, 0, 0};
        for (int64_t k = -radius; k <= radius; k++)
            for (int64_t c = 0; c < channels; c++)
                sum[c] += in[channels * inside(k, width) + c];
        for (int64_t x = 0; x < width; x++) {
            const float *next = in + channels * inside(x + radius + 1, width), *last = in + channels * inside(x - radius, width);
            for (int64_t c = 0; c < channels; c++) {
                out[channels * x + c] = (float)(sum[c] * scale);
                sum[c] += (double)next[c] - last[c];
            }
        }
    }
    for (int64_t x = 0; x < line; x++)
        sums[x] = 0;
    for (int64_t k = -radius; k <= radius; k++)
        for (int64_t x = 0; x < line; x++)
            sums[x] += rows[line * inside(k, height) + x];
    for (int64_t y = 0; y < height; y++) {
        const float *in = rows + line * inside(y + radius + 1, height), *out = rows + line * inside(y - radius, height);
        for (int64_t x = 0; x < line; x++) {
            values[line * y + x] = (float)(sums[x] * scale);
            sums[x] += (double)in[x] - out[x];
        }
    }
}

/* Squared differences to the right and lower neighbours, all channels, averaged over boxes. */
UMG_VECTORISED
static void measure(const float *image, int64_t height, int64_t width, int64_t radius, float *rows, double *sums, float *energy) {
    for (int64_t y = 0; y < height; y++)
        for (int64_t x = 0; x < width; x++) {
            const float *here = image + 3 * (width * y + x);
            const float *right = x + 1 < width ? here + 3 : here, *below = y + 1 < height ? here + 3 * width : here;
            float sum = 0;
            for (int c = 0; c < 3; c++)
                sum += (right[c] - here[c]) * (right[c] - here[c]) + (below[c] - here[c]) * (below[c] - here[c]);
            energy[width * y + x] = sum;
        }
    box_mean(energy, height, width, 1, radius, rows, sums);
}

UMG_VECTORISED
static void high_pass(const float *image, int64_t height, int64_t width, float *rows, double *sums, float *detail) {
    memcpy(detail, image, sizeof(float) * 3 * (size_t)(height * width));
    box_mean(detail, height, width, 3, SMOOTH, rows, sums);
    box_mean(detail, height, width, 3, SMOOTH, rows, sums);
    for (int64_t i = 0; i < 3 * height * width; i++)
        detail[i] = image[i] - detail[i];
}

UMG_VECTORISED
static void amplify(uint8_t *image, int64_t count, const float *detail, const float *energy, const float *first,
                    const float *second, float share, float most) {
    for (int64_t i = 0; i < count; i++) {
        float wanted = (1 - share) * first[i] + share * second[i];
        float gain = sqrtf((wanted + 1) / (energy[i] + 1));
        gain = gain < 1 ? 1 : gain > most ? most : gain;
        for (int c = 0; c < 3; c++) {
            float value = (float)image[3 * i + c] + (gain - 1) * detail[3 * i + c];
            value = value < 0 ? 0 : value > 255 ? 255 : value;
            image[3 * i + c] = (uint8_t)(value + 0.5f);
        }
    }
}

typedef struct {
    float *rows, *detail;
    double *sums;
} Scratch;

static int take_scratch(Scratch *scratch, int64_t height, int64_t width) {
    size_t texels = (size_t)(height * width) + 1;
    scratch->rows = malloc(sizeof(float) * 3 * texels);
    scratch->detail = malloc(sizeof(float) * 3 * texels);
    scratch->sums = malloc(sizeof(double) * (3 * (size_t)width + 1));
    if (scratch->rows != NULL && scratch->detail != NULL && scratch->sums != NULL)
        return 0;
    free(scratch->rows);
    free(scratch->detail);
    free(scratch->sums);
    PyErr_NoMemory();
    return -1;
}

static void free_scratch(Scratch *scratch) {
    free(scratch->rows);
    free(scratch->detail);
    free(scratch->sums);
}

static PyObject *detail_energy(PyObject *self, PyObject *args) {
    (void)self;
    PyObject *o[2];
    Py_ssize_t height, width, radius;
    if (!PyArg_ParseTuple(args, "OnnnO", &o[0], &height, &width, &radius, &o[1]))
        return NULL;
    Argument wanted[2] = {{'f', 3 * height * width, 0, "image"}, {'f', height * width, 1, "energy"}};
    Py_buffer v[2];
    if (take_arguments(o, wanted, v, 2) < 0)
        return NULL;
    Scratch scratch;
    int failed = take_scratch(&scratch, height, width);
    if (!failed) {
        Py_BEGIN_ALLOW_THREADS
        measure(v[0].buf, height, width, radius, scratch.rows, scratch.sums, v[1].buf);
        Py_END_ALLOW_THREADS
        free_scratch(&scratch);
    }
    release_arguments(v, 2);
    if (failed)
        return NULL;
    Py_RETURN_NONE;
}

static PyObject *restore_detail(PyObject *self, PyObject *args) {
    (void)self;
    PyObject *o[3];
    Py_ssize_t height, width, radius;
    double share, most;
    if (!PyArg_ParseTuple(args, "OnnnOOdd", &o[0], &height, &width, &radius, &o[1], &o[2], &share, &most))
        return NULL;
    Argument wanted[3] = {
        {'B', 3 * height * width, 1, "image"}, {'f', height * width, 0, "first"}, {'f', height * width, 0, "second"}};
    Py_buffer v[3];
    if (take_arguments(o, wanted, v, 3) < 0)
        return NULL;
    Scratch scratch;
    float *image = malloc(sizeof(float) * 3 * ((size_t)(height * width) + 1));
    float *energy = malloc(sizeof(float) * ((size_t)(height * width) + 1));
    int failed = image == NULL || energy == NULL;
    if (failed)
        PyErr_NoMemory();
    else
        failed = take_scratch(&scratch, height, width);
    if (!failed) {
        Py_BEGIN_ALLOW_THREADS
        const uint8_t *texels = v[0].buf;
        for (int64_t i = 0; i < 3 * height * width; i++)
            image[i] = texels[i];
        measure(image, height, width, radius, scratch.rows, scratch.sums, energy);
        high_pass(image, height, width, scratch.rows, scratch.sums, scratch.detail);
        amplify(v[0].buf, height * width, scratch.detail, energy, v[1].buf, v[2].buf, (float)share, (float)most);
        Py_END_ALLOW_THREADS
        free_scratch(&scratch);
    }
    free(image);
    free(energy);
    release_arguments(v, 3);
    if (failed)
        return NULL;
    Py_RETURN_NONE;
}

PyMethodDef umg_detail_methods[] = {
    {"detail_energy", detail_energy, METH_VARARGS,
     "detail_energy(image, height, width, radius, energy): of (height, width, 3) float32 the squared differences of "
     "neighbours, averaged over boxes of 2 radius + 1 texels, to (height, width) float32."},
    {"restore_detail", restore_detail, METH_VARARGS,
     "restore_detail(image, height, width, radius, first, second, share, most): raise the high-passed part of (height, width, 3) "
     "uint8, in place, until its energy is (1 - share) first + share second, by a factor of most at most."},
    {NULL, NULL, 0, NULL},
};
