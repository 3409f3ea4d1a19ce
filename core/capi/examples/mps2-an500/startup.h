/* What startup.c leaves behind for main. */
#ifndef SHISEN_EXAMPLE_STARTUP_H
#define SHISEN_EXAMPLE_STARTUP_H

#include <stdint.h>

/* What the stack holds where nobody has used it. */
#define STACK_PAINT 0xA5A5A5A5u

#endif
