// SPDX-License-Identifier: GPL-3.0-or-later
#include "voxel_dag/upright.hpp"
#include "core/parallel.hpp"
#include <algorithm>

namespace tyndall::voxel_dag {
namespace {
constexpr std::size_t block = 1 << 10;

/// One for each element that would have something stored as the DAG has it.
class Votes {
public:
    /// For all that `turn` followed by an element of the set undoes.
    void add(std::uint64_t keeping, std::uint32_t turn) {
        const std::uint32_t back = cube_group.inverse[turn];
        for (; keeping != 0; keeping &= keeping - 1)
            ++counts_[cube_group.product[static_cast<std::size_t>(std::countr_zero(keeping))][back]];
    }
    /// The smallest of those that have most.
    [[nodiscard]] std::uint8_t winner() const {
        return static_cast<std::uint8_t>(std::ranges::max_element(counts_) - counts_.begin());
    }

private:
    std::array<std::uint8_t, cube_element_count> counts_{}; ///< 64 leaves of 16^3 at most.
};

class Turning {
public:
    Turning(const Dag& dag, bool has_inner_tags, const std::function<bool(std::size_t, std::uint32_t)>& is_shared,
            const Progress& progress)
        : dag_(dag), has_inner_tags_(has_inner_tags), is_shared_(is_shared), progress_(progress) {}

    Upright run() {
        upright_.has_inner_tags = has_inner_tags_;
        for (const DagLevel& nodes : dag_.levels)
            upright_.turns.emplace_back(nodes.node_count(), std::uint8_t{0});
        upright_.leaf_stabilizers.resize(dag_.leaves.size(), 0);
        if (!dag_.levels.empty())
            upright_.smallest_stabilizers.resize(dag_.levels[0].node_count(), 0);
        if (dag_.symmetry != Symmetry::None) {
            stabilize_leaves();
            if (dag_.levels.size() > 1)
                turn_shared_smallest();
            if (dag_.levels.size() > 2)
                turn_16();
        }
        turn_what_lies_inside();
        return std::move(upright_);
    }

private:
    void stabilize_leaves() {
        const std::uint32_t order = symmetry_order(dag_.symmetry);
        parallel_for(
            dag_.leaves.size(), progress_,
            [&](std::size_t leaf) {
                std::uint64_t keeping = 0;
                for (std::uint32_t element = 0; element < order; ++element)
                    keeping |= std::uint64_t{turned_leaf(element, dag_.leaves[leaf]) == dag_.leaves[leaf]} << element;
                upright_.leaf_stabilizers[leaf] = subgroups().index_of(keeping);
            },
            block);
    }
    [[nodiscard]] std::uint64_t keeping_leaf(std::uint32_t leaf) const {
        return subgroups().members[upright_.leaf_stabilizers[leaf]];
    }

    /// Votes of a node of 8^3 that `turn` turns.
    void add_leaves(std::size_t node, std::uint32_t turn, Votes& votes) const {
        const DagLevel& nodes = dag_.levels[0];
        for (std::size_t at = nodes.first_children[node]; at < nodes.first_children[node + 1]; ++at)
            votes.add(keeping_leaf(nodes.children[at]), cube_group.product[turn][nodes.tag(at)]);
    }
    void turn_shared_smallest() {
        parallel_for(
            dag_.levels[0].node_count(), progress_,
            [&](std::size_t node) {
                if (!is_shared_(0, static_cast<std::uint32_t>(node)))
                    return;
                Votes votes;
                add_leaves(node, 0, votes);
                upright_.turns[0][node] = votes.winner();
                upright_.smallest_stabilizers[node] = subgroups().index_of(keeping_smallest(node));
            },
            block);
    }
    /// Of the elements of the symmetry, those that leave an 8^3 as it is stored.
    [[nodiscard]] std::uint64_t keeping_smallest(std::size_t node) const {
        const DagLevel& nodes = dag_.levels[0];
        const std::uint32_t turn = upright_.turns[0][node];
        std::array<std::uint32_t, 8> leaves{}, turns{}; // by octants as stored; leaves from 1 on
        for (std::uint32_t octant = 0; octant < 8; ++octant)
            if ((nodes.child_masks[node] >> octant & 1) != 0) {
                const std::size_t reference = nodes.reference(node, octant);
                const std::uint32_t there = cube_group.octant[turn][octant];
                leaves[there] = nodes.children[reference] + 1;
                turns[there] = cube_group.product[turn][nodes.tag(reference)];
            }
        const auto is_kept = [&](std::uint32_t element) {
            for (std::uint32_t octant = 0; octant < 8; ++octant) {
                const std::uint32_t there = cube_group.octant[element][octant];
                if (leaves[octant] != leaves[there])
                    return false;
            }
            for (std::uint32_t octant = 0; octant < 8; ++octant) {
                const std::uint32_t there = cube_group.octant[element][octant];
                if (leaves[octant] != 0 &&
                    upright_.brick_turn(leaves[octant] - 1, cube_group.product[element][turns[octant]]) !=
                        upright_.brick_turn(leaves[there] - 1, turns[there]))
                    return false;
            }
            return true;
        };
        std::uint64_t keeping = 1;
        for (std::uint32_t element = 1; element < symmetry_order(dag_.symmetry); ++element)
            keeping |= std::uint64_t{is_kept(element)} << element;
        return keeping;
    }

    void turn_16() {
        const DagLevel& nodes = dag_.levels[1];
        parallel_for(
            nodes.node_count(), progress_,
            [&](std::size_t node) {
                if (!has_inner_tags_ && !is_shared_(1, static_cast<std::uint32_t>(node)))
                    return;
                Votes votes;
                for (std::size_t at = nodes.first_children[node]; at < nodes.first_children[node + 1]; ++at) {
                    const std::uint32_t child = nodes.children[at];
                    if (!is_shared_(0, child))
                        add_leaves(child, nodes.tag(at), votes);
                    else // a tag that changes nothing
                        votes.add(upright_.keeping(child),
                                  cube_group.product[nodes.tag(at)][cube_group.inverse[upright_.turns[0][child]]]);
                }
                upright_.turns[1][node] = votes.winner();
            },
            block);
    }

    void turn_what_lies_inside() {
        for (std::size_t i = dag_.levels.size(); i-- > 0;) {
            std::vector<std::uint8_t>& turns = upright_.turns[i];
            if (i + 1 == dag_.levels.size()) {
                turns[0] = dag_.root_tag;
                continue;
            }
            if (i == 1 && has_inner_tags_)
                continue;
            const DagLevel& above = dag_.levels[i + 1];
            parallel_for(above.node_count(), progress_, [&](std::size_t node) {
                for (std::size_t at = above.first_children[node]; at < above.first_children[node + 1]; ++at)
                    if (!is_shared_(i, above.children[at]))
                        turns[above.children[at]] = cube_group.product[upright_.turns[i + 1][node]][above.tag(at)];
            });
        }
    }

    const Dag& dag_;
    const bool has_inner_tags_;
    const std::function<bool(std::size_t, std::uint32_t)>& is_shared_;
    const Progress& progress_;
    Upright upright_;
};
} // namespace

Upright upright_turns(const Dag& dag, bool has_inner_tags,
                      const std::function<bool(std::size_t i, std::uint32_t node)>& is_shared,
                      const Progress& progress) {
    return Turning(dag, has_inner_tags && dag.levels.size() > 2 && dag.symmetry != Symmetry::None, is_shared, progress)
        .run();
}
} // namespace tyndall::voxel_dag
