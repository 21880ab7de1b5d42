/* Least costs of warped transitions between all pairs of frames (dynamic time warping). */
#include "arguments.h"

#include <math.h>
#include <stdlib.h>

/* Columns that are worked on at once: as many starts, side by side. */
enum { LANES = 16 };

/* What the next row, and the next column of this row, need of a cell: the least cost of the ways that end there with an
 * even and with an odd number of cells so far. `all` by any step, `not_down` by any but a step down the rows, `down1`
 * and `down2` by one and by two such steps in a row. */
typedef struct {
    float all[2][LANES], not_down[2][LANES], down1[2][LANES], down2[2][LANES];
} Cell;

UMG_INLINE float least(float a, float b) {
    return a < b ? a : b;
}

/* All ways from row i, columns b .. b + LANES - 1 (each lane its own start), down `rows` rows. Row r of `costs` begins at
 * costs + r * wide. A way from (i, b) to (a, c) ends at best[c] where a - i + 1 and c - b + 1 are `shortest` or more. */
UMG_VECTORISED
static void ways_from(const float *restrict costs, Py_ssize_t wide, Py_ssize_t rows, Py_ssize_t shortest,
                      Py_ssize_t longest, int odd_only, Cell *restrict before, Cell *restrict now,
                      float *restrict best) {
    for (Py_ssize_t p = 0; p < rows; p++) {
        const float *row = costs + p * wide;
        float not_across[2][LANES], across1[2][LANES], across2[2][LANES];
        for (int odd = 0; odd < 2; odd++)
            for (int n = 0; n < LANES; n++)
                not_across[odd][n] = across1[odd][n] = across2[odd][n] = INFINITY;
        for (Py_ssize_t q = 0; q < longest; q++) {
            const float *paid = row + q;
            Cell *cell = now + q;
            const Cell *above = before + q, *beside = before + q - 1;
            float next_not_across[2][LANES], next_across1[2][LANES], next_across2[2][LANES];
            for (int odd = 0; odd < 2; odd++) {
                int other = 1 - odd;
                for (int n = 0; n < LANES; n++) {
                    float cost = paid[n];
                    float diagonal = p && q ? beside->all[other][n] + cost : (p || q || !odd ? INFINITY : cost);
                    float down1 = p ? above->not_down[other][n] + cost : INFINITY;
                    float down2 = p ? above->down1[other][n] + cost : INFINITY;
                    float down3 = p ? above->down2[other][n] + cost : INFINITY;
                    float one = not_across[other][n] + cost;
                    float two = across1[other][n] + cost;
                    float three = across2[other][n] + cost;
                    float down = least(down1, least(down2, down3)), across = least(one, least(two, three));
                    cell->down1[odd][n] = down1;
                    cell->down2[odd][n] = down2;
                    cell->not_down[odd][n] = least(diagonal, across);
                    cell->all[odd][n] = least(down, least(diagonal, across));
                    next_not_across[odd][n] = least(diagonal, down);
                    next_across1[odd][n] = one;
                    next_across2[odd][n] = two;
                }
            }
            for (int odd = 0; odd < 2; odd++)
                for (int n = 0; n < LANES; n++) {
                    not_across[odd][n] = next_not_across[odd][n];
                    across1[odd][n] = next_across1[odd][n];
                    across2[odd][n] = next_across2[odd][n];
                }
            if (p + 1 >= shortest && q + 1 >= shortest)
                for (int n = 0; n < LANES; n++) {
                    float value = odd_only ? cell->all[1][n] : least(cell->all[0][n], cell->all[1][n]);
                    best[q + n] = least(best[q + n], value);
                }
        }
        Cell *swap = before;
        before = now;
        now = swap;
    }
}

static PyObject *warp_costs(PyObject *self, PyObject *args) {
    (void)self;
    PyObject *objects[3];
    Py_ssize_t height, wide, first, stop, shortest, longest;
    int odd_only;
    if (!PyArg_ParseTuple(args, "OOOnnnnnnp", &objects[0], &objects[1], &objects[2], &height, &wide, &first, &stop,
                          &shortest, &longest, &odd_only))
        return NULL;
    if (height < 0 || wide < 0 || height > INT32_MAX || wide > INT32_MAX || first < 0 || stop > height || shortest < 1 ||
        longest < shortest || longest > 1000000) {
        PyErr_Format(PyExc_ValueError, "warp_costs: rows %zd to %zd of %zd x %zd, lengths %zd to %zd do not fit", first,
                     stop, height, wide, shortest, longest);
        return NULL;
    }
    Py_ssize_t count = stop > first ? stop - first : 0;
    Argument wanted[] = {
        {'f', height * wide, 0, "costs"}, {'i', height, 0, "run_stop"}, {'f', count * wide, 1, "best"}};
    Py_buffer views[3];
    if (take_arguments(objects, wanted, views, 3) < 0)
        return NULL;
    Cell *cells = malloc(2 * ((size_t)longest + 1) * sizeof(Cell));
    if (!cells) {
        release_arguments(views, 3);
        return PyErr_NoMemory();
    }
    const float *costs = views[0].buf;
    const int32_t *run_stop = views[1].buf;
    float *best = views[2].buf;
    Py_BEGIN_ALLOW_THREADS
    for (Py_ssize_t row = first; row < stop; row++) {
        Py_ssize_t rows = run_stop[row] - row;
        rows = rows > longest ? longest : rows;
        rows = rows > height - row ? height - row : rows;
        float *out = best + (row - first) * wide;
        for (Py_ssize_t n = 0; n < wide; n++)
            out[n] = INFINITY;
        /* The columns beyond the last whole block are padding. */
        for (Py_ssize_t b = 0; b + LANES + longest - 1 <= wide; b += LANES)
            ways_from(costs + row * wide + b, wide, rows, shortest, longest, odd_only, cells + 1, cells + longest + 2,
                      out + b);
    }
    Py_END_ALLOW_THREADS
    free(cells);
    release_arguments(views, 3);
    Py_RETURN_NONE;
}

PyMethodDef umg_warp_methods[] = {
    {"warp_costs", warp_costs, METH_VARARGS,
     "warp_costs(costs, run_stop, best, height, wide, first, stop, shortest, longest, odd_only): for rows first .. stop-1 "
     "best[i, j], the least sum of costs (float32, height x wide) along a way of steps right, down or both from a cell of "
     "row i to a cell of column j; at most three steps right, or three down, in a row; shortest to longest rows and "
     "columns; only ways of an odd number of cells where odd_only. No row from run_stop[i] (int32) on is entered. Starts "
     "in the last longest + 15 columns are not tried."},
    {NULL, NULL, 0, NULL},
};
