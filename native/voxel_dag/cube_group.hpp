// SPDX-License-Identifier: GPL-3.0-or-later
// The 48 symmetries of a cube, as they turn octants and bricks about their centre.
// Based on: Jaspe, dissertation 2018, 5.3 (the 8 reflections are its tags).
// Differs:  elements exchange the axes first, and mirror then; 8 * permutation + reflections, so that the 8 reflections
//           are the elements below 8, and 0 changes nothing.
#pragma once
#include <array>
#include <cstdint>

namespace tyndall::voxel_dag {
inline constexpr std::uint32_t cube_element_count = 48, reflection_count = 8;

struct CubeGroup {
    /// Where an element takes an octant, x + 2 y + 4 z.
    std::array<std::array<std::uint8_t, 8>, cube_element_count> octant;
    /// product[a][b]: b first, and a then.
    std::array<std::array<std::uint8_t, cube_element_count>, cube_element_count> product;
    std::array<std::uint8_t, cube_element_count> inverse;

    constexpr CubeGroup() : octant{}, product{}, inverse{} {
        // Axis i of the image is axis permutations[.][i] of what is turned.
        constexpr std::uint32_t permutations[6][3] = {{0, 1, 2}, {1, 0, 2}, {0, 2, 1}, {2, 1, 0}, {1, 2, 0}, {2, 0, 1}};
        std::array<std::uint8_t, 8 * 8 * 8> element_of{}; // by the images of octants 1, 2 and 0
        for (std::uint32_t element = 0; element < cube_element_count; ++element) {
            for (std::uint32_t from = 0; from < 8; ++from) {
                std::uint32_t to = element % 8;
                for (std::uint32_t axis = 0; axis < 3; ++axis)
                    to ^= (from >> permutations[element / 8][axis] & 1) << axis;
                octant[element][from] = static_cast<std::uint8_t>(to);
            }
            element_of[key(octant[element][1], octant[element][2], octant[element][0])] =
                static_cast<std::uint8_t>(element);
        }
        for (std::uint32_t a = 0; a < cube_element_count; ++a)
            for (std::uint32_t b = 0; b < cube_element_count; ++b) {
                product[a][b] =
                    element_of[key(octant[a][octant[b][1]], octant[a][octant[b][2]], octant[a][octant[b][0]])];
                if (product[a][b] == 0)
                    inverse[a] = static_cast<std::uint8_t>(b);
            }
    }

private:
    static constexpr std::uint32_t key(std::uint32_t one, std::uint32_t two, std::uint32_t zero) {
        return one << 6 | two << 3 | zero;
    }
};
inline constexpr CubeGroup cube_group;

/// Where an element takes a voxel of a brick: both halves of its Morton code are octants.
[[nodiscard]] constexpr std::uint32_t turned_voxel(std::uint32_t element, std::uint32_t code) {
    return static_cast<std::uint32_t>(cube_group.octant[element][code >> 3] << 3 |
                                      cube_group.octant[element][code & 7]);
}

/// Exchanges, in all bricks' 64 bits, each bit i for which i & digits == lower with bit i + distance.
template <std::uint32_t Digits, std::uint32_t Lower, std::uint32_t Distance>
[[nodiscard]] constexpr std::uint64_t exchange_bits(std::uint64_t leaf) {
    constexpr std::uint64_t lowers = [] {
        std::uint64_t bits = 0;
        for (std::uint32_t i = 0; i < 64; ++i)
            bits |= std::uint64_t{(i & Digits) == Lower} << i;
        return bits;
    }();
    const std::uint64_t changed = (leaf >> Distance ^ leaf) & lowers;
    return leaf ^ changed ^ changed << Distance;
}
[[nodiscard]] constexpr std::uint64_t mirror_x(std::uint64_t leaf) {
    return exchange_bits<8, 0, 8>(exchange_bits<1, 0, 1>(leaf));
}
[[nodiscard]] constexpr std::uint64_t mirror_y(std::uint64_t leaf) {
    return exchange_bits<16, 0, 16>(exchange_bits<2, 0, 2>(leaf));
}
[[nodiscard]] constexpr std::uint64_t mirror_z(std::uint64_t leaf) {
    return exchange_bits<32, 0, 32>(exchange_bits<4, 0, 4>(leaf));
}
[[nodiscard]] constexpr std::uint64_t exchange_xy(std::uint64_t leaf) {
    return exchange_bits<24, 8, 8>(exchange_bits<3, 1, 1>(leaf));
}
[[nodiscard]] constexpr std::uint64_t exchange_yz(std::uint64_t leaf) {
    return exchange_bits<48, 16, 16>(exchange_bits<6, 2, 2>(leaf));
}
[[nodiscard]] constexpr std::uint64_t exchange_xz(std::uint64_t leaf) {
    return exchange_bits<40, 8, 24>(exchange_bits<5, 1, 3>(leaf));
}

/// A brick with its axes exchanged as element 8 * permutation does.
[[nodiscard]] constexpr std::uint64_t permuted_leaf(std::uint32_t permutation, std::uint64_t leaf) {
    switch (permutation) {
    case 1:
        return exchange_xy(leaf);
    case 2:
        return exchange_yz(leaf);
    case 3:
        return exchange_xz(leaf);
    case 4:
        return exchange_yz(exchange_xy(leaf));
    case 5:
        return exchange_xz(exchange_xy(leaf));
    default:
        return leaf;
    }
}
/// A brick that an element has turned: voxel `code` lies at turned_voxel(element, code).
[[nodiscard]] constexpr std::uint64_t turned_leaf(std::uint32_t element, std::uint64_t leaf) {
    leaf = permuted_leaf(element / 8, leaf);
    leaf = (element & 1) != 0 ? mirror_x(leaf) : leaf;
    leaf = (element & 2) != 0 ? mirror_y(leaf) : leaf;
    return (element & 4) != 0 ? mirror_z(leaf) : leaf;
}
} // namespace tyndall::voxel_dag
