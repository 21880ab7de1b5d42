/* Cubic spline interpolation of a (height, width, 4) float32 image, given its coefficients (sample.c): it keeps fine detail
 * far better between texels than a kernel of the same width on the texels themselves. */
#ifndef UMG_SPLINE_H
#define UMG_SPLINE_H

#include "arguments.h"

#include <math.h>
#include <stdint.h>

UMG_INLINE void spline_weights(float t, float *w) {
    float s = 1 - t;
    w[0] = s * s * s / 6;
    w[1] = (4 - 3 * t * t * (2 - t)) / 6;
    w[2] = (4 - 3 * s * s * (2 - s)) / 6;
    w[3] = t * t * t / 6;
}

/* The image goes on mirrored about its outermost texels, as its coefficients assume. */
UMG_INLINE int64_t mirror_index(int64_t i, int64_t size) {
    if (i < 0)
        i = -i;
    if (i >= size)
        i = 2 * size - 2 - i;
    return i < 0 ? 0 : i >= size ? size - 1 : i;
}

UMG_INLINE int64_t wrap_index(int64_t i, int64_t size) {
    i %= size;
    return i < 0 ? i + size : i;
}

/* x, y in pixels, pixel centres at half-integers; `out` gets the four channels. */
UMG_INLINE void sample_spline(const float *image, int64_t height, int64_t width, double x, double y, int wrap, float *out) {
    double fx = floor(x - 0.5), fy = floor(y - 0.5);
    int64_t column = (int64_t)fx, row = (int64_t)fy;
    float wx[4], wy[4];
    spline_weights((float)(x - 0.5 - fx), wx);
    spline_weights((float)(y - 0.5 - fy), wy);
    float sum[4] = {0, 0, 0, 0};
    if (column >= 1 && row >= 1 && column + 2 < width && row + 2 < height) {
        const float *corner = image + 4 * ((row - 1) * width + column - 1);
        for (int j = 0; j < 4; j++, corner += 4 * width)
            for (int c = 0; c < 4; c++)
                sum[c] += wy[j] * (wx[0] * corner[c] + wx[1] * corner[4 + c] + wx[2] * corner[8 + c] + wx[3] * corner[12 + c]);
    } else {
        for (int j = 0; j < 4; j++) {
            int64_t r = wrap ? wrap_index(row - 1 + j, height) : mirror_index(row - 1 + j, height);
            for (int i = 0; i < 4; i++) {
                int64_t k = wrap ? wrap_index(column - 1 + i, width) : mirror_index(column - 1 + i, width);
                for (int c = 0; c < 4; c++)
                    sum[c] += wy[j] * wx[i] * image[4 * (r * width + k) + c];
            }
        }
    }
    for (int c = 0; c < 4; c++)
        out[c] = sum[c];
}

#endif
