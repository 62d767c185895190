/* Steps an exported controller along references of standard input; prints seconds a step and the last torque. */
#include "drive.h"
#include <stdio.h>
#include <stdlib.h>
#include <time.h>
int main(int count, char **arguments)
{
    static drive_Controller controller;
    const int rows = atoi(arguments[count - 1]);
    double *references = malloc((size_t)(rows + 1) * sizeof *references);
    if (references == NULL || fread(references, sizeof *references, (size_t)rows + 1, stdin) == 0) return 1;
    drive_Output output = {0};
    drive_init(&controller);
    const clock_t begin = clock();
    for (int k = 0; k < rows; k++) {
        drive_Inputs inputs = drive_default_inputs();
        inputs.reference = references[k];
        inputs.next_reference = references[k + 1];
        inputs.velocity = 0.97 * references[k];
        if (drive_step(&controller, &inputs, &output) != DRIVE_OK) return 1;
    }
    printf("%.9g %.17g", (double)(clock() - begin) / CLOCKS_PER_SEC / rows, output.torque);
    return 0;
}
