// SPDX-License-Identifier: GPL-3.0-or-later
#include "shading/op_facts.hpp"
#include "shading/op_colour.hpp"
#include "shading/op_images.hpp"
#include "shading/op_inputs.hpp"
#include "shading/op_math.hpp"
#include "shading/op_normals.hpp"
#include "shading/op_patterns.hpp"
#include "shading/op_surroundings.hpp"

namespace tyndall {
std::optional<OpFacts> facts_of(const SurfaceOp& op) {
    using Code = SurfaceOp::Code;
    const auto facts = [](int operand_count, OpReads::Flags reads, Channels channels) {
        return OpFacts{static_cast<std::uint8_t>(operand_count), reads, channels};
    };
    const OpReads::Flags beside = op.shift == 0 ? OpReads::nothing : OpReads::point;
    switch (op.code) {
    case Code::Constant: {
        const bool is_grey = op.value.x == op.value.y && op.value.y == op.value.z;
        return facts(0, OpReads::nothing, is_grey ? Channels::Equal : Channels::Own);
    }
    case Code::Texture:
        return facts(0, OpReads::image | OpReads::uv_map | beside, Channels::Own);
    case Code::TextureAlpha:
        return facts(0, OpReads::image | OpReads::uv_map | beside, Channels::Equal);
    case Code::Uv:
        return facts(0, OpReads::uv_map | beside, Channels::Own);
    case Code::Backfacing:
        return facts(0, OpReads::facing, Channels::Equal);
    case Code::Multiply:
    case Code::Add:
    case Code::Subtract:
        return facts(2, OpReads::nothing, Channels::AsOperands);
    case Code::Mix:
        return facts(3, OpReads::nothing, Channels::AsOperands);
    case Code::Clamp:
        return facts(1, OpReads::nothing, Channels::AsOperands);
    case Code::Average:
        return facts(1, OpReads::nothing, Channels::Equal);
    case Code::Math: {
        const auto operation = static_cast<MathOperation>(op.option);
        if (operation >= MathOperation::Count)
            return {};
        return facts(operand_count(operation), OpReads::nothing, Channels::Equal);
    }
    case Code::VectorMath: {
        const auto operation = static_cast<VectorOperation>(op.option);
        if (operation >= VectorOperation::Count)
            return {};
        return facts(operand_count(operation), OpReads::nothing,
                     is_number(operation) ? Channels::Equal : Channels::Own);
    }
    case Code::MapRange: {
        const auto kind = static_cast<RangeKind>(op.option);
        const auto of = static_cast<RangeOf>(op.selector);
        if (kind >= RangeKind::Count || of >= RangeOf::Count)
            return {};
        return facts(kind == RangeKind::Stepped ? 6 : 5, OpReads::nothing,
                     of == RangeOf::Numbers ? Channels::Equal : Channels::AsOperands);
    }
    case Code::VectorRotate: {
        const auto kind = static_cast<RotationKind>(op.option);
        if (kind >= RotationKind::Count)
            return {};
        const bool is_by_angles = kind == RotationKind::ByAngles || kind == RotationKind::ByAnglesBack;
        return facts(is_by_angles ? 3 : 4, OpReads::nothing, Channels::Own);
    }
    case Code::Affine:
        return facts(1, OpReads::nothing, Channels::Own);
    case Code::Curve: {
        const auto of = static_cast<CurveOf>(op.selector);
        if (of >= CurveOf::Count || op.option > (CurveOptions::steps | CurveOptions::goes_on))
            return {};
        return facts(of == CurveOf::Each ? 2 : 1, OpReads::table,
                     of == CurveOf::Alpha ? Channels::Equal : Channels::Own);
    }
    case Code::HueSaturation:
        return facts(5, OpReads::nothing, Channels::AsOperands); // grey has no hue
    case Code::Gamma:
        return facts(2, OpReads::nothing, Channels::AsOperands);
    case Code::Blend:
        if (op.option >= static_cast<std::uint8_t>(BlendKind::Count))
            return {};
        return facts(3, OpReads::nothing, Channels::AsOperands);
    case Code::Combine:
        if (op.option >= static_cast<std::uint8_t>(ColourModel::Count))
            return {};
        return facts(3, OpReads::nothing, Channels::Own);
    case Code::Separate:
        if (op.option >= static_cast<std::uint8_t>(ColourModel::Count) || op.selector > 2)
            return {};
        return facts(1, OpReads::nothing, Channels::Equal);
    case Code::Input: {
        const auto input = static_cast<PointInput>(op.option);
        if (!is_known(input))
            return {};
        return facts(reads_operand(input) ? 1 : 0, OpReads::point, is_number(input) ? Channels::Equal : Channels::Own);
    }
    case Code::Fresnel:
    case Code::LayerWeight:
        return facts(2, OpReads::point, Channels::Equal);
    case Code::NormalMap:
        if (op.option >= static_cast<std::uint8_t>(NormalSpace::Count))
            return {};
        return facts(4, OpReads::point, Channels::Own);
    case Code::Bump:
        return facts(6, OpReads::point, Channels::Own);
    case Code::ImageAt:
    case Code::ImageAlphaAt: {
        const auto projection = static_cast<ImageProjection>(op.option);
        if (projection >= ImageProjection::Count)
            return {};
        OpReads::Flags reads = OpReads::image;
        if (projection == ImageProjection::Box)
            reads |= OpReads::point;
        if (op.selector == image_has_tiles)
            reads |= OpReads::table;
        return facts(1, reads, op.code == Code::ImageAlphaAt ? Channels::Equal : Channels::Own);
    }
    case Code::EnvironmentAt:
        if (op.option >= static_cast<std::uint8_t>(EnvironmentProjection::Count))
            return {};
        return facts(1, OpReads::image, Channels::Own);
    case Code::Photometry:
        return facts(1, OpReads::table, Channels::Equal);
    case Code::AmbientOcclusion:
        if (op.option > OcclusionOptions::all || op.selector == 0)
            return {};
        return facts(2, OpReads::point, Channels::Equal);
    case Code::Bevel:
        if (op.selector == 0)
            return {};
        return facts(2, OpReads::point, Channels::Own);
    default:
        return pattern_facts(op);
    }
}
} // namespace tyndall
