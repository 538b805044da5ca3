// SPDX-License-Identifier: GPL-3.0-or-later
// The share of light that a material lets pass, for millions of points: where an image decides, each of its texels
// remembers whether all points around it stop light, or all let it pass, so that only borders run the material's program.
// Bound:    a byte per texel, found out when it is first asked for; one gather per 4 to 16 points, and one at a time on a
//           border, or where the image is neither 0 nor 1: 10 ns where opacity is the image's alpha or what passes is its
//           colour, else some 100 ns.
#pragma once
#include "core/math.hpp"
#include "shading/program_point.hpp"
#include "shading/transparent_operations.hpp"
#include <cstdint>
#include <cstdlib>
#include <memory>
#include <optional>
#include <span>

namespace tyndall::light_shafts {
/// How triangles of a material occlude.
enum class Occlusion : std::uint8_t {
    Opaque = 0,
    Partial = 1, ///< How much passes is looked up at each point.
    None = 2,    ///< No surface, or one that lets all light pass.
};
[[nodiscard]] Occlusion occlusion_of(const Material& material);

/// What the points between neighbouring texels (or of one texel, where the image is not filtered) do with light.
enum class TexelClass : std::uint8_t { Unknown = 0, Stops = 1, Passes = 2, Mixed = 3 };

class TransparencyLookup {
public:
    /// The material must outlive this.
    explicit TransparencyLookup(const Material& material);

    [[nodiscard]] const Material& material() const { return material_; }
    [[nodiscard]] bool is_coloured() const { return is_coloured_; }
    [[nodiscard]] bool reads_facing() const { return reads_facing_; }
    /// More of a point than its UV maps and its facing.
    [[nodiscard]] bool reads_point() const { return (operations_.reads & OpReads::point) != 0; }
    [[nodiscard]] const TransparentOperations& operations() const { return operations_; }
    /// The same share everywhere: the program reads nothing that differs between points. Nothing: it does.
    [[nodiscard]] const std::optional<Rgb>& constant() const { return operations_.constant; }
    /// The one image that decides; nothing for a constant, or where several do, or something else does, too.
    [[nodiscard]] const SurfaceOp* image() const { return image_; }
    [[nodiscard]] const Texture& texture() const { return *material_.textures[image_->texture]; }

    /// Classes of texel (column, row) at (row + margin) * class_columns() + column + margin, for columns in
    /// [-margin, width], where -margin and width stand for all that lies beyond. Aligned; three bytes follow the last.
    static constexpr std::int32_t margin = 2;
    [[nodiscard]] std::int32_t class_columns() const { return class_columns_; }
    [[nodiscard]] const std::uint8_t* classes(bool is_backface) const {
        return classes_[is_backface && reads_facing_].get();
    }
    /// Finds the class out and remembers it; safe from many threads, which all find the same.
    TexelClass classify(bool is_backface, std::int32_t column, std::int32_t row) const;
    /// The program does nothing but turn the deciding image's alpha into opacity, by a straight line, on both sides.
    [[nodiscard]] bool is_straight() const { return is_straight_; }
    /// If that is so: at a point of the deciding image.
    [[nodiscard]] Rgb at(const vec2& uv_in_image) const {
        return at_no_alpha_ + texture().alpha(uv_in_image) * per_alpha_;
    }
    /// The program gives each channel of the deciding image back by a straight line of its own, on both sides.
    [[nodiscard]] bool is_straight_by_channel() const { return is_straight_by_channel_; }
    /// If that is so: one channel at a point of the deciding image.
    [[nodiscard]] float at(const vec2& uv_in_image, int channel) const {
        return at_black_[channel] + texture().colour(uv_in_image, channel) * per_colour_[channel];
    }
    /// By the material's program. uvs as evaluate_transparent takes them.
    [[nodiscard]] Rgb at(const ProgramPoint& point, std::span<const vec2> uvs) const;

private:
    struct Free {
        void operator()(std::uint8_t* bytes) const { std::free(bytes); }
    };
    const Material& material_;
    TransparentOperations operations_;
    const SurfaceOp* image_ = nullptr;
    bool is_coloured_ = false, reads_facing_ = false, is_straight_ = false, is_straight_by_channel_ = false;
    Rgb at_no_alpha_{0.0f}, per_alpha_{0.0f}, at_black_{0.0f}, per_colour_{0.0f};
    void find_lines_by_channel();
    std::int32_t class_columns_ = 0;
    std::unique_ptr<std::uint8_t[], Free> classes_[2]; ///< Front; back, if that differs. Zeroed pages until touched.
};
} // namespace tyndall::light_shafts
