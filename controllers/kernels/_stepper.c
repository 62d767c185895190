/* Calls of compiled kernels from Python without ctypes: a bound step, and a bound group of steps.
 *
 * A step takes an argument for each input and last further regressors. It gives None, and changes nothing, where an
 * argument is of another kind or value than its rule allows, or regressors are given: what then is to be done or said,
 * Python knows.
 *
 * Limited API of Python 3.11: one binary serves 3.11 and all later versions.
 */
#define Py_LIMITED_API 0x030B0000
#define PY_SSIZE_T_CLEAN
#include <Python.h>
#include <math.h>
#include <stdbool.h>
#include <stdint.h>
#include <string.h>

typedef void (*Step)(void *parameters, void *state, double *row, int64_t count);

typedef struct {
    Step step;
    void *parameters, *state;
} Member;

/* Controllers that are stepped together; `rows` has `width` numbers for each: inputs, then torque and feedforward. */
typedef struct {
    Py_ssize_t members, inputs, width;
    double period, *rows;
    char rules[32];
    Member own[];
} Bound;

/* Return a number, the same for all members, or what stands for none; false where its rule forbids it. */
static bool read_number(const Bound *bound, char rule, PyObject *given, double *value)
{
    if (given == Py_None) {
        *value = rule == 't' ? bound->period : NAN;
        return rule != 'c' && rule != 'm';
    }
    *value = PyFloat_AsDouble(given);
    if (*value == -1.0 && PyErr_Occurred()) {
        PyErr_Clear();
        return false;
    }
    return rule == 'm' || rule == 'u' || (isfinite(*value) && (*value > 0.0 || (rule != 'i' && rule != 't')));
}

static bool allowed(char rule, double value)
{
    return (rule != 'c' && rule != 'i') || (isfinite(value) && (rule == 'c' || value > 0.0));
}

/* Read a column of an array of doubles, one for each member. */
static bool read_array(const Bound *bound, char rule, PyObject *given, double *column)
{
    Py_buffer view;
    if (PyObject_GetBuffer(given, &view, PyBUF_STRIDES | PyBUF_FORMAT) < 0) {
        PyErr_Clear();
        return false;
    }
    bool fits = view.ndim == 1 && view.shape[0] == bound->members && strcmp(view.format, "d") == 0 && rule != 't';
    for (Py_ssize_t i = 0; fits && i < bound->members; i++) {
        double *value = column + i * bound->width;
        memcpy(value, (const char *)view.buf + i * view.strides[0], sizeof *value);
        fits = allowed(rule, *value);
    }
    PyBuffer_Release(&view);
    return fits;
}

static bool read_column(const Bound *bound, char rule, PyObject *given, double *column)
{
    double value;
    if (given != Py_None && !PyFloat_Check(given) && PyObject_CheckBuffer(given)) {
        return read_array(bound, rule, given, column);
    }
    if (!read_number(bound, rule, given, &value)) {
        return false;
    }
    for (Py_ssize_t i = 0; i < bound->members; i++) {
        column[i * bound->width] = value;
    }
    return true;
}

/* Do one sample of all members; false, and nothing changes, where something is not as it must be. */
static bool do_step(Bound *bound, PyObject *const *given, Py_ssize_t count, bool together)
{
    if (count != bound->inputs + 1 || given[bound->inputs] != Py_None) {
        return false;
    }
    for (Py_ssize_t k = 0; k < bound->inputs; k++) {
        if (together ? !read_column(bound, bound->rules[k], given[k], bound->rows + k)
                     : !read_number(bound, bound->rules[k], given[k], bound->rows + k)) {
            return false;
        }
    }
    for (Py_ssize_t i = 0; i < bound->members; i++) {
        const Member *own = bound->own + i;
        own->step(own->parameters, own->state, bound->rows + i * bound->width, bound->width);
    }
    return true;
}

static PyObject *step(PyObject *self, PyObject *const *given, Py_ssize_t count)
{
    Bound *bound = PyCapsule_GetPointer(self, NULL);
    if (!do_step(bound, given, count, false)) {
        Py_RETURN_NONE;
    }
    return PyFloat_FromDouble(bound->rows[bound->inputs]);
}

/* The torques are written into the first item, an array of doubles, which is given back. */
static PyObject *step_all(PyObject *self, PyObject *const *given, Py_ssize_t count)
{
    Bound *bound = PyCapsule_GetPointer(self, NULL);
    Py_buffer view;
    if (count < 1 || !do_step(bound, given + 1, count - 1, true)) {
        Py_RETURN_NONE;
    }
    PyObject *torques = given[0];
    if (PyObject_GetBuffer(torques, &view, PyBUF_CONTIG) < 0) {
        return NULL;
    }
    for (Py_ssize_t i = 0; i < bound->members; i++) {
        ((double *)view.buf)[i] = bound->rows[i * bound->width + bound->inputs];
    }
    PyBuffer_Release(&view);
    Py_INCREF(torques);
    return torques;
}

static PyMethodDef STEP = {"step", (PyCFunction)(void (*)(void))step, METH_FASTCALL,
                           "Do one sample: inputs and regressors in, the torque out, or None."};
static PyMethodDef STEP_ALL = {"step_all", (PyCFunction)(void (*)(void))step_all, METH_FASTCALL,
                               "Do one sample of a group: torques and columns of inputs in, torques out, or None."};

static void free_bound(PyObject *capsule)
{
    PyMem_Free(PyCapsule_GetPointer(capsule, NULL));
}

static PyObject *bind(PyObject *module, PyObject *arguments)
{
    (void)module;
    PyObject *members;
    unsigned long long rows, places[3];
    const char *rules;
    Py_ssize_t width;
    double period;
    int together;
    if (!PyArg_ParseTuple(arguments, "O!Knsdp", &PyTuple_Type, &members, &rows, &width, &rules, &period, &together)) {
        return NULL;
    }
    const Py_ssize_t count = PyTuple_Size(members);
    Bound *bound = PyMem_Malloc(sizeof *bound + (size_t)count * sizeof(Member));
    if (bound == NULL) {
        return PyErr_NoMemory();
    }
    *bound = (Bound){.members = count, .inputs = (Py_ssize_t)strlen(rules), .width = width, .period = period};
    bound->rows = (double *)(uintptr_t)rows;
    strncpy(bound->rules, rules, sizeof bound->rules - 1);
    PyObject *capsule = PyCapsule_New(bound, NULL, free_bound);
    if (capsule == NULL) {
        PyMem_Free(bound);
        return NULL;
    }
    PyObject *function = NULL;
    Py_ssize_t i = 0;
    for (; i < count; i++) {
        PyObject *member = PyTuple_GetItem(members, i);
        if (!PyArg_ParseTuple(member, "KKK", places, places + 1, places + 2)) {
            break;
        }
        bound->own[i] = (Member){(Step)(uintptr_t)places[0], (void *)(uintptr_t)places[1], (void *)(uintptr_t)places[2]};
    }
    if (i == count) {
        function = PyCFunction_NewEx(together ? &STEP_ALL : &STEP, capsule, NULL); /* which keeps the memory alive */
    }
    Py_DECREF(capsule);
    return function;
}

static PyMethodDef METHODS[] = {
    {"bind", bind, METH_VARARGS,
     "Return a step of controllers in memory: bind(((step, parameters, state), ...), address of the rows, numbers in a "
     "row, rules of the inputs, nominal period, whether it is a group)."},
    {NULL, NULL, 0, NULL}};

static struct PyModuleDef_Slot SLOTS[] = {{0, NULL}};

static struct PyModuleDef MODULE = {
    .m_base = PyModuleDef_HEAD_INIT,
    .m_name = "_stepper",
    .m_doc = "Calls of compiled kernels by their addresses.",
    .m_methods = METHODS,
    .m_slots = SLOTS,
};

PyMODINIT_FUNC PyInit__stepper(void)
{
    return PyModuleDef_Init(&MODULE);
}
