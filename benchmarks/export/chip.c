/* Steps an exported controller and prints the most instructions of a step and the bytes of its stack. */
#include "drive.h"
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
static drive_Controller controller;
#ifdef __riscv
#define BOTTOM ((uint8_t *)0x80300000)
#define STACK(top) __asm volatile("mv %0, sp" : "=r"(top))
#define MASK 0xFFFFFFFFu
#define EACH 1u
static uint32_t count(void)
{
    uint32_t read;
    __asm volatile("csrr %0, minstret" : "=r"(read));
    return read;
}
#else
#define REGISTER(place) (*(volatile uint32_t *)(place))
#define BOTTOM ((uint8_t *)0x20200000)
#define STACK(top) __asm volatile("mov %0, sp" : "=r"(top))
#define MASK 0xFFFFFFu
#define EACH 40u
static uint32_t count(void) { return 0u - REGISTER(0xE000E018); }
int main(void);
void reset(void)
{
    REGISTER(0xE000ED88) |= 0xFu << 20;
    __asm volatile("dsb\n isb");
    REGISTER(0xE000E014) = MASK;
    REGISTER(0xE000E018) = 0u;
    REGISTER(0xE000E010) = 5u;
    extern void initialise_monitor_handles(void);
    initialise_monitor_handles();
    exit(main());
}
__attribute__((section(".vectors"), used)) static void *const vectors[] = {(void *)0x20300000, (void *)reset};
#endif
int main(void)
{
    uint32_t most = 0, here = 0;
    uint8_t *top, *low = BOTTOM;
    STACK(top);
    drive_init(&controller);
    while (low < top - 128) *low++ = 0xA5u; /* below what the loop itself takes */
    for (uint32_t k = 0; k < STEPS; k++) {
        drive_Inputs inputs = drive_default_inputs();
        drive_Output output;
        inputs.reference = (REAL)(0.3 * sin(0.02 * k));
        inputs.next_reference = (REAL)(0.3 * sin(0.02 * (k + 1)));
        inputs.velocity = (REAL)(0.29 * sin(0.02 * k - 0.05));
        here = count();
        if (drive_step(&controller, &inputs, &output) != DRIVE_OK) return 1;
        here = (count() - here) & MASK;
        if (here > most) most = here;
    }
    for (low = BOTTOM; *low == 0xA5u;) low++;
    printf("%u %u\n", (unsigned)(EACH * most), (unsigned)(top - low));
    return 0;
}
