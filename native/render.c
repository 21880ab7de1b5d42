/* Triangles to pixels: perspective-correct, z-buffered, bilinear texture, several samples a pixel, no GL.
 * One thread and a fixed order of faces, so the same arrays give the same bytes everywhere. */
#include "umg.h"

#include <math.h>
#include <stdlib.h>

/* A corner after projection: sample coordinates, depth (smaller is nearer), 1 / w, and what is interpolated, each
 * already multiplied by 1 / w: u, v, unused (with a texture) or red, green, blue (without); then the shade. */
typedef struct {
    double x, y, z, inverse, value[4];
} corner;

typedef struct {
    const unsigned char *texels; /* NULL without a texture */
    int64_t height, width;
    int64_t rows, columns; /* samples of the target */
    double *depth;
    unsigned char *sample; /* red, green, blue */
} target;

static inline unsigned char to_byte(double value) { return value <= 0 ? 0 : value >= 255 ? 255 : (unsigned char)(value + 0.5); }

/* Texel centres lie at (i + 1/2) / size. The atlas repeats outside 0..1, but inside its edge is not mixed with the opposite one. */
static inline void texture_at(const target *to, double u, double v, double *color) {
    if (u < 0 || u > 1)
        u -= floor(u);
    if (v < 0 || v > 1)
        v -= floor(v);
    double x = u * to->width - 0.5, y = (1 - v) * to->height - 0.5;
    x = x < 0 ? 0 : x > to->width - 1 ? to->width - 1 : x;
    y = y < 0 ? 0 : y > to->height - 1 ? to->height - 1 : y;
    int64_t x0 = (int64_t)x, y0 = (int64_t)y;
    int64_t x1 = x0 + 1 < to->width ? x0 + 1 : x0, y1 = y0 + 1 < to->height ? y0 + 1 : y0;
    double fx = x - x0, fy = y - y0;
    const unsigned char *top = to->texels + 3 * y0 * to->width, *bottom = to->texels + 3 * y1 * to->width;
    for (int c = 0; c < 3; c++)
        color[c] = (1 - fy) * ((1 - fx) * top[3 * x0 + c] + fx * top[3 * x1 + c]) +
                   fy * ((1 - fx) * bottom[3 * x0 + c] + fx * bottom[3 * x1 + c]);
}

UMG_VECTORISED static void draw(const target *to, const corner *a, const corner *b, const corner *c) {
    double area = (b->x - a->x) * (c->y - a->y) - (b->y - a->y) * (c->x - a->x);
    if (area < 0) { /* both sides are drawn */
        const corner *swap = b;
        b = c, c = swap, area = -area;
    }
    if (!(area > 1e-12))
        return;
    double left = fmin(a->x, fmin(b->x, c->x)), right = fmax(a->x, fmax(b->x, c->x));
    double top = fmin(a->y, fmin(b->y, c->y)), bottom = fmax(a->y, fmax(b->y, c->y));
    if (right < 0 || bottom < 0 || left > to->columns || top > to->rows)
        return;
    int64_t x0 = left <= 0.5 ? 0 : (int64_t)ceil(left - 0.5), y0 = top <= 0.5 ? 0 : (int64_t)ceil(top - 0.5);
    int64_t x1 = right >= to->columns ? to->columns - 1 : (int64_t)floor(right - 0.5);
    int64_t y1 = bottom >= to->rows ? to->rows - 1 : (int64_t)floor(bottom - 0.5);
    double scale = 1 / area;
    double ax = (b->y - c->y) * scale, ay = (c->x - b->x) * scale;
    double bx = (c->y - a->y) * scale, by = (a->x - c->x) * scale;
    /* Both neighbours of an edge claim the samples on it, so that no crack opens where rounding differs. */
    const double inside = -1e-9;
    for (int64_t y = y0; y <= y1; y++) {
        for (int64_t x = x0; x <= x1; x++) {
            double wa = (x + 0.5 - c->x) * ax + (y + 0.5 - c->y) * ay;
            double wb = (x + 0.5 - c->x) * bx + (y + 0.5 - c->y) * by;
            double wc = 1 - wa - wb;
            if (wa < inside || wb < inside || wc < inside)
                continue;
            double z = wa * a->z + wb * b->z + wc * c->z;
            int64_t at = y * to->columns + x;
            if (!(z < to->depth[at]))
                continue;
            double value[4], color[3], w = 1 / (wa * a->inverse + wb * b->inverse + wc * c->inverse);
            for (int i = 0; i < 4; i++)
                value[i] = (wa * a->value[i] + wb * b->value[i] + wc * c->value[i]) * w;
            if (to->texels)
                texture_at(to, value[0], value[1], color);
            else
                color[0] = value[0], color[1] = value[1], color[2] = value[2];
            to->depth[at] = z;
            for (int i = 0; i < 3; i++)
                to->sample[3 * at + i] = to_byte(color[i] * value[3]);
        }
    }
}

/* Homogeneous corner: x, y, z, w, then the four values. Divided by w once nothing lies behind the camera. */
static corner divide(const double *h) {
    corner out = {.inverse = 1 / h[3]};
    out.x = h[0] * out.inverse, out.y = h[1] * out.inverse, out.z = h[2] * out.inverse;
    for (int i = 0; i < 4; i++)
        out.value[i] = h[4 + i] * out.inverse;
    return out;
}

/* Cut the triangle at w = near and draw what is left of it: nothing, one triangle or two. */
static void clip_and_draw(const target *to, double corners[3][8], double near) {
    corner kept[4];
    int count = 0;
    for (int i = 0; i < 3; i++) {
        const double *p = corners[i], *q = corners[(i + 1) % 3];
        if (p[3] >= near)
            kept[count++] = divide(p);
        if ((p[3] >= near) != (q[3] >= near)) {
            double cut[8], t = (near - p[3]) / (q[3] - p[3]);
            for (int j = 0; j < 8; j++)
                cut[j] = p[j] + t * (q[j] - p[j]);
            cut[3] = near;
            kept[count++] = divide(cut);
        }
    }
    for (int i = 2; i < count; i++)
        draw(to, &kept[0], &kept[i - 1], &kept[i]);
}

static void resolve(const target *to, int64_t height, int64_t width, int64_t samples, unsigned char *image,
                    unsigned char *coverage) {
    int64_t all = samples * samples;
    for (int64_t y = 0; y < height; y++)
        for (int64_t x = 0; x < width; x++) {
            int64_t sum[3] = {0, 0, 0}, hit = 0;
            for (int64_t j = 0; j < samples; j++)
                for (int64_t i = 0; i < samples; i++) {
                    int64_t at = (y * samples + j) * to->columns + x * samples + i;
                    if (to->depth[at] == HUGE_VAL)
                        continue;
                    hit++;
                    for (int c = 0; c < 3; c++)
                        sum[c] += to->sample[3 * at + c];
                }
            unsigned char *pixel = image + 3 * (y * width + x);
            for (int c = 0; c < 3; c++)
                pixel[c] = (unsigned char)((sum[c] + (all - hit) * pixel[c] + all / 2) / all);
            coverage[y * width + x] = (unsigned char)((255 * hit + all / 2) / all);
        }
}

static PyObject *render(PyObject *self, PyObject *args) {
    (void)self;
    enum { POINTS, FACES, VALUES, FACE_VALUES, SHADE, TEXELS, LAYOUT, MATERIAL, IMAGE, COVERAGE, BUFFERS };
    static const char *names[BUFFERS] = {"points", "faces",  "values",   "face_values", "shade",
                                         "texels", "layout", "material", "image",       "coverage"};
    static const char type[BUFFERS] = {'d', 'i', 'd', 'i', 'd', 'B', 'l', 'i', 'B', 'B'};
    PyObject *object[BUFFERS];
    Py_buffer view[BUFFERS];
    Py_ssize_t height, width, samples;
    double near;
    if (!PyArg_ParseTuple(args, "OOOOOOOOOOnnnd", &object[0], &object[1], &object[2], &object[3], &object[4], &object[5],
                          &object[6], &object[7], &object[8], &object[9], &height, &width, &samples, &near))
        return NULL;
    if (height < 1 || width < 1 || samples < 1 || height > 65536 || width > 65536 || samples > 64) {
        PyErr_Format(PyExc_ValueError, "size: expected 1 to 65536 pixels and 1 to 64 samples, got %zd x %zd and %zd", height,
                     width, samples);
        return NULL;
    }
    PyObject *result = NULL;
    int held = 0;
    for (; held < BUFFERS; held++) {
        Py_ssize_t length = -1;
        if (held == FACE_VALUES)
            length = view[FACES].len / 4;
        else if (held == SHADE)
            length = view[POINTS].len / 32;
        else if (held == MATERIAL)
            length = view[FACES].len / 12;
        else if (held == IMAGE)
            length = 3 * height * width;
        else if (held == COVERAGE)
            length = height * width;
        if (umg_buffer(object[held], &view[held], type[held], length, held >= IMAGE, names[held]) < 0)
            goto release;
    }
    const double *points = view[POINTS].buf, *values = view[VALUES].buf, *shade = view[SHADE].buf;
    const int32_t *faces = view[FACES].buf, *face_values = view[FACE_VALUES].buf, *material = view[MATERIAL].buf;
    const int64_t *layout = view[LAYOUT].buf;
    int textured = view[LAYOUT].len > 0, per_value = textured ? 2 : 3;
    Py_ssize_t face_count = view[FACES].len / 12;
    target to = {.rows = height * samples, .columns = width * samples};
    to.depth = malloc(sizeof(double) * (size_t)(to.rows * to.columns));
    to.sample = malloc(3 * (size_t)(to.rows * to.columns));
    if (to.depth == NULL || to.sample == NULL) {
        free(to.depth);
        free(to.sample);
        PyErr_NoMemory();
        goto release;
    }
    Py_BEGIN_ALLOW_THREADS
    for (int64_t i = 0; i < to.rows * to.columns; i++)
        to.depth[i] = HUGE_VAL;
    for (Py_ssize_t f = 0; f < face_count; f++) {
        double corners[3][8];
        for (int i = 0; i < 3; i++) {
            const double *point = points + 4 * faces[3 * f + i], *value = values + per_value * face_values[3 * f + i];
            for (int j = 0; j < 4; j++)
                corners[i][j] = point[j];
            corners[i][4] = value[0], corners[i][5] = value[1], corners[i][6] = textured ? 0 : value[2];
            corners[i][7] = shade[faces[3 * f + i]];
        }
        if (textured) {
            const int64_t *image = layout + 3 * material[f];
            to.texels = (const unsigned char *)view[TEXELS].buf + image[0];
            to.height = image[1], to.width = image[2];
        }
        clip_and_draw(&to, corners, near);
    }
    resolve(&to, height, width, samples, view[IMAGE].buf, view[COVERAGE].buf);
    free(to.depth);
    free(to.sample);
    Py_END_ALLOW_THREADS
    result = Py_None;
    Py_INCREF(result);
release:
    while (held-- > 0)
        PyBuffer_Release(&view[held]);
    return result;
}

PyMethodDef umg_render_methods[] = {
    {"render", render, METH_VARARGS,
     "render(points, faces, values, face_values, shade, texels, layout, material, image, coverage, height, width, samples, "
     "near): draw triangles over image (height, width, 3) uint8, which holds the background, and write the share of each "
     "pixel that they cover (0..255) to coverage. points (n, 4) float64: homogeneous sample coordinates, depth, w; values: "
     "uv (q, 2) where layout (images, 3) int64 [offset into texels, height, width] is not empty, else colours (q, 3), float64."},
    {NULL, NULL, 0, NULL},
};
