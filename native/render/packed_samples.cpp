// SPDX-License-Identifier: GPL-3.0-or-later
#include "render/packed_samples.hpp"
#include <initializer_list>

namespace tyndall::render {
/// Calls visit(value) for each vector and number that is kept; the same for packing and unpacking.
template <typename Sample, typename Visit>
static void visit_all(Sample& sample, const PackedSamples::Parts& parts, const Visit& visit) {
    visit(sample.radiance);
    visit(sample.position);
    visit(sample.transmittance);
    visit(sample.alpha);
    visit(sample.depth_m);
    if (parts.has_passes)
        for (auto* colour : {&sample.normal, &sample.diffuse_colour, &sample.emission, &sample.lit, &sample.unshadowed,
                             &sample.ambient})
            visit(*colour);
    if (parts.has_world_lit)
        for (auto* value : {&sample.world_lit.position, &sample.world_lit.normal, &sample.world_lit.albedo,
                            &sample.world_lit.irradiance})
            visit(*value);
}

namespace {
struct Pack {
    std::vector<float>& to;
    void operator()(float value) const { to.push_back(value); }
    void operator()(const vec3& value) const { to.insert(to.end(), {value.x, value.y, value.z}); }
};
struct Count {
    std::size_t& floats;
    void operator()(float) const { ++floats; }
    void operator()(const vec3&) const { floats += 3; }
};
struct Unpack {
    const float*& from;
    void operator()(float& value) const { value = *from++; }
    void operator()(vec3& value) const {
        value = {from[0], from[1], from[2]};
        from += 3;
    }
};
} // namespace

PackedSamples::Parts PackedSamples::parts_for(const PassSet& passes, bool shares_world) {
    return {.has_passes = passes.has(Pass::Normal) || passes.has(Pass::DiffuseColour) || passes.has(Pass::Emission) ||
                          passes.has(Pass::Shadow) || passes.has(Pass::AmbientOcclusion),
            .has_world_lit = shares_world};
}

void PackedSamples::push(const PathSample& sample, const Parts& parts) { visit_all(sample, parts, Pack{values_}); }

PathSample PackedSamples::get(std::size_t index, const Parts& parts) const {
    PathSample sample;
    std::size_t stride = 0;
    visit_all(sample, parts, Count{stride});
    const float* from = &values_[index * stride];
    visit_all(sample, parts, Unpack{from});
    return sample;
}
} // namespace tyndall::render
