// SPDX-License-Identifier: GPL-3.0-or-later
#include "light_shafts/transparency_lookup.hpp"
#include "shading/surface_program.hpp"
#include <atomic>
#include <new>

namespace tyndall::light_shafts {
using Code = SurfaceOp::Code;

Occlusion occlusion_of(const Material& material) {
    if (is_transparent_everywhere(material))
        return Occlusion::None;
    return is_opaque_everywhere(material) ? Occlusion::Opaque : Occlusion::Partial;
}

static bool read_the_same(const SurfaceOp& a, const SurfaceOp& b) {
    return a.texture == b.texture && a.texture_uv == b.texture_uv && a.uv_matrix == b.uv_matrix;
}

TransparencyLookup::TransparencyLookup(const Material& material)
    : material_(material), operations_(material), is_coloured_(has_coloured_transparency(material)) {
    reads_facing_ = (operations_.reads & (OpReads::facing | OpReads::point)) != 0;
    bool is_one_image = (operations_.reads & OpReads::point) == 0, reads_alpha_alone = true;
    for (const std::uint16_t place : operations_.places) {
        const SurfaceOp& op = material.program[place];
        reads_alpha_alone &= op.code != Code::Texture && op.code != Code::Backfacing;
        if (op.code == Code::Texture || op.code == Code::TextureAlpha) {
            is_one_image &= image_ == nullptr || read_the_same(*image_, op);
            image_ = &op;
        } else {
            const OpReads::Flags reads = facts_of(op).value_or(OpFacts{}).reads;
            is_one_image &= (reads & (OpReads::uv_map | OpReads::image)) == 0;
        }
    }
    if (image_ != nullptr && (!is_one_image || texture().width == 0 || texture().height == 0 ||
                              texture().interpolation == TextureInterpolation::Cubic))
        image_ = nullptr;
    if (image_ == nullptr)
        return;
    at_no_alpha_ = evaluate_transparent(material, operations_, vec4(0.0f), false);
    per_alpha_ = evaluate_transparent(material, operations_, vec4(1.0f), false) - at_no_alpha_;
    is_straight_ = reads_alpha_alone;
    for (int step = 1; is_straight_ && step < 64; ++step) {
        const float alpha = static_cast<float>(step) / 64.0f;
        const Rgb bend =
            evaluate_transparent(material, operations_, vec4(alpha), false) - (at_no_alpha_ + alpha * per_alpha_);
        is_straight_ = glm::length(bend) < 1e-6f;
    }
    find_lines_by_channel();
    class_columns_ = static_cast<std::int32_t>(texture().width) + margin + 1;
    const std::size_t count = static_cast<std::size_t>(class_columns_) * (texture().height + margin + 1) + 3;
    for (std::size_t side = 0; side < (reads_facing_ ? 2 : 1); ++side) {
        classes_[side].reset(static_cast<std::uint8_t*>(std::calloc(count, 1)));
        if (classes_[side] == nullptr)
            throw std::bad_alloc();
    }
}

void TransparencyLookup::find_lines_by_channel() {
    // Beyond 1, where only images of floats are, a program may do what it does not below.
    if (is_straight_ || reads_facing_ || texture().has_alpha || !texture().floats.empty() || texture().tiles)
        return;
    const auto of = [&](const vec4& value) { return evaluate_transparent(material_, operations_, value, false); };
    at_black_ = of(vec4(0, 0, 0, 1));
    per_colour_ = of(vec4(1)) - at_black_;
    is_straight_by_channel_ = true;
    vec4 value(0.0f);
    for (int step = 0; is_straight_by_channel_ && step < 256; ++step) {
        value = glm::fract(value + vec4(0.856f, 0.733f, 0.628f, 0.538f)); // spread evenly over all four
        is_straight_by_channel_ = glm::length(of(value) - (at_black_ + vec3(value) * per_colour_)) < 1e-6f;
    }
}

TexelClass TransparencyLookup::classify(bool is_backface, std::int32_t column, std::int32_t row) const {
    const Texture& image = texture();
    const std::int64_t reach = image.interpolation == TextureInterpolation::Linear ? 1 : 0;
    bool stops = true, passes = true;
    for (std::int64_t y = row; y <= row + reach; ++y)
        for (std::int64_t x = column; x <= column + reach; ++x) {
            const Rgb transparent = evaluate_transparent(material_, operations_, image.at(x, y), is_backface);
            stops &= transparent == Rgb(0.0f);
            passes &= transparent == Rgb(1.0f);
        }
    const TexelClass found = stops ? TexelClass::Stops : passes ? TexelClass::Passes : TexelClass::Mixed;
    std::uint8_t* classes = classes_[is_backface && reads_facing_].get();
    std::atomic_ref(classes[std::ptrdiff_t{row + margin} * class_columns_ + column + margin])
        .store(static_cast<std::uint8_t>(found), std::memory_order_relaxed);
    return found;
}

Rgb TransparencyLookup::at(const ProgramPoint& point, std::span<const vec2> uvs) const {
    return evaluate_transparent(material_, operations_, point, uvs);
}
} // namespace tyndall::light_shafts
