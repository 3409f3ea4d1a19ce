/* A frame of three walls: portable C99, without a library of its own. */
#include "frame.h"

/* Time from the tracker's last byte to the display of the frame. */
#define DISPLAY_DELAY_US 20000

#define TILES (WALLS * SHISEN_TILES(WALL_SIDE, WALL_SIDE, TILE_SIDE))

/* All state of the renderer and the tracker. */
static uint64_t scene_memory[(SHISEN_SCENE_SIZE + 7) / 8];
static uint64_t tracker_memory[(SHISEN_TRACKER_SIZE + 7) / 8];
static uint64_t frame_memory[(SHISEN_FRAME_BYTES(WALLS, TILES) + 7) / 8];
static shisen_pixel tile_pixels[TILE_SIDE * TILE_SIDE];

/* The pictures; a display controller would send each tile away instead. */
static shisen_pixel walls[WALLS][WALL_SIDE][WALL_SIDE];

static uint64_t number(const uint8_t *bytes, size_t count)
{
    uint64_t value = 0;
    while (count-- > 0)
        value = value << 8 | bytes[count];
    return value;
}

/* Feeds a recorded stream in pieces; stores the arrival of its last byte. */
static shisen_status feed(shisen_tracker *tracker, const uint8_t *stream, size_t length,
                          uint64_t *last_us)
{
    while (length >= 12) {
        uint64_t arrival_us = number(stream, 8);
        size_t piece = (size_t)number(stream + 8, 4);
        shisen_status status;
        stream += 12;
        length -= 12;
        if (piece == 0 || piece > length)
            break;
        status = shisen_tracker_feed(tracker, stream, piece, arrival_us);
        if (status != SHISEN_STATUS_OK)
            return status;
        *last_us = arrival_us;
        stream += piece;
        length -= piece;
    }
    return SHISEN_STATUS_OK;
}

/* The front, the left and the right wall of a cube of 3 m around the origin, each
   seen from inside. */
static shisen_status place_walls(shisen_screen screens[WALLS])
{
    /* Lower left, lower right, upper left. */
    static const float corners[WALLS][3][3] = {
        {{-1.5f, -1.5f, -1.5f}, {1.5f, -1.5f, -1.5f}, {-1.5f, 1.5f, -1.5f}},
        {{-1.5f, -1.5f, 1.5f}, {-1.5f, -1.5f, -1.5f}, {-1.5f, 1.5f, 1.5f}},
        {{1.5f, -1.5f, -1.5f}, {1.5f, -1.5f, 1.5f}, {1.5f, 1.5f, -1.5f}},
    };
    shisen_status status = SHISEN_STATUS_OK;
    for (int wall = 0; wall < WALLS && status == SHISEN_STATUS_OK; wall++)
        status = shisen_screen_from_corners(corners[wall][0], corners[wall][1], corners[wall][2],
                                            WALL_SIDE, WALL_SIDE, &screens[wall]);
    return status;
}

static uint64_t fnv1a(uint64_t hash, const shisen_pixel *pixels, size_t count)
{
    const uint8_t *bytes = (const uint8_t *)pixels;
    for (size_t byte = 0; byte < count * sizeof *pixels; byte++)
        hash = (hash ^ bytes[byte]) * 0x100000001b3u;
    return hash;
}

#define FNV_START 0xcbf29ce484222325u

/* Renders a frame that was begun into pictures of side * side pixels. */
static shisen_status render(shisen_frame *frame, uint64_t slice_budget, shisen_pixel *pictures,
                            size_t side, uint32_t *slices)
{
    shisen_tile tile;
    for (;;) {
        shisen_status status = shisen_frame_render(frame, slice_budget, tile_pixels,
                                                   TILE_SIDE * TILE_SIDE, &tile);
        *slices += 1;
        switch (status) {
        case SHISEN_STATUS_BUDGET_SPENT:
            break; /* A firmware can do other work here. */
        case SHISEN_STATUS_TILE:
            emit(&tile, tile_pixels);
            for (uint32_t row = 0; row < tile.rows; row++)
                for (uint32_t column = 0; column < tile.columns; column++)
                    pictures[(tile.picture * side + tile.y + row) * side + tile.x + column] =
                        tile_pixels[row * tile.columns + column];
            break;
        case SHISEN_STATUS_FINISHED:
            return SHISEN_STATUS_OK;
        default:
            return status;
        }
    }
}

shisen_status render_walls(const uint8_t *scene_blob, size_t scene_length, const uint8_t *stream,
                           size_t stream_length, uint64_t slice_budget, walls_report *report)
{
    shisen_scene *scene;
    shisen_tracker *tracker;
    shisen_tracker_settings tracker_settings;
    shisen_frame *frame;
    shisen_frame_settings settings;
    shisen_screen screens[WALLS];
    uint64_t last_us = 0;
    shisen_status status;

    status = shisen_scene_open(scene_memory, sizeof scene_memory, scene_blob, scene_length, &scene,
                               &report->fault);
    if (status != SHISEN_STATUS_OK)
        return status;

    shisen_tracker_settings_init(&tracker_settings, SHISEN_PROTOCOL_LINK);
    status = shisen_tracker_init(tracker_memory, sizeof tracker_memory, &tracker_settings, &tracker);
    if (status == SHISEN_STATUS_OK)
        status = feed(tracker, stream, stream_length, &last_us);
    if (status == SHISEN_STATUS_OK)
        status = shisen_tracker_count(tracker, &report->tracker);
    if (status == SHISEN_STATUS_OK)
        status = shisen_tracker_gaze(tracker, last_us + DISPLAY_DELAY_US, &report->gaze);
    if (status == SHISEN_STATUS_OK)
        status = place_walls(screens);
    if (status != SHISEN_STATUS_OK)
        return status;

    shisen_frame_settings_init(&settings);
    settings.tile_side = TILE_SIDE;
    status = shisen_frame_begin(frame_memory, sizeof frame_memory, scene, &settings, screens, WALLS,
                                report->gaze.position, &report->gaze, &frame);
    if (status == SHISEN_STATUS_OK)
        status = render(frame, slice_budget, walls[0][0], WALL_SIDE, &report->slices);
    if (status == SHISEN_STATUS_OK)
        status = shisen_frame_count(frame, &report->frame);
    report->hash = fnv1a(FNV_START, walls[0][0], WALLS * WALL_SIDE * WALL_SIDE);
    return status;
}

shisen_status render_dome(const uint8_t *scene_blob, size_t scene_length, uint64_t slice_budget,
                          uint64_t *hash)
{
    static const float centre[3] = {0.0f, 0.0f, 0.0f};
    shisen_scene *scene;
    shisen_dome dome;
    shisen_frame *frame;
    shisen_frame_settings settings;
    uint32_t slices = 0;
    shisen_status status;

    shisen_dome_init(&dome, centre, DOME_SIDE);
    shisen_frame_settings_init(&settings);
    settings.tile_side = TILE_SIDE;
    status = shisen_scene_open(scene_memory, sizeof scene_memory, scene_blob, scene_length, &scene,
                               NULL);
    if (status == SHISEN_STATUS_OK)
        status = shisen_frame_begin_dome(frame_memory, sizeof frame_memory, scene, &settings, &dome,
                                         &frame);
    if (status == SHISEN_STATUS_OK)
        status = render(frame, slice_budget, walls[0][0], DOME_SIDE, &slices);
    *hash = fnv1a(FNV_START, walls[0][0], DOME_SIDE * DOME_SIDE);
    return status;
}
