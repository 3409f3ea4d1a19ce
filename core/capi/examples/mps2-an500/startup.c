/* Startup code, from reset to main: vector table, memory, floating-point unit. */
#include "startup.h"

extern uint32_t data_start[], data_end[], data_load[], bss_start[], bss_end[];
extern uint32_t stack_bottom[], stack_top[];

int main(void);

void reset(void)
{
    /* Full access to coprocessors 10 and 11: the floating-point unit, before
       anything can use it. */
    volatile uint32_t *const cpacr = (uint32_t *)0xE000ED88;
    *cpacr |= 0xFu << 20;
    __asm volatile("dsb\n isb" ::: "memory");

    for (uint32_t *to = data_start, *from = data_load; to < data_end;)
        *to++ = *from++;
    for (uint32_t *to = bss_start; to < bss_end;)
        *to++ = 0;

    uint32_t *used;
    __asm volatile("mov %0, sp" : "=r"(used));
    for (uint32_t *word = stack_bottom; word < used; word++)
        *word = STACK_PAINT;
    main();
    for (;;)
        __asm volatile("wfi");
}

/* Stops at a fault, for a debugger to see. */
static void stop(void)
{
    for (;;)
        __asm volatile("bkpt 0");
}

__attribute__((section(".vectors"), used)) static void (*const vectors[16])(void) = {
    (void (*)(void))stack_top, reset, stop, stop, stop, stop, stop, 0, 0, 0, 0, stop, stop, 0, stop,
    stop,
};
