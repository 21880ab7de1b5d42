/* Local energy of fine detail, and its restoration where blending averaged it away. */
#include "arguments.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

UMG_INLINE int64_t within(int64_t i, int64_t size) { return i < 0 ? 0 : i >= size ? size - 1 : i; }

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
                sum[c] += in[channels * within(k, width) + c];
        for (int64_t x = 0; x < width; x++) {
            const float *next = in + channels * within(x + radius + 1, width), *last = in + channels * within(x - radius, width);
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
            sums[x] += rows[line * within(k, height) + x];
    for (int64_t y = 0; y < height; y++) {
        const float *in = rows + line * within(y + radius + 1, height), *out = rows + line * within(y - radius, height);
        for (int64_t x = 0; x < line; x++) {
            values[line * y + x] = (float)(sums[x] * scale);
            sums[x] += (double)in[x] - out[x];
        }
    }
}

/* Whether the differences from a texel to the right and below lie in charts. */
UMG_INLINE void pairs_inside(const uint8_t *inside, int64_t height, int64_t width, int64_t y, int64_t x, float pair[2]) {
    const uint8_t *here = inside + width * y + x;
    pair[0] = x + 1 < width && here[0] && here[1] ? 1.0f : 0.0f;
    pair[1] = y + 1 < height && here[0] && here[width] ? 1.0f : 0.0f;
}

/* Squared differences to the right and lower neighbours, all channels, averaged over boxes. */
UMG_VECTORISED
static void measure(const float *image, const uint8_t *inside, int64_t height, int64_t width, int64_t radius, float *rows,
                    double *sums, float *energy) {
    for (int64_t y = 0; y < height; y++)
        for (int64_t x = 0; x < width; x++) {
            float pair[2], sum = 0;
            pairs_inside(inside, height, width, y, x, pair);
            const float *here = image + 3 * (width * y + x);
            const float *right = pair[0] > 0 ? here + 3 : here, *below = pair[1] > 0 ? here + 3 * width : here;
            for (int c = 0; c < 3; c++)
                sum += (right[c] - here[c]) * (right[c] - here[c]) + (below[c] - here[c]) * (below[c] - here[c]);
            energy[width * y + x] = sum;
        }
    box_mean(energy, height, width, 1, radius, rows, sums);
}

/* What the binomial filter (1 2 1) / 4 along rows and columns takes away. */
UMG_VECTORISED
static void high_pass(const float *image, int64_t height, int64_t width, float *rows, float *detail) {
    int64_t line = 3 * width;
    for (int64_t y = 0; y < height; y++) {
        const float *here = image + line * y, *above = image + line * within(y - 1, height);
        const float *below = image + line * within(y + 1, height);
        for (int64_t x = 0; x < line; x++)
            rows[line * y + x] = 0.25f * (above[x] + below[x]) + 0.5f * here[x];
    }
    for (int64_t y = 0; y < height; y++)
        for (int64_t x = 0; x < width; x++) {
            const float *here = rows + line * y + 3 * x;
            const float *left = x > 0 ? here - 3 : here, *right = x + 1 < width ? here + 3 : here;
            for (int c = 0; c < 3; c++) {
                int64_t i = line * y + 3 * x + c;
                detail[i] = image[i] - (0.25f * (left[c] + right[c]) + 0.5f * here[c]);
            }
        }
}

/* Weigh detail by its own strength over the local one: edges count, grain hardly does. */
UMG_VECTORISED
static void favour_edges(float *detail, int64_t height, int64_t width, int64_t radius, float *rows, double *sums,
                         float *strength, float most) {
    for (int64_t i = 0; i < height * width; i++) {
        float grey = (detail[3 * i] + detail[3 * i + 1] + detail[3 * i + 2]) / 3;
        strength[i] = grey * grey;
    }
    box_mean(strength, height, width, 1, radius, rows, sums);
    for (int64_t i = 0; i < height * width; i++) {
        float grey = (detail[3 * i] + detail[3 * i + 1] + detail[3 * i + 2]) / 3;
        /* Half a grey level is what rounding leaves. */
        float weight = fabsf(grey) / (sqrtf(strength[i] > 0 ? strength[i] : 0) + 0.5f);
        weight = weight > most ? most : weight;
        for (int c = 0; c < 3; c++)
            detail[3 * i + c] *= weight;
    }
}

/* Local products of differences: image with image, image with detail, detail with detail. */
UMG_VECTORISED
static void products(const float *image, const float *detail, const uint8_t *inside, int64_t height, int64_t width,
                     int64_t radius, float *rows, double *sums, float *product) {
    for (int64_t y = 0; y < height; y++)
        for (int64_t x = 0; x < width; x++) {
            float pair[2], own = 0, mixed = 0, other = 0;
            pairs_inside(inside, height, width, y, x, pair);
            int64_t i = 3 * (width * y + x), next[2] = {pair[0] > 0 ? i + 3 : i, pair[1] > 0 ? i + 3 * width : i};
            for (int k = 0; k < 2; k++)
                for (int c = 0; c < 3; c++) {
                    float p = image[next[k] + c] - image[i + c], q = detail[next[k] + c] - detail[i + c];
                    own += p * p;
                    mixed += p * q;
                    other += q * q;
                }
            product[i] = own;
            product[i + 1] = mixed;
            product[i + 2] = other;
        }
    box_mean(product, height, width, 3, radius, rows, sums);
}

/* Add as much detail as brings the local energy to the wanted one: the positive root of a quadratic. */
UMG_VECTORISED
static void amplify(uint8_t *image, const uint8_t *inside, int64_t count, const float *detail, const float *product, const float *first,
                    const float *second, float share, float level, float most) {
    for (int64_t i = 0; i < count; i++) {
        float wanted = level * ((1 - share) * first[i] + share * second[i]);
        float lacking = wanted - product[3 * i], mixed = product[3 * i + 1], other = product[3 * i + 2];
        if (lacking <= 0 || !inside[i])
            continue;
        float square = mixed * mixed + other * lacking;
        float gain = lacking / (mixed + sqrtf(square > 0 ? square : 0) + 1e-6f);
        gain = gain < 0 ? 0 : gain > most ? most : gain;
        for (int c = 0; c < 3; c++) {
            float value = (float)image[3 * i + c] + gain * detail[3 * i + c];
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
    PyObject *o[3];
    Py_ssize_t height, width, radius;
    if (!PyArg_ParseTuple(args, "OOnnnO", &o[0], &o[1], &height, &width, &radius, &o[2]))
        return NULL;
    Argument wanted[3] = {
        {'f', 3 * height * width, 0, "image"}, {'B', height * width, 0, "inside"}, {'f', height * width, 1, "energy"}};
    Py_buffer v[3];
    if (take_arguments(o, wanted, v, 3) < 0)
        return NULL;
    Scratch scratch;
    int failed = take_scratch(&scratch, height, width);
    if (!failed) {
        Py_BEGIN_ALLOW_THREADS
        measure(v[0].buf, v[1].buf, height, width, radius, scratch.rows, scratch.sums, v[2].buf);
        Py_END_ALLOW_THREADS
        free_scratch(&scratch);
    }
    release_arguments(v, 3);
    if (failed)
        return NULL;
    Py_RETURN_NONE;
}

static PyObject *restore_detail(PyObject *self, PyObject *args) {
    (void)self;
    PyObject *o[4];
    Py_ssize_t height, width, radius;
    double share, level, edge, most;
    if (!PyArg_ParseTuple(args, "OOnnnOOdddd", &o[0], &o[1], &height, &width, &radius, &o[2], &o[3], &share, &level, &edge,
                          &most))
        return NULL;
    Argument wanted[4] = {{'B', 3 * height * width, 1, "image"},
                          {'B', height * width, 0, "inside"},
                          {'f', height * width, 0, "first"},
                          {'f', height * width, 0, "second"}};
    Py_buffer v[4];
    if (take_arguments(o, wanted, v, 4) < 0)
        return NULL;
    Scratch scratch;
    float *image = malloc(sizeof(float) * 3 * ((size_t)(height * width) + 1));
    float *product = malloc(sizeof(float) * 3 * ((size_t)(height * width) + 1));
    int failed = image == NULL || product == NULL;
    if (failed)
        PyErr_NoMemory();
    else
        failed = take_scratch(&scratch, height, width);
    if (!failed) {
        Py_BEGIN_ALLOW_THREADS
        const uint8_t *texels = v[0].buf;
        for (int64_t i = 0; i < 3 * height * width; i++)
            image[i] = texels[i];
        high_pass(image, height, width, scratch.rows, scratch.detail);
        favour_edges(scratch.detail, height, width, radius, scratch.rows, scratch.sums, product, (float)edge);
        products(image, scratch.detail, v[1].buf, height, width, radius, scratch.rows, scratch.sums, product);
        amplify(v[0].buf, v[1].buf, height * width, scratch.detail, product, v[2].buf, v[3].buf, (float)share, (float)level, (float)most);
        Py_END_ALLOW_THREADS
        free_scratch(&scratch);
    }
    free(image);
    free(product);
    release_arguments(v, 4);
    if (failed)
        return NULL;
    Py_RETURN_NONE;
}

PyMethodDef umg_detail_methods[] = {
    {"detail_energy", detail_energy, METH_VARARGS,
     "detail_energy(image, inside, height, width, radius, energy): of (height, width, 3) float32 the squared differences of "
     "neighbours that are both inside (height, width) uint8, averaged over boxes of 2 radius + 1 texels, to (height, width) "
     "float32."},
    {"restore_detail", restore_detail, METH_VARARGS,
     "restore_detail(image, inside, height, width, radius, first, second, share, level, edge, most): add finest detail, weighted "
     "by its strength over the local one up to edge, to (height, width, 3) uint8, in place, until its energy is level times "
     "(1 - share) first + share second, by a factor of most at most; what is not inside stays."},
    {NULL, NULL, 0, NULL},
};
