// SPDX-License-Identifier: GPL-3.0-or-later
#include "voxel_dag/vox_scene.hpp"
#include "core/errors.hpp"
#include "voxel_dag/numbered_values.hpp"
#include <algorithm>
#include <bit>
#include <limits>
#include <numeric>

namespace tyndall::voxel_dag::vox {
namespace {
using Place = std::array<std::int64_t, 3>;

/// Axis i of the image is axis `axis[i]` of what is turned, times `sign[i]`, moved by shift[i].
struct Motion {
    std::array<std::size_t, 3> axis{0, 1, 2};
    Place sign{1, 1, 1}, shift{};
};
Motion motion_of(const Node& transform) {
    const std::size_t first = transform.rotation & 3u, second = transform.rotation >> 2 & 3u;
    Motion motion{.axis = {first, second, 3 - first - second}};
    for (std::size_t row = 0; row < 3; ++row) {
        motion.sign[row] = (transform.rotation >> (4 + row) & 1) != 0 ? -1 : 1;
        motion.shift[row] = transform.translation[row];
    }
    return motion;
}
Motion operator*(const Motion& outer, const Motion& inner) {
    Motion product;
    for (std::size_t row = 0; row < 3; ++row) {
        const std::size_t axis = outer.axis[row];
        product.axis[row] = inner.axis[axis];
        product.sign[row] = outer.sign[row] * inner.sign[axis];
        product.shift[row] = outer.sign[row] * inner.shift[axis] + outer.shift[row];
    }
    return product;
}

struct Placement {
    std::size_t model;
    Motion motion;
};
/// A voxel is the cube from its number to the next: mirrored, v becomes -v - 1.
Place placed(const Model& model, const Motion& motion, const ModelVoxel& voxel) {
    const Place at{voxel.x, voxel.y, voxel.z};
    Place place;
    for (std::size_t row = 0; row < 3; ++row) {
        const std::size_t axis = motion.axis[row];
        const std::int64_t from_middle = at[axis] - static_cast<std::int64_t>(model.sides[axis] / 2);
        place[row] = (motion.sign[row] > 0 ? from_middle : -from_middle - 1) + motion.shift[row];
    }
    return place;
}

class GraphWalk {
public:
    GraphWalk(const File& file, const Progress& progress) : file_(file), progress_(progress) {}
    std::vector<Placement> placements() {
        visit(0, {}, 0);
        return std::move(placements_);
    }

private:
    static constexpr std::size_t most_depth = 1000, most_visits = std::size_t{1} << 22;

    void visit(std::int32_t number, const Motion& motion, std::size_t depth) {
        const auto found = file_.nodes.find(number);
        require(found != file_.nodes.end(), "the scene graph names node ", number, ", which is not there");
        const Node& node = found->second;
        const std::string_view chunk = node.kind == NodeKind::Transform ? "nTRN"
                                       : node.kind == NodeKind::Group   ? "nGRP"
                                                                        : "nSHP";
        require(depth < most_depth, "chunk ", chunk, ", node ", number, ": the scene graph goes in circles there");
        require(++visit_count_ <= most_visits, "the scene graph places more than ", most_visits, " nodes");
        if (visit_count_ % 4096 == 0)
            progress_.poll();
        const auto layer = file_.is_hidden.find(node.layer);
        if (node.is_hidden || (layer != file_.is_hidden.end() && layer->second))
            return;
        const Motion below = node.kind == NodeKind::Transform ? motion * motion_of(node) : motion;
        for (const std::int32_t child : node.children) {
            if (node.kind != NodeKind::Shape) {
                visit(child, below, depth + 1);
                continue;
            }
            require(0 <= child && static_cast<std::size_t>(child) < file_.models.size(), "chunk ", chunk, ", node ",
                    number, ": model ", child, " is not there");
            if (!file_.models[static_cast<std::size_t>(child)].voxels.empty())
                placements_.push_back({static_cast<std::size_t>(child), below});
        }
    }
    const File& file_;
    const Progress& progress_;
    std::vector<Placement> placements_;
    std::size_t visit_count_ = 0;
};

std::vector<Placement> placements_in(const File& file, const Progress& progress) {
    if (!file.nodes.empty())
        return GraphWalk(file, progress).placements();
    require(!file.models.empty(), "it has no model");
    if (file.models.front().voxels.empty())
        return {};
    Motion from_zero;
    for (std::size_t axis = 0; axis < 3; ++axis)
        from_zero.shift[axis] = file.models.front().sides[axis] / 2;
    return {{0, from_zero}};
}

/// Lowest and highest voxel, both inclusive.
struct Box {
    Place lower, upper;
    void include(const Place& place) {
        for (std::size_t axis = 0; axis < 3; ++axis) {
            lower[axis] = std::min(lower[axis], place[axis]);
            upper[axis] = std::max(upper[axis], place[axis]);
        }
    }
};
constexpr Box no_box{{std::numeric_limits<std::int64_t>::max(), std::numeric_limits<std::int64_t>::max(),
                      std::numeric_limits<std::int64_t>::max()},
                     {std::numeric_limits<std::int64_t>::min(), std::numeric_limits<std::int64_t>::min(),
                      std::numeric_limits<std::int64_t>::min()}};

Box box_of(const File& file, const std::vector<Placement>& placements) {
    struct Corners {
        ModelVoxel lower{255, 255, 255, 0}, upper{0, 0, 0, 0};
    };
    std::vector<Corners> corners_of_model(file.models.size());
    for (std::size_t model = 0; model < file.models.size(); ++model)
        for (auto& [lower, upper] = corners_of_model[model]; const ModelVoxel& voxel : file.models[model].voxels) {
            lower.x = std::min(lower.x, voxel.x), upper.x = std::max(upper.x, voxel.x);
            lower.y = std::min(lower.y, voxel.y), upper.y = std::max(upper.y, voxel.y);
            lower.z = std::min(lower.z, voxel.z), upper.z = std::max(upper.z, voxel.z);
        }
    Box box = no_box;
    for (const auto& [model, motion] : placements)
        for (const auto& [lower, upper] = corners_of_model[model]; const ModelVoxel& corner : {lower, upper})
            box.include(placed(file.models[model], motion, corner));
    return box;
}

/// Voxels with indices of the palette, brick by brick as they come.
class ColoredBricks {
public:
    ColoredBricks(const Place& lower, std::uint64_t memory_budget_bytes)
        : lower_(lower), memory_budget_bytes_(memory_budget_bytes) {}

    void add(const Model& model, const Motion& motion, const Progress& progress) {
        constexpr std::size_t voxels_between_polls = std::size_t{1} << 18;
        for (std::size_t i = 0; i < model.voxels.size(); ++i) {
            if (i % voxels_between_polls == 0)
                progress.poll();
            const Place place = placed(model, motion, model.voxels[i]);
            Voxel voxel;
            for (std::size_t axis = 0; axis < 3; ++axis)
                voxel[axis] = static_cast<std::uint32_t>(place[axis] - lower_[axis]);
            const std::uint64_t code = morton_code(voxel);
            Brick& brick = brick_at(code >> 3 * leaf_level);
            brick.mask |= std::uint64_t{1} << (code & 63);
            brick.colors[code & 63] = model.voxels[i].color;
        }
    }
    SceneVoxels taken(std::uint32_t level, const File& file, const Progress& progress) const {
        SceneVoxels scene{.leaves = {.level = level, .codes = {}, .masks = {}}, .lower = lower_, .attributes = {}};
        const std::vector<std::uint64_t>& codes = numbers_.values();
        std::vector<std::uint32_t> order(bricks_.size());
        std::iota(order.begin(), order.end(), 0u);
        std::ranges::sort(order, {}, [&](std::uint32_t brick) { return codes[brick]; });
        std::uint64_t voxel_count = 0;
        std::array<bool, 256> is_used{};
        for (const std::uint32_t brick : order) {
            scene.leaves.codes.push_back(codes[brick]);
            scene.leaves.masks.push_back(bricks_[brick].mask);
            voxel_count += static_cast<std::uint64_t>(std::popcount(bricks_[brick].mask));
            for (std::uint64_t left = bricks_[brick].mask; left != 0; left &= left - 1)
                is_used[bricks_[brick].colors[static_cast<std::size_t>(std::countr_zero(left))]] = true;
        }
        check_budget(voxel_count);
        const auto per_voxel = [&]<typename Value>(const std::array<Value, 256>& of_color) {
            progress.poll();
            std::vector<Value> values;
            values.reserve(voxel_count);
            for (const std::uint32_t brick : order)
                for (std::uint64_t left = bricks_[brick].mask; left != 0; left &= left - 1)
                    values.push_back(of_color[bricks_[brick].colors[static_cast<std::size_t>(std::countr_zero(left))]]);
            return values;
        };
        scene.attributes.colors = per_voxel(file.palette);
        const auto add_channel = [&](const char* name, std::uint8_t Material::*value) {
            std::array<std::uint8_t, 256> of_color{};
            bool is_needed = false;
            for (std::size_t color = 0; color < 256; ++color) {
                of_color[color] = file.materials[color].*value;
                is_needed = is_needed || (is_used[color] && of_color[color] != Material().*value);
            }
            if (is_needed)
                scene.attributes.channels.push_back({name, per_voxel(of_color)});
        };
        add_channel("roughness", &Material::roughness);
        add_channel("metallic", &Material::metallic);
        add_channel("emission", &Material::emission);
        return scene;
    }

private:
    struct Brick {
        std::uint64_t mask = 0;
        std::array<std::uint8_t, 64> colors{};
    };
    Brick& brick_at(std::uint64_t code) {
        if (code != last_code_) { // runs along x, y or z stay in theirs
            last_ = numbers_.number_of(code);
            last_code_ = code;
            if (last_ == bricks_.size()) {
                bricks_.emplace_back();
                check_budget(0);
            }
        }
        return bricks_[last_];
    }
    /// 64 for indices, 8 for the mask, 24 for code and look-up, 16 for the result, and as much as growing takes.
    void check_budget(std::uint64_t voxel_count) const {
        constexpr std::uint64_t brick_bytes = 192, voxel_bytes = sizeof(std::uint32_t) + 3;
        require(bricks_.size() * brick_bytes + voxel_count * voxel_bytes <= memory_budget_bytes_,
                "its voxels take more than ", memory_budget_bytes_,
                " bytes, the memory budget: raise it, or hide a part of the scene");
    }
    Place lower_;
    std::uint64_t memory_budget_bytes_;
    NumberedValues<std::uint64_t> numbers_;
    std::vector<Brick> bricks_;
    std::uint64_t last_code_ = ~std::uint64_t{0};
    std::size_t last_ = 0;
};
} // namespace

SceneVoxels voxels_of(const File& file, const Config& config, const Progress& progress) {
    const std::vector<Placement> placements = placements_in(file, progress);
    if (placements.empty())
        return {};
    const Box box = box_of(file, placements);
    std::int64_t side = 1;
    for (std::size_t axis = 0; axis < 3; ++axis)
        side = std::max(side, box.upper[axis] - box.lower[axis] + 1);
    require(side <= std::int64_t{1} << most_level, "its models span ", side, " voxels; ", 1 << most_level,
            " are possible: move them together, or hide those that are far away");
    constexpr std::uint64_t most_voxels = std::uint64_t{1} << 32; // a minute's work
    std::uint64_t voxel_count = 0;
    for (const auto& [model, motion] : placements)
        voxel_count += file.models[model].voxels.size();
    require(voxel_count <= most_voxels, "its models have ", voxel_count,
            " voxels, each counted wherever it is placed; ", most_voxels, " are possible");
    ColoredBricks bricks(box.lower, config.memory_budget_bytes);
    for (const auto& [model, motion] : placements)
        bricks.add(file.models[model], motion, progress);
    const auto level = static_cast<std::uint32_t>(std::bit_width(static_cast<std::uint64_t>(side - 1)));
    return bricks.taken(std::max(level, leaf_level), file, progress);
}
} // namespace tyndall::voxel_dag::vox
