// tinybvh's fastest tree for processors, built with spatial splits and without.
#include "../interface/contender.h"

#define TINYBVH_IMPLEMENTATION
#include <tiny_bvh.h>

#include <limits>
#include <vector>

using namespace tinybvh;

namespace {

struct Tree { std::vector<bvhvec4> corners; BVH8_CPU bvh; };

template <bool SPLITS> void *open(const Mesh *mesh) {
    auto *tree = new Tree;
    tree->corners.resize(3 * mesh->triangles);
    for (size_t i = 0; i < tree->corners.size(); i++) {
        const float *corner = mesh->corners + 3 * i;
        tree->corners[i] = bvhvec4(corner[0], corner[1], corner[2], 0);
    }
    if (SPLITS) tree->bvh.BuildHQ(tree->corners.data(), uint32_t(mesh->triangles));
    else tree->bvh.Build(tree->corners.data(), uint32_t(mesh->triangles));
    return tree;
}

void close(void *opened) { delete static_cast<Tree *>(opened); }

// Sets a ray as tinybvh's constructor does, but keeps the direction's length.
void set(Ray &ray, const float (&from)[6]) {
    ray.O = bvhvec3(from[0], from[1], from[2]);
    ray.D = bvhvec3(from[3], from[4], from[5]);
    ray.rD = tinybvh_rcp(ray.D);
    ray.hit.t = BVH_FAR;
}

constexpr Hit MISS = {NONE, std::numeric_limits<float>::infinity()};

void nearest(const void *opened, const Rays *rays, Hit *hits) {
    auto *tree = static_cast<const Tree *>(opened);
    Ray ray;
    for (size_t i = 0; i < rays->count; i++) {
        set(ray, rays->rays[i]);
        tree->bvh.Intersect(ray);
        hits[i] = ray.hit.t < BVH_FAR ? Hit{ray.hit.prim, ray.hit.t} : MISS;
    }
}

void any(const void *opened, const Rays *rays, Hit *hits) {
    auto *tree = static_cast<const Tree *>(opened);
    Ray ray;
    for (size_t i = 0; i < rays->count; i++) {
        set(ray, rays->rays[i]);
        hits[i] = tree->bvh.IsOccluded(ray) ? Hit{0, 0} : MISS;
    }
}

#define TEXT_OF(x) #x
#define TEXT(x) TEXT_OF(x)
constexpr char VERSION[] = TEXT(TINY_BVH_VERSION_MAJOR) "." TEXT(TINY_BVH_VERSION_MINOR) "." TEXT(TINY_BVH_VERSION_SUB);
constexpr char SIMD[] = "AVX2 and FMA, 8 wide";

} // namespace

extern "C" const Contender *shisen_contenders(size_t *count) {
    static const Contender all[] = {
        {"tinybvh", "BVH8_CPU, spatial splits", VERSION, SIMD, NEAREST, open<true>, nearest, close},
        {"tinybvh", "BVH8_CPU", VERSION, SIMD, NEAREST, open<false>, nearest, close},
        {"tinybvh", "BVH8_CPU, spatial splits", VERSION, SIMD, ANY, open<true>, any, close},
    };
    *count = sizeof all / sizeof *all;
    return all;
}
