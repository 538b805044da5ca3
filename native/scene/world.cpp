// SPDX-License-Identifier: GPL-3.0-or-later
// Based on: blender/cycles v4.5.0, src/kernel/camera/projection.h (equirectangular) and svm/image.h (bilinear, repeating
//           in both directions: next to a pole the row of the other pole mixes in).
// Differs:  the PDF is constant per texel but covers the bilinear footprint: a texel weighs what the interpolated image
//           holds within its square, so that no radiance lies where the PDF is 0; 1 % of all samples are uniform.
// Bound:    4 bytes per texel beside the image.
#include "scene/world.hpp"
#include "core/errors.hpp"
#include "core/sampling.hpp"
#include <algorithm>
#include <cmath>
#include <numbers>

namespace tyndall {
constexpr float pi = std::numbers::pi_v<float>;
constexpr float uniform_share = 0.01f;

static bool is_finite(const Rgb& value) {
    return std::isfinite(value.x) && std::isfinite(value.y) && std::isfinite(value.z);
}

/// Rec. 709 luminance of the magnitudes: a channel below 0 matters, too.
static float importance_of(const Rgb& radiance) { return glm::dot(glm::abs(radiance), Rgb(0.2126f, 0.7152f, 0.0722f)); }

/// Height of the lower edge of a row of texels on the unit sphere, [-1, 1].
static double edge_height(std::uint32_t row, std::uint32_t height) {
    return std::sin((static_cast<double>(row) / height - 0.5) * std::numbers::pi);
}

static std::shared_ptr<const EnvironmentImage> without_broken_pixels(std::shared_ptr<const EnvironmentImage> image) {
    if (std::all_of(image->pixels.begin(), image->pixels.end(), is_finite))
        return image;
    EnvironmentImage mended = *image;
    for (Rgb& pixel : mended.pixels)
        if (!is_finite(pixel))
            pixel = Rgb(0.0f);
    return std::make_shared<const EnvironmentImage>(std::move(mended));
}

/// The integral of the bilinear image over each texel's square (1/8, 3/4, 1/8 along each axis), times its solid angle.
static PiecewiseConstant2d importance_of(const EnvironmentImage& image) {
    const std::size_t width = image.width, height = image.height;
    std::vector<float> along_rows(width * height), weights(width * height);
    for (std::size_t row = 0; row < height; ++row)
        for (std::size_t column = 0; column < width; ++column) {
            const Rgb* pixels = &image.pixels[row * width];
            along_rows[row * width + column] = 0.125f * importance_of(pixels[(column + width - 1) % width]) +
                                               0.75f * importance_of(pixels[column]) +
                                               0.125f * importance_of(pixels[(column + 1) % width]);
        }
    double total = 0.0;
    for (std::size_t row = 0; row < height; ++row) {
        const auto solid_angle = static_cast<float>(edge_height(static_cast<std::uint32_t>(row + 1), image.height) -
                                                    edge_height(static_cast<std::uint32_t>(row), image.height));
        const float* below = &along_rows[(row + height - 1) % height * width];
        const float* here = &along_rows[row * width];
        const float* above = &along_rows[(row + 1) % height * width];
        for (std::size_t column = 0; column < width; ++column) {
            const float mean = 0.125f * below[column] + 0.75f * here[column] + 0.125f * above[column];
            weights[row * width + column] = mean * solid_angle;
            total += weights[row * width + column];
        }
    }
    // total / (2 width) is the weight that a uniform image of the same sum has per unit of height.
    const auto uniform = static_cast<float>(uniform_share * total / (2.0 * static_cast<double>(width)));
    for (std::size_t row = 0; row < height; ++row) {
        const auto solid_angle = static_cast<float>(edge_height(static_cast<std::uint32_t>(row + 1), image.height) -
                                                    edge_height(static_cast<std::uint32_t>(row), image.height));
        for (std::size_t column = 0; column < width; ++column) {
            float& weight = weights[row * width + column];
            weight = (1.0f - uniform_share) * weight + uniform * solid_angle;
        }
    }
    return {weights, image.width};
}

World::World(std::string name, Rgb radiance, std::shared_ptr<const EnvironmentImage> image, mat3 image_from_world,
             SeenWorld seen)
    : name_(std::move(name)), radiance_(radiance), image_(std::move(image)), seen_(std::move(seen)),
      image_from_world_(image_from_world) {
    is_black_ = radiance_ == Rgb(0.0f);
    require(is_finite(radiance_), "world '", name_, "': its radiance is not finite");
    for (std::shared_ptr<const EnvironmentImage>* given : {&image_, &seen_.image}) {
        if (*given == nullptr)
            continue;
        const EnvironmentImage& one = **given;
        require(one.width > 0 && one.height > 0 && one.pixels.size() == std::size_t{one.width} * one.height, "world '",
                name_, "': image '", one.name, "' has ", one.pixels.size(), " pixels for ", one.width, " x ",
                one.height);
        *given = without_broken_pixels(std::move(*given));
    }
    if (image_ == nullptr)
        return;
    importance_ = std::make_shared<const PiecewiseConstant2d>(importance_of(*image_));
    is_black_ |=
        std::all_of(image_->pixels.begin(), image_->pixels.end(), [](const Rgb& pixel) { return pixel == Rgb(0.0f); });
}

/// Position in the image, [0, 1]^2, of a direction in the image's space.
static vec2 uv_of(const vec3& direction) {
    const float longitude = std::atan2(direction.y, direction.x);
    const float latitude = std::atan2(direction.z, std::hypot(direction.x, direction.y));
    return {0.5f - longitude / (2.0f * pi), latitude / pi + 0.5f};
}

static Rgb bilinear(const EnvironmentImage& image, vec2 uv) {
    const vec2 corner = uv * vec2(static_cast<float>(image.width), static_cast<float>(image.height)) - 0.5f;
    const vec2 whole = glm::floor(corner);
    const vec2 share = corner - whole;
    const auto wrap = [](float texel, std::uint32_t count) {
        const auto signed_count = static_cast<std::int64_t>(count);
        return static_cast<std::size_t>((static_cast<std::int64_t>(texel) + signed_count) % signed_count);
    };
    const std::size_t left = wrap(whole.x, image.width), right = wrap(whole.x + 1.0f, image.width);
    const Rgb* lower = &image.pixels[wrap(whole.y, image.height) * image.width];
    const Rgb* upper = &image.pixels[wrap(whole.y + 1.0f, image.height) * image.width];
    return glm::mix(glm::mix(lower[left], lower[right], share.x), glm::mix(upper[left], upper[right], share.x),
                    share.y);
}

Rgb World::radiance(const vec3& unit_direction) const {
    if (image_ == nullptr)
        return radiance_;
    return radiance_ * bilinear(*image_, uv_of(image_from_world_ * unit_direction));
}

Rgb World::seen_radiance(const vec3& unit_direction) const {
    if (seen_.program != nullptr)
        return seen_.program->radiance(unit_direction, RayKind::Camera);
    if (seen_.image == nullptr)
        return radiance(unit_direction);
    return radiance_ * bilinear(*seen_.image, uv_of(image_from_world_ * unit_direction));
}

World::DirectionSample World::sample(vec2 u) const {
    if (image_ == nullptr) {
        const vec3 direction = sample_uniform_sphere(u);
        return {direction, 0.25f / pi, radiance_};
    }
    const auto [column, row, offset] = importance_->sample(u);
    const double low = edge_height(row, image_->height), high = edge_height(row + 1, image_->height);
    const double height = low + offset.y * (high - low);
    const double radius = std::sqrt(std::max(0.0, 1.0 - height * height));
    const double longitude = (0.5 - (column + static_cast<double>(offset.x)) / image_->width) * 2.0 * std::numbers::pi;
    const vec3 in_image(dvec3(radius * std::cos(longitude), radius * std::sin(longitude), height));
    const vec3 direction = glm::transpose(image_from_world_) * in_image;
    const double solid_angle_sr = 2.0 * std::numbers::pi / image_->width * (high - low);
    return {direction, static_cast<float>(importance_->probability(column, row) / solid_angle_sr), radiance(direction)};
}

float World::pdf_per_sr(const vec3& unit_direction) const {
    if (image_ == nullptr)
        return 0.25f / pi;
    const vec2 uv = uv_of(image_from_world_ * unit_direction);
    const auto cell = [](float share, std::uint32_t count) {
        return std::min(static_cast<std::uint32_t>(std::max(share, 0.0f) * static_cast<float>(count)), count - 1u);
    };
    const std::uint32_t column = cell(uv.x, image_->width), row = cell(uv.y, image_->height);
    const double solid_angle_sr = 2.0 * std::numbers::pi / image_->width *
                                  (edge_height(row + 1, image_->height) - edge_height(row, image_->height));
    return static_cast<float>(importance_->probability(column, row) / solid_angle_sr);
}
} // namespace tyndall
