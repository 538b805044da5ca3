// SPDX-License-Identifier: GPL-3.0-or-later
#include "light_shafts/strip_kernel.hpp"
#include "light_shafts/strip_shapes.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "light_shafts/strip_kernel.cpp"
#include <hwy/foreach_target.h> // compiles this file once per instruction set
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace tyndall::light_shafts::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;
using Floats = hn::CappedTag<float, WideBvh::width>;
using Vec = hn::Vec<Floats>;

HWY_ATTR static std::uint32_t mask_bits(const hn::Mask<Floats> mask) {
    std::uint8_t bytes[8] = {};
    hn::StoreMaskBits(Floats(), mask, bytes);
    return static_cast<std::uint32_t>(bytes[0] | (bytes[1] << 8));
}

/// A linear function of object-space points, with what it takes to bound it over a box.
struct Functional {
    float x, y, z, offset;
    float margin; ///< Of the rounding of its value at any point of the mesh.

    static Functional from(const Covector<double>& covector, const vec3& reach) {
        Functional result{static_cast<float>(covector.direction.x), static_cast<float>(covector.direction.y),
                          static_cast<float>(covector.direction.z), static_cast<float>(covector.offset), 0.0f};
        constexpr float eps = 8.0f * 6e-8f; // 3 multiply-adds, at the centre and for the extent
        result.margin = eps * (std::abs(result.x) * reach.x + std::abs(result.y) * reach.y +
                               std::abs(result.z) * reach.z + std::abs(result.offset));
        return result;
    }
    HWY_ATTR Vec at(const Vec px, const Vec py, const Vec pz) const {
        const Floats d;
        return hn::MulAdd(hn::Set(d, x), px,
                          hn::MulAdd(hn::Set(d, y), py, hn::MulAdd(hn::Set(d, z), pz, hn::Set(d, offset))));
    }
    /// Half of its range over a box with these half extents, and the margin.
    HWY_ATTR Vec reach_over(const Vec ex, const Vec ey, const Vec ez) const {
        const Floats d;
        return hn::MulAdd(
            hn::Set(d, std::abs(x)), ex,
            hn::MulAdd(hn::Set(d, std::abs(y)), ey, hn::MulAdd(hn::Set(d, std::abs(z)), ez, hn::Set(d, margin))));
    }
};

/// x + slope * y - at: positive beyond the line from the light through the ray's point `at`.
static Covector<double> beyond(const PlaneCoordinates<double>& plane, double slope, double at) {
    return {plane.x.direction + slope * plane.y.direction, plane.x.offset + slope * plane.y.offset - at};
}

/// One mesh in its object's space.
template <bool is_local>
class MeshStrip {
public:
    MeshStrip(const PlaneCoordinates<double>& plane, const StripRay& ray, const vec3& reach, ShadowUnion& shadow)
        : plane_(plane), ray_(ray), reach_(reach), shadow_(shadow), height_(Functional::from(plane.height, reach)),
          x_(Functional::from(plane.x, reach)), y_(Functional::from(plane.y, reach)) {
        if constexpr (!is_local)
            beyond_near_ = Functional::from(beyond(plane, -double{ray.cotangent}, 0.0), reach);
        follow_open_ends();
    }

    /// Bit c: child c of the node may shadow what is still open. near/far: a directional light's shadow of the box.
    HWY_ATTR std::uint32_t test(const WideBvh::Node& node, float* HWY_RESTRICT near_m, float* HWY_RESTRICT far_m) {
        const Floats d;
        if constexpr (is_local)
            follow_open_ends();
        std::uint32_t passed = 0;
        for (std::size_t lane = 0; lane < WideBvh::width; lane += hn::Lanes(d)) {
            const Vec cx = hn::Load(d, node.centre[0] + lane), ex = hn::Load(d, node.half_extent[0] + lane);
            const Vec cy = hn::Load(d, node.centre[1] + lane), ey = hn::Load(d, node.half_extent[1] + lane);
            const Vec cz = hn::Load(d, node.centre[2] + lane), ez = hn::Load(d, node.half_extent[2] + lane);
            auto hit = hn::Le(hn::Abs(height_.at(cx, cy, cz)), height_.reach_over(ex, ey, ez));
            hit = hn::And(hit, hn::Ge(hn::Add(y_.at(cx, cy, cz), y_.reach_over(ex, ey, ez)), hn::Zero(d)));
            const Vec t = beyond_near_.at(cx, cy, cz), extent = beyond_near_.reach_over(ex, ey, ez);
            if constexpr (is_local) {
                hit = hn::And(hit, hn::Ge(hn::Add(t, extent), hn::Zero(d)));
                hit = hn::And(
                    hit, hn::Le(hn::Sub(beyond_far_.at(cx, cy, cz), beyond_far_.reach_over(ex, ey, ez)), hn::Zero(d)));
            } else {
                const Vec first = hn::Sub(t, extent), last = hn::Add(t, extent);
                hit = hn::And(hit, hn::And(hn::Gt(last, hn::Set(d, shadow_.open_near_m())),
                                           hn::Lt(first, hn::Set(d, shadow_.open_far_m()))));
                const auto is_shadowed = hn::And(hn::Ge(first, hn::Set(d, shadow_.longest().near_m)),
                                                 hn::Le(last, hn::Set(d, shadow_.longest().far_m)));
                hit = hn::AndNot(is_shadowed, hit);
                hn::Store(first, d, near_m + lane);
                hn::Store(last, d, far_m + lane);
            }
            passed |= mask_bits(hit) << lane;
        }
        return passed;
    }

    /// Whether a directional light's shadow [near_m, far_m] of a box can still change anything.
    [[nodiscard]] bool is_open(float near_m, float far_m) const {
        if constexpr (is_local)
            return true;
        return far_m > shadow_.open_near_m() && near_m < shadow_.open_far_m() &&
               !(near_m >= shadow_.longest().near_m && far_m <= shadow_.longest().far_m);
    }

    /// Cuts 16 triangles. Calls keep(lane, near_m, far_m) for each that shadows part of what is open.
    template <typename Keep>
    HWY_ATTR void cut(const TriangleBvh::Block& block, const Keep& keep) {
        const Floats d;
        const Vec zero = hn::Zero(d);
        for (std::size_t lane = 0; lane < WideBvh::width; lane += hn::Lanes(d)) {
            const auto corner = [&](int index, int axis)
                                    HWY_ATTR { return hn::Load(d, block.corner[index][axis] + lane); };
            const Vec h0 = height_.at(corner(0, 0), corner(0, 1), corner(0, 2));
            const Vec h1 = height_.at(corner(1, 0), corner(1, 1), corner(1, 2));
            const Vec h2 = height_.at(corner(2, 0), corner(2, 1), corner(2, 2));
            const auto above0 = hn::Ge(h0, zero), above1 = hn::Ge(h1, zero), above2 = hn::Ge(h2, zero);
            const auto differs01 = hn::Xor(above0, above1), differs02 = hn::Xor(above0, above2);
            auto hit = hn::Or(differs01, differs02);
            if (hn::AllFalse(d, hit))
                continue;
            const Vec x0 = x_.at(corner(0, 0), corner(0, 1), corner(0, 2));
            const Vec x1 = x_.at(corner(1, 0), corner(1, 1), corner(1, 2));
            const Vec x2 = x_.at(corner(2, 0), corner(2, 1), corner(2, 2));
            const Vec y0 = y_.at(corner(0, 0), corner(0, 1), corner(0, 2));
            const Vec y1 = y_.at(corner(1, 0), corner(1, 1), corner(1, 2));
            const Vec y2 = y_.at(corner(2, 0), corner(2, 1), corner(2, 2));
            // The corner that is alone on its side: 0 where both others differ from it, 1 where only it differs from 0.
            const auto is_lone0 = hn::And(differs01, differs02), is_lone1 = hn::AndNot(differs02, differs01);
            const auto lone = [&](const Vec a, const Vec b, const Vec c)
                                  HWY_ATTR { return hn::IfThenElse(is_lone0, a, hn::IfThenElse(is_lone1, b, c)); };
            const Vec hl = lone(h0, h1, h2), xl = lone(x0, x1, x2), yl = lone(y0, y1, y2);
            const Vec hm = lone(h1, h2, h0), xn = lone(x1, x2, x0), yn = lone(y1, y2, y0);
            const Vec hp = lone(h2, h0, h1), xp = lone(x2, x0, x1), yp = lone(y2, y0, y1);
            // (b ha - a hb) / (ha - hb): the same bits for either order of the edge's ends, so no fused operations here.
            const Vec to_next = hn::Div(hn::Set(d, 1.0f), hn::Sub(hl, hm));
            const Vec to_last = hn::Div(hn::Set(d, 1.0f), hn::Sub(hl, hp));
            const Vec xa = hn::Mul(hn::Sub(hn::Mul(xn, hl), hn::Mul(xl, hm)), to_next);
            const Vec ya = hn::Mul(hn::Sub(hn::Mul(yn, hl), hn::Mul(yl, hm)), to_next);
            const Vec xb = hn::Mul(hn::Sub(hn::Mul(xp, hl), hn::Mul(xl, hp)), to_last);
            const Vec yb = hn::Mul(hn::Sub(hn::Mul(yp, hl), hn::Mul(yl, hp)), to_last);
            // Only the part between the ray and the light.
            hit = hn::And(hit, hn::Gt(hn::Max(ya, yb), zero));
            const Vec rise = hn::Div(hn::Set(d, 1.0f), hn::Sub(yb, ya));
            const Vec on_ray = hn::Mul(hn::Sub(hn::Mul(xa, yb), hn::Mul(xb, ya)), rise);
            const auto a_is_below = hn::Lt(ya, zero), b_is_below = hn::Lt(yb, zero);
            Vec ax = hn::IfThenElse(a_is_below, on_ray, xa), ay = hn::Max(ya, zero);
            Vec bx = hn::IfThenElse(b_is_below, on_ray, xb), by = hn::Max(yb, zero);
            Vec first, last;
            if constexpr (is_local) {
                const Vec top = hn::Set(d, ray_.light_y * (1.0f - 1e-6f));
                hit = hn::And(hit, hn::Lt(hn::Min(ya, yb), top));
                const Vec above_a = hn::Sub(ya, top), above_b = hn::Sub(yb, top);
                const Vec at_top = hn::Mul(hn::Sub(hn::Mul(xa, above_b), hn::Mul(xb, above_a)), rise);
                ax = hn::IfThenElse(hn::Gt(above_a, zero), at_top, ax);
                bx = hn::IfThenElse(hn::Gt(above_b, zero), at_top, bx);
                ay = hn::Min(ay, top), by = hn::Min(by, top);
                first = from_light(ax, ay), last = from_light(bx, by);
            } else {
                const Vec cotangent = hn::Set(d, ray_.cotangent);
                first = hn::NegMulAdd(cotangent, ay, ax), last = hn::NegMulAdd(cotangent, by, bx);
            }
            const Vec near_m = hn::Min(first, last), far_m = hn::Max(first, last);
            hit = hn::And(hit, hn::And(hn::Gt(far_m, hn::Set(d, shadow_.open_near_m())),
                                       hn::Lt(near_m, hn::Set(d, shadow_.open_far_m()))));
            std::uint32_t bits = mask_bits(hit);
            if (bits == 0)
                continue;
            HWY_ALIGN float nears[WideBvh::width], fars[WideBvh::width];
            hn::Store(near_m, d, nears);
            hn::Store(far_m, d, fars);
            for (; bits != 0; bits &= bits - 1) {
                const auto bit = static_cast<std::size_t>(__builtin_ctz(bits));
                keep(lane + bit, nears[bit], fars[bit]);
            }
        }
    }

private:
    /// Where the light casts a point of the plane onto the ray.
    HWY_ATTR Vec from_light(const Vec x, const Vec y) const {
        const Floats d;
        const Vec light_x = hn::Set(d, ray_.light_x), light_y = hn::Set(d, ray_.light_y);
        // Written around x: exact for points on the ray, however far away the light is.
        return hn::Add(x, hn::Div(hn::Mul(y, hn::Sub(x, light_x)), hn::Sub(light_y, y)));
    }

    /// A local light sees what is open in a wedge: its two sides move inwards with the shadow's ends.
    void follow_open_ends() {
        if constexpr (is_local) {
            if (shadow_.open_near_m() == seen_near_m_ && shadow_.open_far_m() == seen_far_m_)
                return;
            seen_near_m_ = shadow_.open_near_m(), seen_far_m_ = shadow_.open_far_m();
            const auto side = [&](double at) {
                const double slope = (at - double{ray_.light_x}) / double{ray_.light_y};
                return Functional::from(beyond(plane_, slope, at), reach_);
            };
            beyond_near_ = side(double{seen_near_m_}), beyond_far_ = side(double{seen_far_m_});
        }
    }

    const PlaneCoordinates<double>& plane_;
    const StripRay& ray_;
    vec3 reach_;
    ShadowUnion& shadow_;
    Functional height_, x_, y_;
    Functional beyond_near_{}, beyond_far_{}; ///< Directional: beyond_near_ is the distance along the ray itself.
    float seen_near_m_ = std::numeric_limits<float>::quiet_NaN(), seen_far_m_ = seen_near_m_;
};

struct StackEntry {
    std::uint32_t node;
    float near_m, far_m;
};
/// Calls leaf(index) for each leaf that may matter; leaves of a node come before its inner children.
template <typename Strip, typename Leaf>
HWY_ATTR void traverse(std::span<const WideBvh::Node> nodes, std::uint32_t depth, Strip& strip, ShadowUnion& shadow,
                       std::uint64_t& node_count, const Leaf& leaf) {
    thread_local std::vector<StackEntry> stack; // one per kind of leaf: a mesh is traversed from within a scene
    stack.resize(std::max<std::size_t>(stack.size(), depth * WideBvh::width + 1));
    std::size_t height = 0;
    stack[height++] = {0, shadow.open_near_m(), shadow.open_far_m()};
    HWY_ALIGN float near_m[WideBvh::width] = {}, far_m[WideBvh::width] = {};
    while (height > 0) {
        const StackEntry entry = stack[--height];
        if (shadow.is_complete())
            break;
        if (!strip.is_open(entry.near_m, entry.far_m))
            continue;
        const WideBvh::Node& node = nodes[entry.node];
        ++node_count;
        for (std::uint32_t bits = strip.test(node, near_m, far_m); bits != 0; bits &= bits - 1) {
            const auto child = static_cast<std::size_t>(__builtin_ctz(bits));
            if ((node.child[child] & WideBvh::leaf_bit) == 0)
                stack[height++] = {node.child[child], near_m[child], far_m[child]};
            else if (strip.is_open(near_m[child], far_m[child]))
                leaf(node.child[child] & ~WideBvh::leaf_bit);
        }
    }
}

template <bool is_local>
HWY_ATTR void find(const StripScene& scene, const StripRay& ray, StripShadows& shadows) {
    ShadowUnion& opaque = shadows.opaque;
    const auto keep = [&](std::uint32_t index, std::uint32_t triangle, float near_m, float far_m) {
        const StripMesh& mesh = scene.meshes[index];
        if (!mesh.occlusion_of_slot.empty()) {
            const std::size_t slot = mesh.slot_of_triangle.empty() ? 0 : mesh.slot_of_triangle[triangle];
            const Occlusion occlusion = mesh.occlusion_of_slot[std::min(slot, mesh.occlusion_of_slot.size() - 1)];
            if (occlusion == Occlusion::Partial)
                shadows.partial.push_back({index, triangle, near_m, far_m});
            if (occlusion != Occlusion::Opaque)
                return;
        }
        opaque.insert(near_m, far_m);
    };
    const auto cut_mesh = [&](std::uint32_t index) HWY_ATTR {
        const StripMesh& mesh = scene.meshes[index];
        const PlaneCoordinates<double> plane = ray.coordinates.in_object(mesh.world_from_object);
        MeshStrip<is_local> strip(plane, ray, mesh.bvh->reach(), opaque);
        traverse(mesh.bvh->nodes(), mesh.bvh->depth(), strip, opaque, shadows.counters.nodes,
                 [&](std::uint32_t leaf) HWY_ATTR {
                     for (const TriangleBvh::Block& block : mesh.bvh->blocks_of(leaf)) {
                         ++shadows.counters.blocks;
                         strip.cut(block, [&](std::size_t lane, float near_m, float far_m) {
                             keep(index, block.triangle[lane], near_m, far_m);
                         });
                     }
                 });
    };
    const auto cut_object = [&](std::uint32_t index) HWY_ATTR {
        if (index < scene.meshes.size()) {
            cut_mesh(index);
            return;
        }
        const StripShape& placed = scene.shapes[index - scene.meshes.size()];
        add_shape_shadows(*placed.shape, placed.world_from_object, ray, opaque);
    };
    if (scene.object_count() <= 2) { // their own roots say as much as a hierarchy over them
        for (std::uint32_t object = 0; object < scene.object_count() && !opaque.is_complete(); ++object)
            cut_object(object);
        return;
    }
    MeshStrip<is_local> strip(ray.coordinates, ray, scene.top_reach, opaque);
    traverse(scene.top.nodes(), scene.top.depth(), strip, opaque, shadows.counters.nodes,
             [&](std::uint32_t leaf) HWY_ATTR { cut_object(scene.top.leaves()[leaf].primitives[0]); });
}

static void FindShadows(const StripScene& scene, const StripRay& ray, StripShadows& shadows) {
    if (ray.is_local)
        find<true>(scene, ray, shadows);
    else
        find<false>(scene, ray, shadows);
}
} // namespace tyndall::light_shafts::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace tyndall::light_shafts {
HWY_EXPORT(FindShadows);
void find_shadows(const StripScene& scene, const StripRay& ray, StripShadows& shadows) {
    shadows.opaque.reset(ray.near_m, ray.far_m);
    shadows.partial.clear();
    HWY_DYNAMIC_DISPATCH(FindShadows)(scene, ray, shadows);
}
} // namespace tyndall::light_shafts
#endif
