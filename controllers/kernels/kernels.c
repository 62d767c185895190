#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>
#if defined(__FAST_MATH__)
#error "kernels test for what is not a number: compile them without fast-math"
#endif
#if defined(__clang__)
#pragma STDC FP_CONTRACT OFF
#define KERNEL static inline __attribute__((always_inline))
#define WHOLE
#else
#define KERNEL static inline
#define WHOLE __attribute__((flatten))
#endif
#if defined(_WIN32)
#define PUBLIC __declspec(dllexport)
#else
#define PUBLIC __attribute__((visibility("default")))
#endif

STATIC REAL square(REAL value)
{
    return value * value;
}

STATIC REAL larger(REAL first, REAL second)
{
    return second > first ? second : first;
}

STATIC REAL smaller(REAL first, REAL second)
{
    return second < first ? second : first;
}

STATIC int64_t larger_integer(int64_t first, int64_t second)
{
    return second > first ? second : first;
}

STATIC int64_t smaller_integer(int64_t first, int64_t second)
{
    return second < first ? second : first;
}

STATIC int64_t absolute_integer(int64_t value)
{
    return value < 0 ? (int64_t)(0u - (uint64_t)value) : value;
}

STATIC int64_t floored_rest(int64_t value, int64_t divisor)
{
    if (divisor == 0 || divisor == -1) {
        return 0;
    }
    int64_t rest = value % divisor;
    return rest != 0 && (rest < 0) != (divisor < 0) ? rest + divisor : rest;
}

STATIC int64_t floored_quotient(int64_t value, int64_t divisor)
{
    if (divisor == 0) {
        return 0;
    }
    if (divisor == -1) {
        return (int64_t)(0u - (uint64_t)value);
    }
    return value / divisor - (value % divisor != 0 && (value < 0) != (divisor < 0));
}

/* The integer towards zero, the nearest that there is; zero for what is not a number. */
STATIC int64_t whole_number(REAL value)
{
    if (value >= -9223372036854775808.0 && value < 9223372036854775808.0) {
        return (int64_t)value;
    }
    return value < 0.0 ? INT64_MIN : value > 0.0 ? INT64_MAX : 0;
}

/* An index that counts from the end where it is negative. */
STATIC int64_t from_start(int64_t index, int64_t size)
{
    return index < 0 ? index + size : index;
}
