/* What the C library says of arguments that are wrong: bad SCENE. Each line of
   `check` is one promise of the header. */
#include "shisen.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static int checks, failures;

static void check(const char *what, shisen_status found, shisen_status expected)
{
    checks++;
    if (found == expected)
        return;
    failures++;
    printf("%s: %s instead of %s\n", what, shisen_status_name(found), shisen_status_name(expected));
}

static void check_that(const char *what, int holds)
{
    checks++;
    if (holds)
        return;
    failures++;
    printf("%s: not so\n", what);
}

#define TILES SHISEN_TILES(32, 32, 16)

static uint64_t scene_memory[(SHISEN_SCENE_SIZE + 7) / 8];
static uint64_t tracker_memory[(SHISEN_TRACKER_SIZE + 7) / 8];
static uint64_t setup_memory[(SHISEN_SETUP_SIZE + 7) / 8];
static uint64_t frame_memory[(SHISEN_FRAME_BYTES(2, 2 * TILES) + 7) / 8];
static shisen_pixel pixels[256];

/* An address that is 4 bytes past a multiple of 8. */
static void *odd(void *memory)
{
    return (char *)memory + 4;
}

static void check_sizes(void)
{
    check_that("alignment", shisen_alignment() == SHISEN_ALIGNMENT);
    check_that("size of a scene", shisen_scene_size() == SHISEN_SCENE_SIZE);
    check_that("size of a tracker", shisen_tracker_size() == SHISEN_TRACKER_SIZE);
    check_that("size of a set-up", shisen_setup_size() == SHISEN_SETUP_SIZE);
    check_that("size of a frame", shisen_frame_size(2, 7) == SHISEN_FRAME_BYTES(2, 7));
    check_that("size of too much", shisen_frame_size(SIZE_MAX, SIZE_MAX) == SIZE_MAX);
    check_that("tiles", shisen_tiles(33, 16, 16) == 3 && SHISEN_TILES(33, 16, 16) == 3);
    check_that("status without a name",
               strcmp(shisen_status_name(12345), "SHISEN_STATUS_?") == 0);
    check_that("message", strlen(shisen_status_message(SHISEN_STATUS_GAZE)) > 10);
}

/* A copy of the scene, which is changed and put back. */
static void check_scenes(uint8_t *blob, size_t length)
{
    shisen_scene *scene = (shisen_scene *)blob;
    shisen_scene_fault fault;
    shisen_scene_facts facts;
    size_t size = sizeof scene_memory;

    check("no memory", shisen_scene_open(NULL, size, blob, length, &scene, &fault),
          SHISEN_STATUS_NULL_POINTER);
    check_that("no scene after a failure", scene == NULL);
    check("odd memory", shisen_scene_open(odd(scene_memory), size, blob, length, &scene, NULL),
          SHISEN_STATUS_MISALIGNED);
    check("little memory",
          shisen_scene_open(scene_memory, SHISEN_SCENE_SIZE - 1, blob, length, &scene, NULL),
          SHISEN_STATUS_MEMORY_TOO_SMALL);
    check("no blob", shisen_scene_open(scene_memory, size, NULL, 0, &scene, NULL),
          SHISEN_STATUS_NULL_POINTER);
    check("no blob of a length", shisen_scene_open(scene_memory, size, NULL, length, &scene, NULL),
          SHISEN_STATUS_NULL_POINTER);
    check("blob of all memory", shisen_scene_open(scene_memory, size, blob, SIZE_MAX, &scene, NULL),
          SHISEN_STATUS_TOO_LONG);
    check("no place for the scene", shisen_scene_open(scene_memory, size, blob, length, NULL, NULL),
          SHISEN_STATUS_NULL_POINTER);
    check("blob of no bytes", shisen_scene_open(scene_memory, size, blob, 0, &scene, &fault),
          SHISEN_STATUS_SCENE_CUT_OFF);
    blob[0] ^= 1;
    check("other bytes", shisen_scene_open(scene_memory, size, blob, length, &scene, &fault),
          SHISEN_STATUS_NOT_A_SCENE);
    blob[0] ^= 1;

    check("half a blob", shisen_scene_open(scene_memory, size, blob, length / 2, &scene, &fault),
          SHISEN_STATUS_SCENE_CUT_OFF);
    check_that("half a blob's fault",
               fault.status == SHISEN_STATUS_SCENE_CUT_OFF && fault.number == length);
    for (size_t cut = 8; cut < length; cut += 1 + length / 97)
        check("cut-off blob", shisen_scene_open(scene_memory, size, blob, cut, &scene, NULL),
              SHISEN_STATUS_SCENE_CUT_OFF);

    for (size_t place = 0; place < length; place += 1 + length / 97) {
        shisen_status found;
        blob[place] ^= 0x40;
        found = shisen_scene_open(scene_memory, size, blob, length, &scene, &fault);
        check_that("a flipped bit is found",
                   found >= SHISEN_STATUS_SCENE_CUT_OFF && found <= SHISEN_STATUS_SCENE_OTHER &&
                       fault.status == found && scene == NULL);
        blob[place] ^= 0x40;
    }
    blob[length / 2] ^= 1;
    check("flipped byte", shisen_scene_open(scene_memory, size, blob, length, &scene, &fault),
          SHISEN_STATUS_SCENE_CHECKSUM);
    blob[length / 2] ^= 1;

    memmove(blob + 4, blob, length);
    check("blob at an odd place",
          shisen_scene_open(scene_memory, size, blob + 4, length, &scene, &fault),
          SHISEN_STATUS_SCENE_MISALIGNED);
    check_that("its alignment", fault.number == SHISEN_BLOB_ALIGNMENT);
    memmove(blob, blob + 4, length);

    check("whole blob", shisen_scene_open(scene_memory, size, blob, length, &scene, &fault),
          SHISEN_STATUS_OK);
    check("no scene to describe", shisen_scene_describe(NULL, &facts), SHISEN_STATUS_NULL_POINTER);
    check("no place for facts", shisen_scene_describe(scene, NULL), SHISEN_STATUS_NULL_POINTER);
    check("facts", shisen_scene_describe(scene, &facts), SHISEN_STATUS_OK);
    check_that("scene A's facts", facts.byte_length == length && facts.objects > 0 &&
                                      facts.lights > 0 &&
                                      (facts.effects & ~shisen_effects()) == 0);
}

static uint32_t noise(uint32_t *state)
{
    *state = *state * 1664525 + 1013904223;
    return *state >> 24;
}

static void check_trackers(void)
{
    shisen_tracker *tracker;
    shisen_tracker_settings settings;
    shisen_tracker_counts counts;
    shisen_gaze gaze;
    shisen_setup setup;
    uint8_t bytes[SHISEN_MOST_COMMAND_BYTES];
    uint32_t state = 1;
    size_t size = sizeof tracker_memory;

    check("no settings", shisen_tracker_settings_init(NULL, SHISEN_PROTOCOL_LINK),
          SHISEN_STATUS_NULL_POINTER);
    check("no such protocol", shisen_tracker_settings_init(&settings, 99),
          SHISEN_STATUS_UNKNOWN_CHOICE);
    check("settings", shisen_tracker_settings_init(&settings, SHISEN_PROTOCOL_LINK),
          SHISEN_STATUS_OK);
    check("no memory", shisen_tracker_init(NULL, size, &settings, &tracker),
          SHISEN_STATUS_NULL_POINTER);
    check("odd memory", shisen_tracker_init(odd(tracker_memory), size, &settings, &tracker),
          SHISEN_STATUS_MISALIGNED);
    check("little memory",
          shisen_tracker_init(tracker_memory, SHISEN_TRACKER_SIZE / 2, &settings, &tracker),
          SHISEN_STATUS_MEMORY_TOO_SMALL);
    check("no settings", shisen_tracker_init(tracker_memory, size, NULL, &tracker),
          SHISEN_STATUS_NULL_POINTER);
    check("no tracker", shisen_tracker_init(tracker_memory, size, &settings, NULL),
          SHISEN_STATUS_NULL_POINTER);
    settings.protocol = 99;
    check("no such protocol", shisen_tracker_init(tracker_memory, size, &settings, &tracker),
          SHISEN_STATUS_UNKNOWN_CHOICE);
    settings.protocol = SHISEN_PROTOCOL_FLOCK;
    check("protocol not built", shisen_tracker_init(tracker_memory, size, &settings, &tracker),
          SHISEN_STATUS_NOT_BUILT);
    settings.protocol = SHISEN_PROTOCOL_LINK;
    settings.eyes = 4;
    check("no such eye", shisen_tracker_init(tracker_memory, size, &settings, &tracker),
          SHISEN_STATUS_UNKNOWN_CHOICE);
    settings.eyes = SHISEN_EYE_CHOICE_COMBINED;
    settings.orientation[3] = 0.5f;
    check("no rotation", shisen_tracker_init(tracker_memory, size, &settings, &tracker),
          SHISEN_STATUS_TRACKER_SETTINGS);
    settings.orientation[3] = 1.0f;
    settings.position[1] = NAN;
    check("place not finite", shisen_tracker_init(tracker_memory, size, &settings, &tracker),
          SHISEN_STATUS_TRACKER_SETTINGS);
    settings.position[1] = 0.0f;
    settings.least_delay_us = 2000000;
    check("long delay", shisen_tracker_init(tracker_memory, size, &settings, &tracker),
          SHISEN_STATUS_TRACKER_SETTINGS);
    settings.least_delay_us = 0;
    settings.hertz = 70000;
    check("many hertz", shisen_tracker_init(tracker_memory, size, &settings, &tracker),
          SHISEN_STATUS_TRACKER_SETTINGS);
    settings.hertz = 120;
    check("tracker", shisen_tracker_init(tracker_memory, size, &settings, &tracker),
          SHISEN_STATUS_OK);
    /* Memory anywhere: a tracker wants 16 on some machines. */
    check("tracker elsewhere",
          shisen_tracker_init(tracker_memory, SHISEN_TRACKER_SIZE, &settings, &tracker),
          SHISEN_STATUS_OK);

    check("feed to none", shisen_tracker_feed(NULL, bytes, 1, 0), SHISEN_STATUS_NULL_POINTER);
    check("feed from nowhere", shisen_tracker_feed(tracker, NULL, 1, 0),
          SHISEN_STATUS_NULL_POINTER);
    check("feed nothing", shisen_tracker_feed(tracker, NULL, 0, 0), SHISEN_STATUS_OK);
    check("feed too much", shisen_tracker_feed(tracker, bytes, SIZE_MAX, 0),
          SHISEN_STATUS_TOO_LONG);
    for (int piece = 0; piece < 2000; piece++) {
        for (size_t byte = 0; byte < sizeof bytes; byte++)
            bytes[byte] = (uint8_t)noise(&state);
        check("noise", shisen_tracker_feed(tracker, bytes, sizeof bytes, (uint64_t)piece * 1000),
              SHISEN_STATUS_OK);
    }
    check("count of none", shisen_tracker_count(NULL, &counts), SHISEN_STATUS_NULL_POINTER);
    check("counts", shisen_tracker_count(tracker, &counts), SHISEN_STATUS_OK);
    check_that("noise is counted and dropped",
               counts.bytes == 2000 * sizeof bytes && counts.samples == 0 &&
                   counts.dropped_bytes > counts.bytes / 2);
    check("resync", shisen_tracker_resync(tracker), SHISEN_STATUS_OK);
    check("resync of none", shisen_tracker_resync(NULL), SHISEN_STATUS_NULL_POINTER);

    check("gaze of none", shisen_tracker_gaze(NULL, 0, &gaze), SHISEN_STATUS_NULL_POINTER);
    check("no place for a gaze", shisen_tracker_gaze(tracker, 0, NULL),
          SHISEN_STATUS_NULL_POINTER);
    check("gaze after noise", shisen_tracker_gaze(tracker, 3000000, &gaze), SHISEN_STATUS_OK);
    check_that("nothing is known",
               gaze.state == SHISEN_GAZE_STATE_FULL_QUALITY && gaze.age_us == SHISEN_NEVER);
    check("gaze at the end of time", shisen_tracker_gaze(tracker, UINT64_MAX, &gaze),
          SHISEN_STATUS_OK);

    check("poll without a set-up", shisen_tracker_poll(tracker, 0, bytes, sizeof bytes, &setup),
          SHISEN_STATUS_OK);
    check_that("nothing to be done", setup.action == SHISEN_SETUP_ACTION_DONE);
    check("set up in no memory", shisen_tracker_set_up(tracker, NULL, sizeof setup_memory, 0),
          SHISEN_STATUS_NULL_POINTER);
    check("set up in little memory", shisen_tracker_set_up(tracker, setup_memory, 64, 0),
          SHISEN_STATUS_MEMORY_TOO_SMALL);
    check("set up", shisen_tracker_set_up(tracker, setup_memory, sizeof setup_memory, 0),
          SHISEN_STATUS_OK);
    check("poll into little memory", shisen_tracker_poll(tracker, 0, bytes, 8, &setup),
          SHISEN_STATUS_MEMORY_TOO_SMALL);
    check("poll", shisen_tracker_poll(tracker, 0, bytes, sizeof bytes, &setup), SHISEN_STATUS_OK);
    check_that("commands", setup.action == SHISEN_SETUP_ACTION_SEND && setup.length > 4);
    for (uint64_t now = 0; setup.action != SHISEN_SETUP_ACTION_DONE && now < 100; now++) {
        shisen_status found =
            shisen_tracker_poll(tracker, now * 100000, bytes, sizeof bytes, &setup);
        if (found == SHISEN_STATUS_OK && setup.action != SHISEN_SETUP_ACTION_DONE)
            continue;
        check("a device that says nothing", found, SHISEN_STATUS_DEVICE_SILENT);
        break;
    }
}

static void check_screens(void)
{
    static const float lower_left[3] = {-1.5f, -1.5f, -1.5f};
    static const float lower_right[3] = {1.5f, -1.5f, -1.5f};
    static const float upper_left[3] = {-1.5f, 1.5f, -1.5f};
    static const float behind[3] = {0.0f, 0.0f, -1.6f};
    static const float eye[3] = {0.0f, 0.0f, 0.0f};
    shisen_screen screen;

    check("no corner", shisen_screen_from_corners(NULL, lower_right, upper_left, 8, 8, &screen),
          SHISEN_STATUS_NULL_POINTER);
    check("no columns",
          shisen_screen_from_corners(lower_left, lower_right, upper_left, 0, 8, &screen),
          SHISEN_STATUS_PICTURE_SIZE);
    check("screen",
          shisen_screen_from_corners(lower_left, lower_right, upper_left, 8, 8, &screen),
          SHISEN_STATUS_OK);
    check("seen", shisen_screen_check(&screen, eye), SHISEN_STATUS_OK);
    check("from behind", shisen_screen_check(&screen, behind), SHISEN_STATUS_EYE_BEHIND_SCREEN);
    check("seen by none", shisen_screen_check(&screen, NULL), SHISEN_STATUS_NULL_POINTER);
    screen.columns = 100000;
    check("too many columns", shisen_screen_check(&screen, eye), SHISEN_STATUS_PICTURE_SIZE);
}

static void check_frames(const uint8_t *blob, size_t length)
{
    static const float eye[3] = {0.0f, 0.0f, 0.0f};
    static const float not_finite[3] = {NAN, 0.0f, 0.0f};
    static const float behind[3] = {0.0f, 0.0f, -2.0f};
    static const shisen_screen wall = {
        {-1.4f, 1.4f, -1.5f}, {0.09f, 0.0f, 0.0f}, {0.0f, -0.09f, 0.0f}, 32, 32};
    shisen_screen walls[2] = {wall, wall};
    shisen_gaze gaze = {{0.0f, 0.0f, 0.0f}, {0.0f, 0.0f, -1.0f}, {0.0f, 1.0f, 0.0f}, 0, 0, 0, 0};
    shisen_frame_settings settings;
    shisen_frame_counts counts;
    shisen_scene *scene;
    shisen_frame *frame;
    shisen_spectrum *spectrum;
    shisen_dome dome;
    shisen_tile tile;
    size_t size = sizeof frame_memory;
    shisen_status status;
    uint32_t tiles = 0;

    check("scene",
          shisen_scene_open(scene_memory, sizeof scene_memory, blob, length, &scene, NULL),
          SHISEN_STATUS_OK);
    check("settings", shisen_frame_settings_init(&settings), SHISEN_STATUS_OK);

#define BEGIN(memory, size, scene, count, eye, gaze)                                               \
    shisen_frame_begin(memory, size, scene, &settings, walls, count, eye, gaze, &frame)
    check("no memory", BEGIN(NULL, size, scene, 2, eye, NULL), SHISEN_STATUS_NULL_POINTER);
    check("odd memory", BEGIN(odd(frame_memory), size, scene, 2, eye, NULL),
          SHISEN_STATUS_MISALIGNED);
    check("little memory", BEGIN(frame_memory, SHISEN_FRAME_SIZE, scene, 2, eye, NULL),
          SHISEN_STATUS_MEMORY_TOO_SMALL);
    check("room for one tile less",
          BEGIN(frame_memory, SHISEN_FRAME_BYTES(2, 2 * TILES - 1), scene, 2, eye, NULL),
          SHISEN_STATUS_MEMORY_TOO_SMALL);
    check("no scene", BEGIN(frame_memory, size, NULL, 2, eye, NULL), SHISEN_STATUS_NULL_POINTER);
    check("no screens", BEGIN(frame_memory, size, scene, 0, eye, NULL), SHISEN_STATUS_PICTURES);
    check("no eye", BEGIN(frame_memory, size, scene, 2, NULL, NULL), SHISEN_STATUS_NULL_POINTER);
    check("eye not finite", BEGIN(frame_memory, size, scene, 2, not_finite, NULL),
          SHISEN_STATUS_EYE_BEHIND_SCREEN);
    check("eye behind a wall", BEGIN(frame_memory, size, scene, 2, behind, NULL),
          SHISEN_STATUS_EYE_BEHIND_SCREEN);
    check_that("no frame after a failure", frame == NULL);
    gaze.forward[1] = NAN;
    check("gaze not finite", BEGIN(frame_memory, size, scene, 2, eye, &gaze), SHISEN_STATUS_GAZE);
    gaze.forward[1] = 0.0f;
    gaze.up[1] = 0.0f;
    check("no up", BEGIN(frame_memory, size, scene, 2, eye, &gaze), SHISEN_STATUS_GAZE);
    gaze.up[1] = 1.0f;
    check("eye of a gaze not finite", BEGIN(frame_memory, size, scene, 2, not_finite, &gaze),
          SHISEN_STATUS_EYE);
    settings.tile_side = 0;
    check("tiles of nothing", BEGIN(frame_memory, size, scene, 2, eye, NULL),
          SHISEN_STATUS_TILE_SIZE);
    settings.tile_side = 257;
    check("large tiles", BEGIN(frame_memory, size, scene, 2, eye, NULL), SHISEN_STATUS_TILE_SIZE);
    settings.tile_side = 16;
    settings.depth = 17;
    check("depth", BEGIN(frame_memory, size, scene, 2, eye, NULL), SHISEN_STATUS_FRAME_SETTINGS);
    settings.depth = 3;
    settings.samples = 0;
    check("no samples", BEGIN(frame_memory, size, scene, 2, eye, NULL),
          SHISEN_STATUS_FRAME_SETTINGS);
    settings.samples = 1;
    walls[1].row_step[1] = 0.0f;
    check("flat screen", BEGIN(frame_memory, size, scene, 2, eye, NULL), SHISEN_STATUS_SCREEN);
    walls[1] = wall;
    walls[1].rows = 0;
    check("empty screen", BEGIN(frame_memory, size, scene, 2, eye, NULL),
          SHISEN_STATUS_PICTURE_SIZE);
    walls[1] = wall;
    check("spectrum not built",
          shisen_spectrum_open(frame_memory, size, 1, 400.0f, 700.0f, &spectrum),
          SHISEN_STATUS_NOT_BUILT);
    check("no wavelengths", shisen_spectrum_open(frame_memory, size, 0, 400.0f, 700.0f, &spectrum),
          SHISEN_STATUS_WAVELENGTHS);

    /* A gaze that makes no level of detail is none. */
    gaze.widen = NAN;
    check("wide gaze", BEGIN(frame_memory, size, scene, 2, eye, &gaze), SHISEN_STATUS_OK);
    gaze.widen = 0.0f;

    check("frame", BEGIN(frame_memory, size, scene, 2, eye, &gaze), SHISEN_STATUS_OK);
    check("render none", shisen_frame_render(NULL, 100, pixels, 256, &tile),
          SHISEN_STATUS_NULL_POINTER);
    check("no pixels", shisen_frame_render(frame, 100, NULL, 256, &tile),
          SHISEN_STATUS_NULL_POINTER);
    check("odd pixels", shisen_frame_render(frame, 100, (shisen_pixel *)((char *)pixels + 2), 200,
                                            &tile),
          SHISEN_STATUS_MISALIGNED);
    check("few pixels", shisen_frame_render(frame, 100, pixels, 255, &tile),
          SHISEN_STATUS_PIXELS_TOO_FEW);
    check("no tile", shisen_frame_render(frame, 100, pixels, 256, NULL),
          SHISEN_STATUS_NULL_POINTER);
    check("budget of 0", shisen_frame_render(frame, 0, pixels, 256, &tile),
          SHISEN_STATUS_BUDGET_SPENT);
    check("counts", shisen_frame_count(frame, &counts), SHISEN_STATUS_OK);
    check_that("nothing was done", counts.steps == 0 && counts.primary_rays == 0);
    check("count of none", shisen_frame_count(NULL, &counts), SHISEN_STATUS_NULL_POINTER);
    while ((status = shisen_frame_render(frame, 1000, pixels, 256, &tile)) !=
           SHISEN_STATUS_FINISHED) {
        if (status >= SHISEN_FIRST_FAILURE)
            break;
        tiles += status == SHISEN_STATUS_TILE;
    }
    check("finished", status, SHISEN_STATUS_FINISHED);
    check_that("all tiles", tiles == 2 * TILES);
    check("finished for good", shisen_frame_render(frame, 1000, pixels, 256, &tile),
          SHISEN_STATUS_FINISHED);

    settings.budget = 0;
    check("frame of no budget", BEGIN(frame_memory, size, scene, 2, eye, &gaze), SHISEN_STATUS_OK);
    for (tiles = 0; tiles < 2 * TILES; tiles++)
        check("given up", shisen_frame_render(frame, SHISEN_UNLIMITED, pixels, 256, &tile),
              SHISEN_STATUS_TILE);
    check("counts", shisen_frame_count(frame, &counts), SHISEN_STATUS_OK);
    check_that("all given up", counts.tiles_given_up == 2 * TILES && counts.tiles_whole == 0 &&
                                   counts.steps == 0 && tile.whole == 0);
    settings.budget = SHISEN_UNLIMITED;

    check("dome", shisen_dome_init(&dome, eye, 32), SHISEN_STATUS_OK);
    check("no dome", shisen_dome_init(NULL, eye, 32), SHISEN_STATUS_NULL_POINTER);
#define DOME shisen_frame_begin_dome(frame_memory, size, scene, &settings, &dome, &frame)
    check("dome's frame", DOME, SHISEN_STATUS_OK);
    dome.size = 0;
    check("dome of no pixels", DOME, SHISEN_STATUS_PICTURE_SIZE);
    dome.size = 32;
    dome.radius = -1.0f;
    check("dome's mirror", DOME, SHISEN_STATUS_DOME_MIRROR);
    dome.radius = 0.001f;
    dome.right[0] = 2.0f;
    check("dome's axes", DOME, SHISEN_STATUS_DOME_AXES);
    dome.right[0] = 1.0f;
    dome.position[0] = INFINITY;
    check("dome's place", DOME, SHISEN_STATUS_EYE);
    check("dome's scene",
          shisen_frame_begin_dome(frame_memory, size, NULL, &settings, &dome, &frame),
          SHISEN_STATUS_NULL_POINTER);
}

int main(int count, char **arguments)
{
    FILE *file = count == 2 ? fopen(arguments[1], "rb") : NULL;
    size_t length, most = 1 << 22;
    void *memory = malloc(most + SHISEN_BLOB_ALIGNMENT + 4);
    uint8_t *blob;

    if (!file || !memory) {
        fprintf(stderr, "usage: bad SCENE\n");
        return 2;
    }
    blob = (uint8_t *)memory + (SHISEN_BLOB_ALIGNMENT - (uintptr_t)memory % SHISEN_BLOB_ALIGNMENT);
    length = fread(blob, 1, most - SHISEN_BLOB_ALIGNMENT, file);
    fclose(file);

    check_sizes();
    check_scenes(blob, length);
    check_trackers();
    check_screens();
    check_frames(blob, length);
    free(memory);
    printf("%d checks, %d failures\n", checks, failures);
    return failures != 0;
}
