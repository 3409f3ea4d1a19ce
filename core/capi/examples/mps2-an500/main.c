/* The example on bare metal: a scene and a recorded stream in memory, a report on
   UART0. */
#include "../frame.h"
#include "startup.h"

/* Where the emulator puts the scene and the stream. */
#define SCENE ((const uint8_t *)0x60000000)
#define SCENE_REGION 0x00800000u
#define STREAM ((const uint8_t *)0x60800000)
#define STREAM_REGION 0x00800000u

#define SLICE_BUDGET 500

/* CMSDK APB UART. */
#define UART0_DATA (*(volatile uint32_t *)0x40004000)
#define UART0_STATE (*(volatile uint32_t *)0x40004004)
#define UART0_CTRL (*(volatile uint32_t *)0x40004008)
#define UART0_BAUDDIV (*(volatile uint32_t *)0x40004010)
#define UART_TX_FULL 1u
#define UART_TX_ENABLE 1u

static void put(char character)
{
    while (UART0_STATE & UART_TX_FULL) {
    }
    UART0_DATA = (uint32_t)character;
}

static void put_text(const char *text)
{
    while (*text)
        put(*text++);
}

static void put_number(const char *name, uint32_t value)
{
    char digits[10];
    int count = 0;
    put_text(name);
    do
        digits[count++] = (char)('0' + value % 10);
    while ((value /= 10) != 0);
    while (count > 0)
        put(digits[--count]);
    put('\n');
}

static void put_hash(const char *name, uint64_t value)
{
    put_text(name);
    for (int shift = 60; shift >= 0; shift -= 4)
        put("0123456789abcdef"[value >> shift & 15]);
    put('\n');
}

extern uint32_t stack_bottom[], stack_top[];

/* How much of the stack was ever used: what reset painted and nobody wrote to is
   not. */
static uint32_t stack_used(void)
{
    const uint32_t *word = stack_bottom;
    while (word < stack_top && *word == STACK_PAINT)
        word++;
    return (uint32_t)(stack_top - word) * sizeof *word;
}

static uint32_t tiles_emitted;

void emit(const shisen_tile *tile, const shisen_pixel *pixels)
{
    (void)tile;
    (void)pixels;
    tiles_emitted++;
}

/* Ends the emulator with an exit code: semihosting's SYS_EXIT_EXTENDED. */
static void leave(uint32_t code)
{
    uint32_t reason[2] = {0x20026, code};
    register uint32_t operation __asm("r0") = 0x20;
    register uint32_t *block __asm("r1") = reason;
    __asm volatile("bkpt 0xAB" ::"r"(operation), "r"(block) : "memory");
}

int main(void)
{
    static walls_report report;
    uint64_t dome = 0;
    uint32_t stack;
    shisen_status status;

    UART0_BAUDDIV = 16;
    UART0_CTRL = UART_TX_ENABLE;

    status = render_walls(SCENE, SCENE_REGION, STREAM, STREAM_REGION, SLICE_BUDGET, &report);
    stack = stack_used();
    if (status == SHISEN_STATUS_OK)
        status = render_dome(SCENE, SCENE_REGION, SLICE_BUDGET, &dome);
    if (status != SHISEN_STATUS_OK) {
        put_text(shisen_status_name(status));
        put_text(": ");
        put_text(shisen_status_message(status));
        put('\n');
        leave(1);
        return 1;
    }
    put_number("samples ", (uint32_t)report.tracker.samples);
    put_number("gaze state ", report.gaze.state);
    put_number("tiles ", tiles_emitted);
    put_number("slices ", report.slices);
    put_number("steps ", (uint32_t)report.frame.steps);
    put_hash("frame ", report.hash);
    put_hash("dome ", dome);
    put_number("stack ", stack);
    leave(0);
    return 0;
}
