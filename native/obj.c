/* Wavefront OBJ text to arrays. The text is untrusted: every read stays inside it, every write inside the arrays given. */
#include "umg.h"

#include <math.h>
#include <string.h>

enum fault { FAULT_NONE, FAULT_NUMBER, FAULT_CORNER, FAULT_FEW_CORNERS, FAULT_VERTEX_INDEX, FAULT_UV_INDEX, FAULT_LENGTH };

/* Far beyond any index that can be in range, far below overflow of one more digit. */
#define INDEX_CAP ((int64_t)1 << 50)
#define LONGEST_NUMBER 127

enum keyword { KEYWORD_OTHER, KEYWORD_VERTEX, KEYWORD_UV, KEYWORD_FACE, KEYWORD_STATEMENT };

static int is_blank(char c) { return c == ' ' || c == '\t' || c == '\r' || c == '\v' || c == '\f'; }

static int is_digit(char c) { return c >= '0' && c <= '9'; }

static const char *skip_blanks(const char *at, const char *end) {
    while (at < end && is_blank(*at))
        at++;
    return at;
}

static int at_end(const char *at, const char *end) { return at >= end || *at == '#'; }

static int ends_word(const char *at, const char *end) { return at >= end || is_blank(*at); }

static const char *line_end(const char *at, const char *end) {
    const char *newline = memchr(at, '\n', (size_t)(end - at));
    return newline ? newline : end;
}

/* Recognise the line's first word and move past it. */
static enum keyword read_keyword(const char **line, const char *end) {
    const char *at = skip_blanks(*line, end);
    Py_ssize_t left = end - at;
    enum keyword keyword = KEYWORD_OTHER;
    Py_ssize_t length = 0;
    if (left >= 1 && at[0] == 'v' && ends_word(at + 1, end))
        keyword = KEYWORD_VERTEX, length = 1;
    else if (left >= 2 && at[0] == 'v' && at[1] == 't' && ends_word(at + 2, end))
        keyword = KEYWORD_UV, length = 2;
    else if (left >= 1 && at[0] == 'f' && ends_word(at + 1, end))
        keyword = KEYWORD_FACE, length = 1;
    else if (left >= 6 && (memcmp(at, "usemtl", 6) == 0 || memcmp(at, "mtllib", 6) == 0) && ends_word(at + 6, end))
        keyword = KEYWORD_STATEMENT; /* kept whole: Python reads its name */
    *line = at + length;
    return keyword;
}

static PyObject *obj_count(PyObject *self, PyObject *args) {
    (void)self;
    PyObject *text_object;
    if (!PyArg_ParseTuple(args, "O", &text_object))
        return NULL;
    Py_buffer text;
    if (umg_buffer(text_object, &text, 'B', -1, 0, "text") < 0)
        return NULL;
    long long vertices = 0, uvs = 0, triangles = 0, statements = 0;
    Py_BEGIN_ALLOW_THREADS
    const char *at = text.buf, *end = at + text.len;
    while (at < end) {
        const char *stop = line_end(at, end);
        switch (read_keyword(&at, stop)) {
        case KEYWORD_VERTEX:
            vertices++;
            break;
        case KEYWORD_UV:
            uvs++;
            break;
        case KEYWORD_STATEMENT:
            statements++;
            break;
        case KEYWORD_FACE: {
            long long corners = 0;
            for (at = skip_blanks(at, stop); !at_end(at, stop); at = skip_blanks(at, stop)) {
                corners++;
                while (at < stop && !is_blank(*at) && *at != '#')
                    at++;
            }
            if (corners > 2)
                triangles += corners - 2;
            break;
        }
        default:
            break;
        }
        at = stop + 1;
    }
    Py_END_ALLOW_THREADS
    PyBuffer_Release(&text);
    return Py_BuildValue("(LLLL)", vertices, uvs, triangles, statements);
}

/* A decimal number of at most 2^53 times a power of ten within 10^22 is one exact operation (Clinger 1990);
 * anything longer goes to Python's correctly rounded conversion, for which the GIL is taken back. */
static int read_number(const char **cursor, const char *end, double *value, PyThreadState **thread) {
    static const double POWERS[] = {1e0,  1e1,  1e2,  1e3,  1e4,  1e5,  1e6,  1e7,  1e8,  1e9,  1e10, 1e11,
                                    1e12, 1e13, 1e14, 1e15, 1e16, 1e17, 1e18, 1e19, 1e20, 1e21, 1e22};
    const char *start = *cursor, *at = start;
    int negative = 0, digits = 0, kept = 0, exponent = 0;
    uint64_t mantissa = 0;
    if (at < end && (*at == '-' || *at == '+'))
        negative = *at++ == '-';
    if (at < end && (*at == 'n' || *at == 'N' || *at == 'i' || *at == 'I')) { /* nan, inf, -nan(ind) ... */
        while (at < end && !is_blank(*at))
            at++;
        *value = NAN;
        *cursor = at;
        return 1;
    }
    for (; at < end && is_digit(*at); at++, digits++) {
        if (kept < 19) {
            mantissa = mantissa * 10 + (uint64_t)(*at - '0');
            kept += mantissa != 0;
        } else {
            kept = 20, exponent++;
        }
    }
    if (at < end && *at == '.') {
        at++;
        if (at < end && *at == '#') { /* 1.#QNAN, 1.#INF: how old C libraries print them */
            while (at < end && !is_blank(*at))
                at++;
            *value = NAN;
            *cursor = at;
            return 1;
        }
        for (; at < end && is_digit(*at); at++, digits++) {
            if (kept < 19) {
                mantissa = mantissa * 10 + (uint64_t)(*at - '0');
                kept += mantissa != 0;
                exponent--;
            } else {
                kept = 20;
            }
        }
    }
    if (digits == 0)
        return 0;
    if (at < end && (*at == 'e' || *at == 'E')) {
        at++;
        int sign = 1, power = 0, power_digits = 0;
        if (at < end && (*at == '-' || *at == '+'))
            sign = *at++ == '-' ? -1 : 1;
        for (; at < end && is_digit(*at); at++, power_digits++)
            if (power < 10000)
                power = power * 10 + (*at - '0');
        if (power_digits == 0)
            return 0;
        exponent += sign * power;
    }
    if (at < end && !is_blank(*at) && *at != '#')
        return 0;
    *cursor = at;
    if (kept < 20 && mantissa <= ((uint64_t)1 << 53) && exponent >= -22 && exponent <= 22) {
        double magnitude = (double)mantissa;
        magnitude = exponent < 0 ? magnitude / POWERS[-exponent] : magnitude * POWERS[exponent];
        *value = negative ? -magnitude : magnitude;
        return 1;
    }
    char copy[LONGEST_NUMBER + 1];
    size_t length = (size_t)(at - start);
    if (length > LONGEST_NUMBER)
        return 0;
    memcpy(copy, start, length);
    copy[length] = '\0';
    PyEval_RestoreThread(*thread);
    *value = PyOS_string_to_double(copy, NULL, NULL);
    int failed = PyErr_Occurred() != NULL;
    if (failed)
        PyErr_Clear();
    *thread = PyEval_SaveThread();
    return !failed;
}

static int read_index(const char **cursor, const char *end, int64_t *index) {
    const char *at = *cursor;
    int negative = 0, digits = 0;
    int64_t value = 0;
    if (at < end && (*at == '-' || *at == '+'))
        negative = *at++ == '-';
    for (; at < end && is_digit(*at); at++, digits++)
        if (value < INDEX_CAP)
            value = value * 10 + (*at - '0');
    *index = negative ? -value : value;
    *cursor = at;
    return digits > 0;
}

/* 1-based, or negative and relative to what has been read so far, to 0-based; -1 where it is out of range. */
static int64_t resolve(int64_t index, int64_t so_far, int64_t total) {
    int64_t resolved = index > 0 ? index - 1 : index < 0 ? so_far + index : -1;
    return resolved >= 0 && resolved < total ? resolved : -1;
}

struct corner {
    int32_t vertex, uv;
};

struct counts {
    int64_t vertices, uvs, triangles, statements;
};

/* One corner `v`, `v/vt`, `v//vn` or `v/vt/vn`. A missing uv is -1. */
static enum fault read_corner(const char **cursor, const char *end, const struct counts *seen, const struct counts *total,
                              struct corner *corner, int64_t *detail) {
    int64_t vertex, uv, normal;
    if (!read_index(cursor, end, &vertex))
        return FAULT_CORNER;
    int64_t resolved = resolve(vertex, seen->vertices, total->vertices);
    if (resolved < 0) {
        *detail = vertex;
        return FAULT_VERTEX_INDEX;
    }
    corner->vertex = (int32_t)resolved;
    corner->uv = -1;
    const char *at = *cursor;
    if (at < end && *at == '/') {
        at++;
        if (at < end && !is_blank(*at) && *at != '/' && *at != '#') {
            if (!read_index(&at, end, &uv))
                return FAULT_CORNER;
            resolved = resolve(uv, seen->uvs, total->uvs);
            if (resolved < 0) {
                *detail = uv;
                return FAULT_UV_INDEX;
            }
            corner->uv = (int32_t)resolved;
        }
        if (at < end && *at == '/') {
            at++;
            if (at < end && !is_blank(*at) && *at != '#' && !read_index(&at, end, &normal))
                return FAULT_CORNER;
        }
    }
    if (at < end && !is_blank(*at) && *at != '#')
        return FAULT_CORNER;
    *cursor = at;
    return FAULT_NONE;
}

struct target {
    double *vertices, *colors, *uv;
    int32_t *faces, *face_uv, *face_statement;
    int64_t *statements;
    struct counts total, seen;
    int64_t detail;   /* the index that is out of range */
    int32_t material; /* the last usemtl statement, -1 before the first */
};

/* Up to `wanted` numbers into `values`; returns how many, or -1 where something else stands in their place. */
static int read_numbers(const char *at, const char *stop, int wanted, double *values, PyThreadState **thread) {
    int read = 0;
    for (at = skip_blanks(at, stop); read < wanted && !at_end(at, stop); at = skip_blanks(at, stop))
        if (!read_number(&at, stop, &values[read++], thread))
            return -1;
    return read;
}

static enum fault read_vertex(const char *at, const char *stop, struct target *target, PyThreadState **thread) {
    double values[6];
    if (target->seen.vertices >= target->total.vertices)
        return FAULT_LENGTH;
    int read = read_numbers(at, stop, 6, values, thread);
    if (read < 3)
        return FAULT_NUMBER;
    memcpy(target->vertices + 3 * target->seen.vertices, values, 3 * sizeof *values);
    if (read == 6) /* four values are a position and a weight */
        memcpy(target->colors + 3 * target->seen.vertices, values + 3, 3 * sizeof *values);
    target->seen.vertices++;
    return FAULT_NONE;
}

static enum fault read_uv(const char *at, const char *stop, struct target *target, PyThreadState **thread) {
    double values[2] = {0, 0};
    if (target->seen.uvs >= target->total.uvs)
        return FAULT_LENGTH;
    if (read_numbers(at, stop, 2, values, thread) < 1)
        return FAULT_NUMBER;
    memcpy(target->uv + 2 * target->seen.uvs++, values, sizeof values);
    return FAULT_NONE;
}

static enum fault read_face(const char *at, const char *stop, struct target *target) {
    struct corner first = {0, 0}, previous = {0, 0}, corner;
    int64_t corners = 0;
    for (at = skip_blanks(at, stop); !at_end(at, stop); at = skip_blanks(at, stop), corners++, previous = corner) {
        enum fault fault = read_corner(&at, stop, &target->seen, &target->total, &corner, &target->detail);
        if (fault != FAULT_NONE)
            return fault;
        if (corners == 0)
            first = corner;
        if (corners < 2)
            continue;
        int64_t triangle = target->seen.triangles;
        if (triangle >= target->total.triangles)
            return FAULT_LENGTH;
        int32_t *vertices = target->faces + 3 * triangle, *uvs = target->face_uv + 3 * triangle;
        vertices[0] = first.vertex, vertices[1] = previous.vertex, vertices[2] = corner.vertex;
        uvs[0] = first.uv, uvs[1] = previous.uv, uvs[2] = corner.uv;
        target->face_statement[triangle] = target->material;
        target->seen.triangles++;
    }
    return corners < 3 ? FAULT_FEW_CORNERS : FAULT_NONE;
}

static enum fault read_statement(const char *at, const char *begin, const char *stop, struct target *target) {
    int64_t statement = target->seen.statements;
    if (statement >= target->total.statements)
        return FAULT_LENGTH;
    target->statements[2 * statement] = at - begin;
    target->statements[2 * statement + 1] = stop - begin;
    if (*at == 'u')
        target->material = (int32_t)statement;
    target->seen.statements++;
    return FAULT_NONE;
}

static PyObject *obj_read(PyObject *self, PyObject *args) {
    (void)self;
    enum { TEXT, VERTICES, COLORS, UV, FACES, FACE_UV, FACE_STATEMENT, STATEMENTS, COUNT };
    static const char TYPES[] = "Bdddiiil";
    static const char *const NAMES[COUNT] = {"text",  "vertices", "colors",         "uv",
                                             "faces", "face_uv",  "face_statement", "statements"};
    PyObject *objects[COUNT];
    if (!PyArg_ParseTuple(args, "OOOOOOOO", &objects[0], &objects[1], &objects[2], &objects[3], &objects[4], &objects[5],
                          &objects[6], &objects[7]))
        return NULL;
    Py_buffer views[COUNT];
    Py_ssize_t lengths[COUNT] = {-1, -1, -1, -1, -1, -1, -1, -1};
    int held = 0;
    for (; held < COUNT; held++) {
        if (umg_buffer(objects[held], &views[held], TYPES[held], lengths[held], held != TEXT, NAMES[held]) < 0) {
            while (held-- > 0)
                PyBuffer_Release(&views[held]);
            return NULL;
        }
        if (held == VERTICES)
            lengths[COLORS] = views[VERTICES].len / 24 * 3;
        if (held == FACES) {
            lengths[FACE_UV] = views[FACES].len / 12 * 3;
            lengths[FACE_STATEMENT] = views[FACES].len / 12;
        }
    }
    struct target target = {.vertices = views[VERTICES].buf,
                            .colors = views[COLORS].buf,
                            .uv = views[UV].buf,
                            .faces = views[FACES].buf,
                            .face_uv = views[FACE_UV].buf,
                            .face_statement = views[FACE_STATEMENT].buf,
                            .statements = views[STATEMENTS].buf,
                            .total = {views[VERTICES].len / 24, views[UV].len / 16, views[FACES].len / 12,
                                      views[STATEMENTS].len / 16},
                            .material = -1};
    const char *begin = views[TEXT].buf, *at = begin, *end = at + views[TEXT].len;
    enum fault fault = FAULT_NONE;
    long long line = 0;
    PyThreadState *thread = PyEval_SaveThread();
    for (; at < end && fault == FAULT_NONE; line++) {
        const char *stop = line_end(at, end);
        switch (read_keyword(&at, stop)) {
        case KEYWORD_VERTEX:
            fault = read_vertex(at, stop, &target, &thread);
            break;
        case KEYWORD_UV:
            fault = read_uv(at, stop, &target, &thread);
            break;
        case KEYWORD_FACE:
            fault = read_face(at, stop, &target);
            break;
        case KEYWORD_STATEMENT:
            fault = read_statement(at, begin, stop, &target);
            break;
        default:
            break;
        }
        at = stop + 1;
    }
    PyEval_RestoreThread(thread);
    for (int i = 0; i < COUNT; i++)
        PyBuffer_Release(&views[i]);
    return Py_BuildValue("(iLL)", (int)fault, line, (long long)target.detail);
}

PyMethodDef umg_obj_methods[] = {
    {"obj_count", obj_count, METH_VARARGS,
     "obj_count(text) -> (vertices, uvs, triangles, statements): how much room obj_read needs."},
    {"obj_read", obj_read, METH_VARARGS,
     "obj_read(text, vertices, colors, uv, faces, face_uv, face_statement, statements) -> (fault, line, detail): fill the "
     "arrays; polygons become fans; the byte range of every usemtl and mtllib goes to statements."},
    {NULL, NULL, 0, NULL},
};
