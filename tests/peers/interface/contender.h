// What a library of contenders exports; src/lib.rs says the same for Rust, with what
// each part means.
#pragma once
#include <cstddef>
#include <cstdint>

struct Mesh { const float *corners; size_t triangles; const uint8_t *baked; size_t baked_bytes; };
struct Rays { const float (*rays)[6]; size_t count; size_t side; };
struct Hit { uint32_t triangle; float t; };
constexpr uint32_t NONE = UINT32_MAX;

enum Task : int { NEAREST = 0, ANY = 1, PICTURE = 2 };

struct Contender {
    const char *name, *mode, *version, *simd;
    Task task;
    void *(*open)(const Mesh *);
    void (*trace)(const void *, const Rays *, Hit *);
    void (*close)(void *);
};

extern "C" const Contender *shisen_contenders(size_t *count);
