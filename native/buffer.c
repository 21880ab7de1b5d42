#include "umg.h"

static Py_ssize_t item_size(char type) {
    switch (type) {
    case 'd':
    case 'l':
        return 8;
    case 'f':
    case 'i':
        return 4;
    default:
        return 1;
    }
}

/* Buffer formats name C types, whose widths differ between platforms: compare kind and width instead of letters. */
static int is_of_type(const Py_buffer *view, char type) {
    const char *format = view->format ? view->format : "B";
    if (*format == '@' || *format == '=' || *format == '<')
        format++;
    if (format[0] == '\0' || format[1] != '\0' || view->itemsize != item_size(type))
        return 0;
    switch (type) {
    case 'd':
        return *format == 'd';
    case 'f':
        return *format == 'f';
    case 'i':
    case 'l':
        return *format == 'i' || *format == 'l' || *format == 'q';
    default:
        return *format == 'B' || *format == '?';
    }
}

int umg_buffer(PyObject *object, Py_buffer *view, char type, Py_ssize_t length, int writable, const char *name) {
    int flags = PyBUF_C_CONTIGUOUS | PyBUF_FORMAT | (writable ? PyBUF_WRITABLE : 0);
    if (PyObject_GetBuffer(object, view, flags) < 0)
        return -1;
    if (!is_of_type(view, type)) {
        PyErr_Format(PyExc_TypeError, "%s: expected items of type '%c', got format '%s'", name, type,
                     view->format ? view->format : "B");
        PyBuffer_Release(view);
        return -1;
    }
    if (length >= 0 && view->len != length * view->itemsize) {
        PyErr_Format(PyExc_ValueError, "%s: expected %zd items, got %zd", name, length, view->len / view->itemsize);
        PyBuffer_Release(view);
        return -1;
    }
    return 0;
}
