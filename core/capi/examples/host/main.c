/* The example on a host: frame SCENE STREAM [SLICE_BUDGET]. */
#include "../frame.h"

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>

static uint32_t tiles_emitted;

void emit(const shisen_tile *tile, const shisen_pixel *pixels)
{
    (void)tile;
    (void)pixels;
    tiles_emitted++;
}

/* A file's bytes at a multiple of SHISEN_BLOB_ALIGNMENT; NULL where it cannot be
   read. */
static uint8_t *read_file(const char *path, void **memory, size_t *length)
{
    FILE *file = fopen(path, "rb");
    long end = -1;
    uint8_t *bytes = NULL;
    *memory = NULL;
    if (file && fseek(file, 0, SEEK_END) == 0)
        end = ftell(file);
    if (end >= 0 && fseek(file, 0, SEEK_SET) == 0)
        *memory = malloc((size_t)end + SHISEN_BLOB_ALIGNMENT);
    if (*memory) {
        size_t past = (uintptr_t)*memory % SHISEN_BLOB_ALIGNMENT;
        bytes = (uint8_t *)*memory + (SHISEN_BLOB_ALIGNMENT - past);
        *length = fread(bytes, 1, (size_t)end, file);
        if (*length != (size_t)end)
            bytes = NULL;
    }
    if (file)
        fclose(file);
    if (!bytes)
        fprintf(stderr, "cannot read %s: give a file that is there\n", path);
    return bytes;
}

int main(int count, char **arguments)
{
    walls_report report = {0};
    void *scene_memory, *stream_memory;
    size_t scene_length = 0, stream_length = 0;
    uint64_t slice_budget = 500, dome = 0;
    uint8_t *scene, *stream;
    shisen_status status;

    if (count < 3 || count > 4) {
        fprintf(stderr, "usage: frame SCENE STREAM [SLICE_BUDGET]\n");
        return 2;
    }
    if (count == 4)
        slice_budget = strtoull(arguments[3], NULL, 10);
    scene = read_file(arguments[1], &scene_memory, &scene_length);
    stream = read_file(arguments[2], &stream_memory, &stream_length);
    if (!scene || !stream)
        return 1;

    status = render_walls(scene, scene_length, stream, stream_length, slice_budget, &report);
    if (status == SHISEN_STATUS_OK)
        status = render_dome(scene, scene_length, slice_budget, &dome);
    free(scene_memory);
    free(stream_memory);
    if (status != SHISEN_STATUS_OK) {
        fprintf(stderr, "%s: %s\n", shisen_status_name(status), shisen_status_message(status));
        return 1;
    }
    printf("samples %" PRIu64 "\n", report.tracker.samples);
    printf("gaze state %" PRIu32 "\n", report.gaze.state);
    printf("tiles %" PRIu32 "\n", tiles_emitted);
    printf("slices %" PRIu32 "\n", report.slices);
    printf("steps %" PRIu64 "\n", report.frame.steps);
    printf("frame %016" PRIx64 "\n", report.hash);
    printf("dome %016" PRIx64 "\n", dome);
    return 0;
}
