// SPDX-License-Identifier: GPL-3.0-or-later
// Based on: blender/cycles v4.5.0, src/kernel/camera/projection.h (equirectangular) and svm/image.h (bilinear, repeating
//           in both directions: next to a pole the row of the other pole mixes in).
// Bound:    a look is two angles and two pairs of neighbouring texels; environment_importance.hpp for directions.
#include "scene/world.hpp"
#include "core/errors.hpp"
#include "core/sampling.hpp"
#include "scene/environment_importance.hpp"
#include <algorithm>
#include <cmath>
#include <numbers>

namespace tyndall {

static bool is_finite_colour(const Rgb& value) {
    return std::isfinite(value.x) && std::isfinite(value.y) && std::isfinite(value.z);
}

static std::shared_ptr<const EnvironmentImage> without_broken_pixels(std::shared_ptr<const EnvironmentImage> image) {
    const auto is_whole = [](const vec4& pixel) { return is_finite_colour(Rgb(pixel)); };
    if (std::ranges::all_of(image->pixels, is_whole))
        return image;
    std::vector<vec4> mended(image->pixels.begin(), image->pixels.end());
    for (vec4& pixel : mended)
        if (!is_whole(pixel))
            pixel = vec4(0.0f);
    return std::make_shared<const EnvironmentImage>(image->name, image->width, image->height, std::move(mended));
}

World::World(std::string name, Rgb radiance, std::shared_ptr<const EnvironmentImage> image, mat3 image_from_world,
             SeenWorld seen)
    : name_(std::move(name)), radiance_(radiance), image_(std::move(image)), seen_(std::move(seen)),
      image_from_world_(image_from_world) {
    is_black_ = radiance_ == Rgb(0.0f);
    require(is_finite_colour(radiance_), "world '", name_, "': its radiance is not finite");
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
    importance_ = std::make_shared<const EnvironmentImportance>(*image_);
    is_black_ |= std::ranges::all_of(image_->pixels, [](const vec4& pixel) { return Rgb(pixel) == Rgb(0.0f); });
}

/// Position in the image, [0, 1]^2, of a unit direction in the image's space.
static vec2 uv_of(const vec3& direction) {
    constexpr float inverse_pi = std::numbers::inv_pi_v<float>;
    const float longitude = angle_of(direction.y, direction.x);
    const float latitude = angle_of(direction.z, std::sqrt(direction.x * direction.x + direction.y * direction.y));
    return {0.5f - 0.5f * inverse_pi * longitude, inverse_pi * latitude + 0.5f};
}

static Rgb bilinear(const EnvironmentImage& image, vec2 uv) {
    const vec2 corner = uv * vec2(static_cast<float>(image.width), static_cast<float>(image.height)) - 0.5f;
    const vec2 whole = glm::floor(corner);
    const vec2 share = corner - whole;
    // One step past either end at most: no division.
    const auto wrap = [](std::int32_t texel, std::uint32_t unsigned_count) {
        const auto count = static_cast<std::int32_t>(unsigned_count);
        return static_cast<std::size_t>(texel < 0 ? count - 1 : texel >= count ? 0 : texel);
    };
    const auto column = static_cast<std::int32_t>(whole.x), row = static_cast<std::int32_t>(whole.y);
    const std::size_t left = wrap(column, image.width), right = wrap(column + 1, image.width);
    const vec4* lower = &image.pixels[wrap(row, image.height) * image.width];
    const vec4* upper = &image.pixels[wrap(row + 1, image.height) * image.width];
    return Rgb(
        glm::mix(glm::mix(lower[left], lower[right], share.x), glm::mix(upper[left], upper[right], share.x), share.y));
}

Rgb World::radiance(const vec3& unit_direction) const {
    if (image_ == nullptr)
        return radiance_;
    return radiance_ * bilinear(*image_, uv_of(image_from_world_ * unit_direction));
}

Rgb World::seen_radiance(const vec3& unit_direction, RayKind kind) const {
    if (seen_.program != nullptr)
        return seen_.program->radiance(unit_direction, kind);
    if (seen_.image == nullptr || kind != RayKind::Camera)
        return radiance(unit_direction);
    return radiance_ * bilinear(*seen_.image, uv_of(image_from_world_ * unit_direction));
}

World::DirectionSample World::sample(vec2 u) const {
    if (image_ == nullptr) {
        const vec3 direction = sample_uniform_sphere(u);
        return {direction, 0.25f / pi, radiance_};
    }
    const auto [uv, height, pdf_per_sr] = importance_->sample(u);
    const auto radius = static_cast<float>(std::sqrt(std::max(0.0, 1.0 - height * height)));
    const float longitude = (0.5f - uv.x) * 2.0f * pi;
    const vec3 in_image(radius * std::cos(longitude), radius * std::sin(longitude), static_cast<float>(height));
    return {glm::transpose(image_from_world_) * in_image, pdf_per_sr, radiance_ * bilinear(*image_, uv)};
}

float World::pdf_per_sr(const vec3& unit_direction) const {
    return image_ == nullptr ? 0.25f / pi : importance_->pdf_per_sr(uv_of(image_from_world_ * unit_direction));
}

World::Look World::look(const vec3& unit_direction) const {
    if (image_ == nullptr)
        return {radiance_, 0.25f / pi};
    const vec2 uv = uv_of(image_from_world_ * unit_direction);
    return {radiance_ * bilinear(*image_, uv), importance_->pdf_per_sr(uv)};
}
} // namespace tyndall
