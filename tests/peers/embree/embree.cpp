// Embree, as its users set it up: the best build, single rays and coherent packets of
// 16, with and without the robust mode.
#include "../interface/contender.h"

#include <embree3/rtcore.h>
#include <limits>

namespace {

struct Tree { RTCDevice device; RTCScene scene; };

template <RTCSceneFlags FLAGS> void *open(const Mesh *mesh) {
    RTCDevice device = rtcNewDevice(nullptr);
    if (!device) return nullptr;
    RTCScene scene = rtcNewScene(device);
    rtcSetSceneFlags(scene, FLAGS);
    rtcSetSceneBuildQuality(scene, RTC_BUILD_QUALITY_HIGH);
    RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
    size_t corners = 3 * mesh->triangles;
    auto *vertices = static_cast<float *>(rtcSetNewGeometryBuffer(
        geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 12, corners));
    auto *indices = static_cast<unsigned *>(rtcSetNewGeometryBuffer(
        geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 12, mesh->triangles));
    if (!vertices || !indices) return nullptr;
    for (size_t i = 0; i < 3 * corners; i++) vertices[i] = mesh->corners[i];
    for (size_t i = 0; i < corners; i++) indices[i] = unsigned(i);
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(scene, geometry);
    rtcReleaseGeometry(geometry);
    rtcCommitScene(scene);
    if (rtcGetDeviceError(device) != RTC_ERROR_NONE) return nullptr;
    return new Tree{device, scene};
}

void close(void *opened) {
    auto *tree = static_cast<Tree *>(opened);
    rtcReleaseScene(tree->scene);
    rtcReleaseDevice(tree->device);
    delete tree;
}

void set(RTCRay &ray, const float (&from)[6]) {
    ray.org_x = from[0], ray.org_y = from[1], ray.org_z = from[2];
    ray.dir_x = from[3], ray.dir_y = from[4], ray.dir_z = from[5];
    ray.tnear = 0, ray.tfar = std::numeric_limits<float>::infinity();
    ray.time = 0, ray.mask = ~0u, ray.id = 0, ray.flags = 0;
}

void nearest(const void *opened, const Rays *rays, Hit *hits) {
    auto *tree = static_cast<const Tree *>(opened);
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    for (size_t i = 0; i < rays->count; i++) {
        RTCRayHit ray;
        set(ray.ray, rays->rays[i]);
        ray.hit.geomID = RTC_INVALID_GEOMETRY_ID;
        rtcIntersect1(tree->scene, &context, &ray);
        bool hit = ray.hit.geomID != RTC_INVALID_GEOMETRY_ID;
        hits[i] = {hit ? ray.hit.primID : NONE, ray.ray.tfar};
    }
}

void any(const void *opened, const Rays *rays, Hit *hits) {
    auto *tree = static_cast<const Tree *>(opened);
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    for (size_t i = 0; i < rays->count; i++) {
        RTCRay ray;
        set(ray, rays->rays[i]);
        rtcOccluded1(tree->scene, &context, &ray);
        hits[i] = ray.tfar < 0 ? Hit{0, 0} : Hit{NONE, std::numeric_limits<float>::infinity()};
    }
}

// Blocks of 4×4 pixels.
void packets(const void *opened, const Rays *rays, Hit *hits) {
    auto *tree = static_cast<const Tree *>(opened);
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
    alignas(64) int valid[16];
    for (int &lane : valid) lane = -1;
    size_t side = rays->side;
    for (size_t row = 0; row < rays->count / side; row += 4)
        for (size_t column = 0; column < side; column += 4) {
            RTCRayHit16 ray;
            for (unsigned lane = 0; lane < 16; lane++) {
                const auto &from = rays->rays[(row + lane / 4) * side + column + lane % 4];
                ray.ray.org_x[lane] = from[0], ray.ray.org_y[lane] = from[1], ray.ray.org_z[lane] = from[2];
                ray.ray.dir_x[lane] = from[3], ray.ray.dir_y[lane] = from[4], ray.ray.dir_z[lane] = from[5];
                ray.ray.tnear[lane] = 0, ray.ray.tfar[lane] = std::numeric_limits<float>::infinity();
                ray.ray.time[lane] = 0, ray.ray.mask[lane] = ~0u, ray.ray.id[lane] = 0, ray.ray.flags[lane] = 0;
                ray.hit.geomID[lane] = RTC_INVALID_GEOMETRY_ID;
            }
            rtcIntersect16(valid, tree->scene, &context, &ray);
            for (unsigned lane = 0; lane < 16; lane++) {
                bool hit = ray.hit.geomID[lane] != RTC_INVALID_GEOMETRY_ID;
                hits[(row + lane / 4) * side + column + lane % 4] = {hit ? ray.hit.primID[lane] : NONE, ray.ray.tfar[lane]};
            }
        }
}

// The instruction sets that the library uses on this processor.
struct Simd {
    const char *single = "SSE, 4 wide", *packet = "SSE, 4 wide";
    Simd() {
        RTCDevice device = rtcNewDevice(nullptr);
        if (!device) return;
        if (rtcGetDeviceProperty(device, RTC_DEVICE_PROPERTY_NATIVE_RAY8_SUPPORTED)) single = packet = "AVX, 8 wide";
        if (rtcGetDeviceProperty(device, RTC_DEVICE_PROPERTY_NATIVE_RAY16_SUPPORTED))
            single = "AVX-512, 8 wide", packet = "AVX-512, 16 wide";
        rtcReleaseDevice(device);
    }
};

} // namespace

extern "C" const Contender *shisen_contenders(size_t *count) {
    static const Simd simd;
    constexpr auto robust = RTC_SCENE_FLAG_ROBUST, plain = RTC_SCENE_FLAG_NONE;
    static const Contender all[] = {
        {"Embree", "robust", RTC_VERSION_STRING, simd.single, NEAREST, open<robust>, nearest, close},
        {"Embree", "default", RTC_VERSION_STRING, simd.single, NEAREST, open<plain>, nearest, close},
        {"Embree", "robust", RTC_VERSION_STRING, simd.single, ANY, open<robust>, any, close},
        {"Embree", "robust, packets of 16", RTC_VERSION_STRING, simd.packet, PICTURE, open<robust>, packets, close},
        {"Embree", "default, packets of 16", RTC_VERSION_STRING, simd.packet, PICTURE, open<plain>, packets, close},
    };
    *count = sizeof all / sizeof *all;
    return all;
}
