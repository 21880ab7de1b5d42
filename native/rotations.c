/* Nearest rotations of many 3x3 matrices: the local step of every as-rigid-as-possible energy. */
#include "rotations.h"

#include <math.h>

#include "umg.h"

/* Horn's quaternion method: the rotation R that maximises tr(R^T A) is the top eigenvector of a symmetric 4x4 matrix,
 * found here by cyclic Jacobi rotations. Always a proper rotation, also for singular and reflecting A. */
static void nearest_rotation_jacobi(const double *a, double *r) {
    double m[4][4] = {{a[0] + a[4] + a[8], a[7] - a[5], a[2] - a[6], a[3] - a[1]},
                      {a[7] - a[5], a[0] - a[4] - a[8], a[1] + a[3], a[2] + a[6]},
                      {a[2] - a[6], a[1] + a[3], a[4] - a[0] - a[8], a[5] + a[7]},
                      {a[3] - a[1], a[2] + a[6], a[5] + a[7], a[8] - a[0] - a[4]}};
    double v[4][4] = {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}, {0, 0, 0, 1}};
    double scale = 0;
    for (int i = 0; i < 4; i++)
        for (int j = 0; j < 4; j++)
            scale += m[i][j] * m[i][j];
    for (int sweep = 0; sweep < 30; sweep++) {
        double off = 0;
        for (int i = 0; i < 3; i++)
            for (int j = i + 1; j < 4; j++)
                off += m[i][j] * m[i][j];
        if (off <= 1e-30 * scale)
            break;
        for (int p = 0; p < 3; p++)
            for (int q = p + 1; q < 4; q++) {
                if (m[p][q] == 0)
                    continue;
                double theta = (m[q][q] - m[p][p]) / (2 * m[p][q]);
                double t = (theta >= 0 ? 1.0 : -1.0) / (fabs(theta) + sqrt(theta * theta + 1));
                double c = 1 / sqrt(t * t + 1), s = t * c;
                for (int i = 0; i < 4; i++) {
                    double x = m[i][p], y = m[i][q];
                    m[i][p] = c * x - s * y;
                    m[i][q] = s * x + c * y;
                }
                for (int i = 0; i < 4; i++) {
                    double x = m[p][i], y = m[q][i];
                    m[p][i] = c * x - s * y;
                    m[q][i] = s * x + c * y;
                }
                for (int i = 0; i < 4; i++) {
                    double x = v[i][p], y = v[i][q];
                    v[i][p] = c * x - s * y;
                    v[i][q] = s * x + c * y;
                }
            }
    }
    int best = 0;
    for (int i = 1; i < 4; i++)
        if (m[i][i] > m[best][best])
            best = i;
    double w = v[0][best], x = v[1][best], y = v[2][best], z = v[3][best];
    r[0] = w * w + x * x - y * y - z * z;
    r[1] = 2 * (x * y - w * z);
    r[2] = 2 * (x * z + w * y);
    r[3] = 2 * (x * y + w * z);
    r[4] = w * w - x * x + y * y - z * z;
    r[5] = 2 * (y * z - w * x);
    r[6] = 2 * (x * z - w * y);
    r[7] = 2 * (y * z + w * x);
    r[8] = w * w - x * x - y * y + z * z;
}

/* Higham's scaled Newton iteration X <- (g X + X^-T / g) / 2 for the polar factor, which is the nearest rotation
 * where det A > 0: five times faster than the eigenvector. Returns 0, and nothing in r, where A is close to singular or
 * reflects. */
static int nearest_rotation_newton(const double *a, double *r) {
    double x[9], size = 0;
    for (int i = 0; i < 9; i++) {
        x[i] = a[i];
        size += a[i] * a[i];
    }
    for (int step = 0; step < 12; step++) {
        /* Cofactors: X^-T times the determinant. */
        double c[9] = {x[4] * x[8] - x[5] * x[7], x[5] * x[6] - x[3] * x[8], x[3] * x[7] - x[4] * x[6],
                       x[2] * x[7] - x[1] * x[8], x[0] * x[8] - x[2] * x[6], x[1] * x[6] - x[0] * x[7],
                       x[1] * x[5] - x[2] * x[4], x[2] * x[3] - x[0] * x[5], x[0] * x[4] - x[1] * x[3]};
        double determinant = x[0] * c[0] + x[1] * c[1] + x[2] * c[2];
        if (step == 0 && !(determinant > 1e-4 * size * sqrt(size)))
            return 0;
        double inverse = 1 / determinant, keep = 0.5, add = 0.5 * inverse;
        if (step < 2) {
            double own = 0, other = 0;
            for (int i = 0; i < 9; i++) {
                own += x[i] * x[i];
                other += c[i] * c[i];
            }
            double g = sqrt(sqrt(other * inverse * inverse / own));
            keep *= g;
            add /= g;
        }
        double change = 0;
        for (int i = 0; i < 9; i++) {
            double next = keep * x[i] + add * c[i];
            change += (next - x[i]) * (next - x[i]);
            x[i] = next;
        }
        if (change < 1e-20) {
            /* Convergence is quadratic: what is left is the square of this change. */
            for (int i = 0; i < 9; i++)
                r[i] = x[i];
            return 1;
        }
    }
    return 0;
}

void umg_nearest_rotation(const double *a, double *r) {
    if (!nearest_rotation_newton(a, r))
        nearest_rotation_jacobi(a, r);
}

static PyObject *fit_rotations(PyObject *self, PyObject *args) {
    (void)self;
    PyObject *matrices_object, *rotations_object;
    if (!PyArg_ParseTuple(args, "OO", &matrices_object, &rotations_object))
        return NULL;
    Py_buffer matrices, rotations;
    if (umg_buffer(matrices_object, &matrices, 'd', -1, 0, "matrices") < 0)
        return NULL;
    Py_ssize_t count = matrices.len / (9 * 8);
    if (umg_buffer(rotations_object, &rotations, 'd', count * 9, 1, "rotations") < 0) {
        PyBuffer_Release(&matrices);
        return NULL;
    }
    const double *a = matrices.buf;
    double *r = rotations.buf;
    Py_BEGIN_ALLOW_THREADS
    for (Py_ssize_t i = 0; i < count; i++)
        umg_nearest_rotation(a + 9 * i, r + 9 * i);
    Py_END_ALLOW_THREADS
    PyBuffer_Release(&matrices);
    PyBuffer_Release(&rotations);
    Py_RETURN_NONE;
}

PyMethodDef umg_rotations_methods[] = {
    {"fit_rotations", fit_rotations, METH_VARARGS,
     "fit_rotations(matrices, rotations): nearest proper rotations of (count, 3, 3) float64 matrices, written to rotations."},
    {NULL, NULL, 0, NULL},
};
