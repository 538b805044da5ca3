// SPDX-License-Identifier: GPL-3.0-or-later
// The stretch of a view ray that lies in media, in front of its surface.
#pragma once
#include "light_shafts/light_shafts.hpp"
#include <vector>

namespace tyndall::light_shafts {
struct MediaRay {
    ViewRay clipped;
    float length_in_media_m = 0.0f;
};

/// Appends the segments of a ray; in the world's medium an endless ray ends where 1e-17 of its light would be left.
MediaRay clip_to_media(const Media& media, const ViewRay& ray, std::vector<MediumSegment>& segments);
} // namespace tyndall::light_shafts
