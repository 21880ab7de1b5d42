#include "umg.h"

#define KERNEL(name) extern PyMethodDef umg_##name##_methods[];
#include "kernels.h"
#undef KERNEL

static struct PyModuleDef definition = {
    PyModuleDef_HEAD_INIT, "unstructured_mg._native", "Compiled kernels of unstructured_mg.", -1, NULL, NULL, NULL, NULL, NULL,
};

PyMODINIT_FUNC PyInit__native(void) {
    PyObject *module = PyModule_Create(&definition);
    if (module == NULL)
        return NULL;
#define KERNEL(name)                                                                                                             \
    if (PyModule_AddFunctions(module, umg_##name##_methods) < 0) {                                                               \
        Py_DECREF(module);                                                                                                       \
        return NULL;                                                                                                             \
    }
#include "kernels.h"
#undef KERNEL
    return module;
}
