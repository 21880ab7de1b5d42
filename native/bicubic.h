/* Catmull-Rom sampling of a (height, width, 4) float32 image: it interpolates, and blurs far less than bilinear. */
#ifndef UMG_BICUBIC_H
#define UMG_BICUBIC_H

#include "arguments.h"

#include <math.h>
#include <stdint.h>

UMG_INLINE void catmull_rom(float t, float *w) {
    float t2 = t * t, t3 = t2 * t;
    w[0] = 0.5f * (-t3 + 2 * t2 - t);
    w[1] = 0.5f * (3 * t3 - 5 * t2 + 2);
    w[2] = 0.5f * (-3 * t3 + 4 * t2 + t);
    w[3] = 0.5f * (t3 - t2);
}

UMG_INLINE int64_t clamp_index(int64_t i, int64_t size) { return i < 0 ? 0 : i >= size ? size - 1 : i; }

UMG_INLINE int64_t wrap_index(int64_t i, int64_t size) {
    i %= size;
    return i < 0 ? i + size : i;
}

/* x, y in pixels, pixel centres at half-integers; `out` gets the four channels. */
UMG_INLINE void sample_bicubic(const float *image, int64_t height, int64_t width, double x, double y, int wrap, float *out) {
    double fx = floor(x - 0.5), fy = floor(y - 0.5);
    int64_t column = (int64_t)fx, row = (int64_t)fy;
    float wx[4], wy[4];
    catmull_rom((float)(x - 0.5 - fx), wx);
    catmull_rom((float)(y - 0.5 - fy), wy);
    float sum[4] = {0, 0, 0, 0};
    if (column >= 1 && row >= 1 && column + 2 < width && row + 2 < height) {
        const float *corner = image + 4 * ((row - 1) * width + column - 1);
        for (int j = 0; j < 4; j++, corner += 4 * width)
            for (int c = 0; c < 4; c++)
                sum[c] += wy[j] * (wx[0] * corner[c] + wx[1] * corner[4 + c] + wx[2] * corner[8 + c] + wx[3] * corner[12 + c]);
    } else {
        for (int j = 0; j < 4; j++) {
            int64_t r = wrap ? wrap_index(row - 1 + j, height) : clamp_index(row - 1 + j, height);
            for (int i = 0; i < 4; i++) {
                int64_t k = wrap ? wrap_index(column - 1 + i, width) : clamp_index(column - 1 + i, width);
                for (int c = 0; c < 4; c++)
                    sum[c] += wy[j] * wx[i] * image[4 * (r * width + k) + c];
            }
        }
    }
    for (int c = 0; c < 4; c++)
        out[c] = sum[c];
}

#endif
