/* A frame of three walls, from a baked scene and what a tracker sent. */
#ifndef SHISEN_EXAMPLE_FRAME_H
#define SHISEN_EXAMPLE_FRAME_H

#include "shisen.h"

/* Pixels a side of a wall. */
#define WALL_SIDE 64
/* Pixels a side of a tile. */
#define TILE_SIDE 16
#define WALLS 3

/* A finished tile: its pixels, row by row from the top. The example's user
   writes this function: it sends them to a display. */
void emit(const shisen_tile *tile, const shisen_pixel *pixels);

/* What render_walls found. */
typedef struct walls_report {
    /* FNV-1a, 64 bits, of the bytes of all pixels, by wall, row and column. */
    uint64_t hash;
    /* Where the viewer looked. */
    shisen_gaze gaze;
    shisen_tracker_counts tracker;
    shisen_frame_counts frame;
    /* Calls of shisen_frame_render. */
    uint32_t slices;
    /* What is wrong with a scene that was refused. */
    shisen_scene_fault fault;
} walls_report;

/* Opens a scene, feeds a recorded stream, and renders what the viewer sees on the
   front, the left and the right wall of a cube of 3 m, in slices of
   slice_budget steps.

   The stream is one piece after another: the time of arrival (8 bytes,
   microseconds), the length (4 bytes), the bytes; numbers little-endian. A piece
   of length 0 is its end. */
shisen_status render_walls(const uint8_t *scene_blob, size_t scene_length, const uint8_t *stream,
                           size_t stream_length, uint64_t slice_budget, walls_report *report);

/* The dome master of the same scene, DOME_SIDE pixels a side, from the cube's
   centre; its pixels go to emit, and hash is as above. */
#define DOME_SIDE 64
shisen_status render_dome(const uint8_t *scene_blob, size_t scene_length, uint64_t slice_budget,
                          uint64_t *hash);

#endif
