/* The linear system of one level of optical flow on a surface. */
#include "arguments.h"

/* Per face: the tensor of slopes, what pulls the flow, and their 6x6 and 6 shares of the system.
 * Slopes are those of both signals in the face's plane, by hat gradients; the field is taken at the barycentre. */
UMG_VECTORISED
static void assemble(const int32_t *faces, const double *gradients, const double *areas, const double *spread, int64_t count,
                     const double *first, const double *second, int64_t channels, const int64_t *slot, double *data,
                     double *right, double *tensors, double *pulls) {
    for (int64_t f = 0; f < count; f++) {
        const int32_t *corner = faces + 3 * f;
        const double *g = gradients + 6 * f;
        double xx = 0, xy = 0, yy = 0, px = 0, py = 0;
        for (int64_t c = 0; c < channels; c++) {
            double change = 0;
            for (int i = 0; i < 3; i++)
                change += first[channels * corner[i] + c] - second[channels * corner[i] + c];
            change /= 3;
            for (int which = 0; which < 2; which++) {
                const double *signal = which ? second : first;
                double x = 0, y = 0;
                for (int i = 0; i < 3; i++) {
                    double value = signal[channels * corner[i] + c];
                    x += value * g[2 * i];
                    y += value * g[2 * i + 1];
                }
                xx += x * x;
                xy += x * y;
                yy += y * y;
                px += x * change;
                py += y * change;
            }
        }
        double *tensor = tensors + 3 * f, *pull = pulls + 2 * f;
        tensor[0] = xx;
        tensor[1] = xy;
        tensor[2] = yy;
        pull[0] = px;
        pull[1] = py;
        const double *s = spread + 12 * f; /* (2, 6): six corner components to the field at the barycentre */
        double area = areas[f];
        for (int i = 0; i < 6; i++) {
            double tx = area * (xx * s[i] + xy * s[6 + i]), ty = area * (xy * s[i] + yy * s[6 + i]);
            for (int j = 0; j < 6; j++)
                data[slot[36 * f + 6 * i + j]] += tx * s[j] + ty * s[6 + j];
            right[2 * corner[i / 2] + i % 2] += area * (s[i] * px + s[6 + i] * py);
        }
    }
}

static PyObject *assemble_flow(PyObject *self, PyObject *args) {
    (void)self;
    PyObject *o[11];
    Py_ssize_t count, vertices, channels, entries;
    if (!PyArg_ParseTuple(args, "nnnnOOOOOOOOOOO", &count, &vertices, &channels, &entries, &o[0], &o[1], &o[2], &o[3], &o[4],
                          &o[5], &o[6], &o[7], &o[8], &o[9], &o[10]))
        return NULL;
    Argument wanted[11] = {{'i', 3 * count, 0, "faces"},
                           {'d', 6 * count, 0, "gradients"},
                           {'d', count, 0, "areas"},
                           {'d', 12 * count, 0, "spread"},
                           {'d', channels * vertices, 0, "first"},
                           {'d', channels * vertices, 0, "second"},
                           {'l', 36 * count, 0, "slot"},
                           {'d', entries, 1, "data"},
                           {'d', 2 * vertices, 1, "right"},
                           {'d', 3 * count, 1, "tensors"},
                           {'d', 2 * count, 1, "pulls"}};
    Py_buffer v[11];
    if (take_arguments(o, wanted, v, 11) < 0)
        return NULL;
    Py_BEGIN_ALLOW_THREADS
    assemble(v[0].buf, v[1].buf, v[2].buf, v[3].buf, count, v[4].buf, v[5].buf, channels, v[6].buf, v[7].buf, v[8].buf,
             v[9].buf, v[10].buf);
    Py_END_ALLOW_THREADS
    release_arguments(v, 11);
    Py_RETURN_NONE;
}

PyMethodDef umg_flow_methods[] = {
    {"assemble_flow", assemble_flow, METH_VARARGS,
     "assemble_flow(count, vertices, channels, entries, faces, gradients, areas, spread, first, second, slot, data, right, "
     "tensors, pulls): add every face's data term to the matrix entries data (at slot (faces, 6, 6)) and to right (vertices, 2); "
     "tensors (faces, 3) and pulls (faces, 2) get its slope products and slope times change."},
    {NULL, NULL, 0, NULL},
};
