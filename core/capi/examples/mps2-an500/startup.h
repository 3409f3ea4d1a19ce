/* The stack's fill pattern, which startup.c writes and main looks for. */
#ifndef SHISEN_EXAMPLE_STARTUP_H
#define SHISEN_EXAMPLE_STARTUP_H

#include <stdint.h>

/* Fill pattern of unused stack. */
#define STACK_PAINT 0xA5A5A5A5u

#endif
