// SPDX-License-Identifier: GPL-3.0-or-later
#include "scene/wide_bvh.hpp"
#include "core/parallel.hpp"
#include <memory>
#include <new>

namespace tyndall {
namespace {
/// Embree's callbacks make a tree of these; it lives in Embree's allocator until it is flattened.
struct Item {
    bool is_leaf;
};
struct Branch : Item {
    Branch() : Item{false} {}
    std::uint32_t count = 0;
    Bounds3 bounds[WideBvh::width];
    Item* children[WideBvh::width];
};
struct Twig : Item {
    Twig() : Item{true} {}
    WideBvh::Leaf leaf;
    Bounds3 bounds;
};

Bounds3 to_bounds(const RTCBounds& bounds) {
    return {.min = vec3(bounds.lower_x, bounds.lower_y, bounds.lower_z),
            .max = vec3(bounds.upper_x, bounds.upper_y, bounds.upper_z)};
}

Branch& as_branch(void* item) { return *static_cast<Branch*>(static_cast<Item*>(item)); }

void* create_node(RTCThreadLocalAllocator allocator, unsigned count, void*) {
    auto* branch = new (rtcThreadLocalAlloc(allocator, sizeof(Branch), 16)) Branch;
    branch->count = count;
    return static_cast<Item*>(branch);
}
void set_children(void* node, void** children, unsigned count, void*) {
    for (unsigned child = 0; child < count; ++child)
        as_branch(node).children[child] = static_cast<Item*>(children[child]);
}
void set_bounds(void* node, const RTCBounds** bounds, unsigned count, void*) {
    for (unsigned child = 0; child < count; ++child)
        as_branch(node).bounds[child] = to_bounds(*bounds[child]);
}
void* create_leaf(RTCThreadLocalAllocator allocator, const RTCBuildPrimitive* primitives, std::size_t count, void*) {
    auto* twig = new (rtcThreadLocalAlloc(allocator, sizeof(Twig), 16)) Twig;
    twig->leaf.count = static_cast<std::uint32_t>(count);
    for (std::size_t index = 0; index < count; ++index) {
        const RTCBuildPrimitive& primitive = primitives[index];
        twig->leaf.primitives[index] = primitive.primID;
        twig->bounds.grow({.min = vec3(primitive.lower_x, primitive.lower_y, primitive.lower_z),
                           .max = vec3(primitive.upper_x, primitive.upper_y, primitive.upper_z)});
    }
    return static_cast<Item*>(twig);
}
bool report_progress(void* progress, double) { return !static_cast<const Progress*>(progress)->is_cancelled(); }

void set_box(WideBvh::Node& node, std::size_t child, const Bounds3& box) {
    for (int axis = 0; axis < 3; ++axis) {
        const float centre = 0.5f * box.min[axis] + 0.5f * box.max[axis];
        node.centre[axis][child] = centre;
        // One step of rounding outwards keeps the box conservative.
        node.half_extent[axis][child] =
            std::nextafter(std::max(box.max[axis] - centre, centre - box.min[axis]), std::numeric_limits<float>::max());
    }
}
} // namespace

WideBvh::WideBvh(RTCDevice device, std::span<const Bounds3> boxes, std::size_t leaf_size, const Progress& progress) {
    if (boxes.empty())
        return;
    std::vector<RTCBuildPrimitive> primitives(boxes.size());
    parallel_for(boxes.size(), progress, [&](std::size_t index) {
        const auto& [min, max] = boxes[index];
        primitives[index] = {min.x, min.y, min.z, 0, max.x, max.y, max.z, static_cast<unsigned>(index)};
    });
    const std::unique_ptr<RTCBVHTy, void (*)(RTCBVH)> bvh(rtcNewBVH(device), rtcReleaseBVH);
    RTCBuildArguments arguments = rtcDefaultBuildArguments();
    arguments.buildQuality = RTC_BUILD_QUALITY_MEDIUM;
    arguments.maxBranchingFactor = width;
    arguments.sahBlockSize = static_cast<unsigned>(leaf_size);
    // Full leaves: a step costs the same for one primitive as for 16. Left to itself, the builder stops at 3.
    arguments.minLeafSize = arguments.maxLeafSize = static_cast<unsigned>(leaf_size);
    arguments.bvh = bvh.get();
    arguments.primitives = primitives.data();
    arguments.primitiveCount = arguments.primitiveArrayCapacity = primitives.size();
    arguments.createNode = create_node;
    arguments.setNodeChildren = set_children;
    arguments.setNodeBounds = set_bounds;
    arguments.createLeaf = create_leaf;
    arguments.buildProgress = report_progress;
    arguments.userPtr = const_cast<Progress*>(&progress);
    auto* root = static_cast<Item*>(rtcBuildBVH(&arguments));
    progress.poll();
    require(root != nullptr, "Embree could not build a hierarchy over ", boxes.size(), " boxes");

    Branch only; // a tree of one leaf gets a node above it
    if (root->is_leaf) {
        only.count = 1;
        only.children[0] = root;
        only.bounds[0] = static_cast<Twig*>(root)->bounds;
        root = &only;
    }
    // Depth first: the first child of a node lies next to it in memory.
    const auto flatten = [&](const auto& self, const Branch& branch, std::uint32_t level) -> std::uint32_t {
        const auto index = static_cast<std::uint32_t>(nodes_.size());
        nodes_.emplace_back();
        depth_ = std::max(depth_, level);
        for (std::size_t child = 0; child < width; ++child) {
            if (child >= branch.count) {
                for (int axis = 0; axis < 3; ++axis) {
                    nodes_[index].centre[axis][child] = 0.0f;
                    nodes_[index].half_extent[axis][child] = -std::numeric_limits<float>::infinity();
                }
                nodes_[index].child[child] = leaf_bit;
                continue;
            }
            set_box(nodes_[index], child, branch.bounds[child]);
            if (branch.children[child]->is_leaf) {
                nodes_[index].child[child] = leaf_bit | static_cast<std::uint32_t>(leaves_.size());
                leaves_.push_back(static_cast<const Twig*>(branch.children[child])->leaf);
            } else {
                const std::uint32_t at = self(self, static_cast<const Branch&>(*branch.children[child]), level + 1);
                nodes_[index].child[child] = at;
            }
        }
        return index;
    };
    flatten(flatten, static_cast<const Branch&>(*root), 1);
}
} // namespace tyndall
