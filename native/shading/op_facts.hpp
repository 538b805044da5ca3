// SPDX-License-Identifier: GPL-3.0-or-later
// What is true of an operation whatever its operands are: an operation that is not here is refused.
// A new one needs: its facts here, its family's function (op_<family>.hpp), and that family's case in the interpreter.
#pragma once
#include "shading/surface_op.hpp"
#include <optional>

namespace tyndall {
/// What an operation reads beside its operands; flags.
struct OpReads {
    using Flags = std::uint8_t;
    static constexpr Flags nothing = 0, image = 1, uv_map = 2, table = 4, facing = 8,
                           point = 16; ///< Anything of ProgramPoint but for its facing.
};
/// Whether the three channels of a result may differ.
enum class Channels : std::uint8_t {
    Equal,      ///< Never.
    AsOperands, ///< Only if those of an operand do.
    Own,        ///< They may, whatever the operands are.
};
struct OpFacts {
    std::uint8_t operand_count = 0; ///< The first so many of a to f.
    OpReads::Flags reads = OpReads::nothing;
    Channels channels = Channels::Own;
};
/// Nothing for an operation that this version does not know.
[[nodiscard]] std::optional<OpFacts> facts_of(const SurfaceOp& op);

[[nodiscard]] inline bool is_known(const SurfaceOp& op) { return facts_of(op).has_value(); }
[[nodiscard]] inline int operand_count(const SurfaceOp& op) { return facts_of(op).value_or(OpFacts{}).operand_count; }
} // namespace tyndall
