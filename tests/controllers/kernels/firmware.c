/* A point on a plane. */
typedef struct {
    double x; /* Place, m. */
    double y; /* How far it is, How far it is, How far it is, How far it is,
                 How far it is, How far it is, How far it is, m. */
    double z;
    int64_t number; /* Which one. */
} x_Point;

/* Return a sum. */
static inline double kernel(double x, int64_t n, double *row, double (*t)[2], x_Point p)
{
    (void)row;
    (void)p;
    /* above */
    /* beside */
    double total = 0.0;
    const int new_ = 2;
    (void)new_;
    const double value = total;
    const double value2 = x;
    x = value;
    total = value2;
    const x_real_tuple2 value3 = (x_real_tuple2){{x, 2.0}};
    t[1][0] = value3.at[0];
    t[1][1] = value3.at[1];
    for (int i = 0; i < 3; i++) {
        /* the one */
        if (i == n) {
            continue;
        } else if (x > 1.0) {
            total += (double)i;
        } else {
            break;
        }
    }
    return total;
}
