/* Renders the same frame on several threads, each with handles of its own: threads SCENE
   STREAM. Prints "frame" and the frame's hash, and fails where the threads differ. */
#include "frame.h"

#include <inttypes.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>

#define THREADS 2

/* Largest file that is read, bytes. */
#define MOST_BYTES (16 << 20)

typedef struct file {
    uint8_t *bytes;
    size_t length;
} file;

static file scene, stream;

void emit(const shisen_tile *tile, const shisen_pixel *pixels)
{
    (void)tile;
    (void)pixels;
}

static file read_file(const char *path)
{
    file read = {0};
    FILE *from = fopen(path, "rb");
    read.bytes = aligned_alloc(SHISEN_BLOB_ALIGNMENT, MOST_BYTES);
    if (from && read.bytes)
        read.length = fread(read.bytes, 1, MOST_BYTES, from);
    if (from)
        fclose(from);
    return read;
}

static void *render(void *report)
{
    shisen_status status =
        render_walls(scene.bytes, scene.length, stream.bytes, stream.length, 500, report);
    return status == SHISEN_STATUS_OK ? report : NULL;
}

int main(int count, char **arguments)
{
    pthread_t threads[THREADS];
    walls_report reports[THREADS] = {0};
    int number, status = 0;

    if (count != 3)
        return 2;
    scene = read_file(arguments[1]);
    stream = read_file(arguments[2]);
    for (number = 0; number < THREADS; number++)
        if (pthread_create(&threads[number], NULL, render, &reports[number]) != 0)
            return 1;
    for (number = 0; number < THREADS; number++) {
        void *rendered = NULL;
        pthread_join(threads[number], &rendered);
        if (!rendered || reports[number].hash != reports[0].hash)
            status = 1;
    }
    printf("frame %016" PRIx64 "\n", reports[0].hash);
    free(scene.bytes);
    free(stream.bytes);
    return status;
}
