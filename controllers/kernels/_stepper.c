/* Calls of compiled kernels from Python without ctypes: a bound step, a bound group of steps, any entry point.
 *
 * Limited API of Python 3.11: one binary serves 3.11 and all later versions.
 */
#define Py_LIMITED_API 0x030B0000
#define PY_SSIZE_T_CLEAN
#include <Python.h>
#include <stdint.h>

typedef void (*Step)(void *parameters, void *state, double *row, int64_t count);
typedef void (*Entry)(const void *arguments, void *result);

typedef struct {
    Step step;
    void *parameters, *state;
    double *row;
    Py_ssize_t inputs, count, output;
} Bound;

static int read_addresses(PyObject *const *arguments, Py_ssize_t count, Py_ssize_t expected, void **places)
{
    if (count != expected) {
        PyErr_Format(PyExc_TypeError, "%zd integers are needed, %zd were given", expected, count);
        return -1;
    }
    for (Py_ssize_t i = 0; i < count; i++) {
        places[i] = PyLong_AsVoidPtr(arguments[i]);
        if (PyErr_Occurred()) {
            return -1;
        }
    }
    return 0;
}

static void free_memory(PyObject *capsule)
{
    PyMem_Free(PyCapsule_GetPointer(capsule, NULL));
}

static PyObject *step(PyObject *self, PyObject *const *arguments, Py_ssize_t count)
{
    const Bound *bound = PyCapsule_GetPointer(self, NULL);
    if (count != bound->inputs) {
        PyErr_Format(PyExc_TypeError, "a step takes %zd numbers, %zd were given", bound->inputs, count);
        return NULL;
    }
    for (Py_ssize_t i = 0; i < count; i++) {
        const double value = PyFloat_AsDouble(arguments[i]);
        if (value == -1.0 && PyErr_Occurred()) {
            return NULL;
        }
        bound->row[i] = value;
    }
    bound->step(bound->parameters, bound->state, bound->row, bound->count);
    return PyFloat_FromDouble(bound->row[bound->output]);
}

static PyMethodDef STEP = {
    "step", (PyCFunction)(void (*)(void))step, METH_FASTCALL, "Do one sample: inputs in, output out."};

static PyObject *bind(PyObject *module, PyObject *const *arguments, Py_ssize_t count)
{
    (void)module;
    void *places[7];
    if (read_addresses(arguments, count, 7, places) < 0) {
        return NULL;
    }
    Bound *bound = PyMem_Malloc(sizeof *bound);
    if (bound == NULL) {
        return PyErr_NoMemory();
    }
    *bound = (Bound){(Step)(uintptr_t)places[0], places[1], places[2], places[3], (Py_ssize_t)(intptr_t)places[4],
                     (Py_ssize_t)(intptr_t)places[5], (Py_ssize_t)(intptr_t)places[6]};
    PyObject *capsule = PyCapsule_New(bound, NULL, free_memory);
    if (capsule == NULL) {
        PyMem_Free(bound);
        return NULL;
    }
    PyObject *function = PyCFunction_NewEx(&STEP, capsule, NULL); /* which keeps the memory alive */
    Py_DECREF(capsule);
    return function;
}

static PyObject *step_all(PyObject *module, PyObject *const *arguments, Py_ssize_t count)
{
    (void)module;
    void *places[4];
    if (read_addresses(arguments, count, 4, places) < 0) {
        return NULL;
    }
    const int64_t *own = places[0]; /* step, parameters and state of each member */
    const Py_ssize_t members = (Py_ssize_t)(intptr_t)places[2], width = (Py_ssize_t)(intptr_t)places[3];
    double *row = places[1];
    for (Py_ssize_t i = 0; i < members; i++, own += 3, row += width) {
        ((Step)(uintptr_t)own[0])((void *)(intptr_t)own[1], (void *)(intptr_t)own[2], row, width);
    }
    Py_RETURN_NONE;
}

static PyObject *run(PyObject *module, PyObject *const *arguments, Py_ssize_t count)
{
    (void)module;
    void *places[3];
    if (read_addresses(arguments, count, 3, places) < 0) {
        return NULL;
    }
    const Entry entry = (Entry)(uintptr_t)places[0];
    Py_BEGIN_ALLOW_THREADS
    entry(places[1], places[2]);
    Py_END_ALLOW_THREADS
    Py_RETURN_NONE;
}

static PyMethodDef METHODS[] = {
    {"bind", (PyCFunction)(void (*)(void))bind, METH_FASTCALL,
     "Return a step of a controller in memory: bind(step, parameters, state, row, inputs, numbers in the row, output)."},
    {"step_all", (PyCFunction)(void (*)(void))step_all, METH_FASTCALL,
     "Do one sample of all members of a group: step_all(addresses, rows, members, numbers in a row)."},
    {"run", (PyCFunction)(void (*)(void))run, METH_FASTCALL,
     "Call an entry point, run(entry, arguments, result), while other threads go on."},
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
