// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/errors.hpp"
#include "native/voxel_dag/attribute_sequences.hpp"
#include "voxel_dag/bit_packing.hpp"
#include "voxel_dag/material_indices.hpp"
#include "voxel_dag/palette_array.hpp"
#include <algorithm>
#include <doctest/doctest.h>
#include <set>
#include <string_view>

namespace palette_array_test {
using namespace tyndall;
using namespace tyndall::voxel_dag;

TEST_CASE("packed numbers of every width are read back from any bit, and runs are what single ones would be") {
    std::mt19937_64 random(1);
    BitPacker bits;
    std::vector<std::array<std::uint64_t, 3>> numbers;
    for (int i = 0; i < 4000; ++i) {
        const auto width = static_cast<std::uint32_t>(random() % (most_packed_bits + 1));
        const std::uint64_t value = random() & low_bits(width), count = i % 5 == 0 ? random() % 70 : 1;
        numbers.push_back({value, width, count});
        bits.append_run(value, width, count);
    }
    const std::uint64_t bit_count = bits.bit_count();
    std::vector<std::uint8_t> bytes = bits.take();
    CHECK(bytes.size() == (bit_count + 7) / 8);
    bytes.resize(bytes.size() + bit_slack_bytes);
    std::uint64_t position = 0;
    for (const auto& [value, width, count] : numbers)
        for (std::uint64_t i = 0; i < count; ++i, position += width)
            REQUIRE(read_bits(bytes.data(), position, static_cast<std::uint32_t>(width)) == value);
    CHECK(position == bit_count);
    for (const auto& [count, width] : {std::pair{0u, 0u}, {1u, 0u}, {2u, 1u}, {3u, 2u}, {4096u, 12u}, {4097u, 13u}})
        CHECK(bits_for(count) == width);
}

TEST_CASE("materials are the different values in ascending order, and indices lead back to each") {
    for (const auto& [name, values] : test::awkward_arrays(3000)) {
        CAPTURE(name);
        const MaterialIndices found = material_indices_of(values, {});
        const std::set<std::uint32_t> different(values.begin(), values.end());
        CHECK(std::ranges::equal(found.materials, different));
        REQUIRE(found.indices.size() == values.size());
        for (std::size_t i = 0; i < values.size(); ++i)
            REQUIRE(found.materials[found.indices[i]] == values[i]);
    }
    CHECK(material_indices_of({}, {}).materials.empty());
}

static void require_same(const PaletteArray& array, const test::Values& values) {
    REQUIRE(array.size() == values.size());
    test::Values decoded(values.size());
    array.decode(0, decoded);
    REQUIRE(decoded == values);
    for (std::uint32_t i = 0; i < values.size(); ++i)
        REQUIRE(array.at(i) == values[i]);
}

TEST_CASE("palettes give every entry back, in order, one by one, and from the middle on") {
    for (const std::size_t count : {0u, 1u, 2u, 63u, 64u, 65u, 255u, 256u, 257u, 5000u})
        for (const auto& [name, values] : test::awkward_arrays(count)) {
            CAPTURE(name);
            CAPTURE(count);
            const std::vector<std::uint8_t> bytes = encode_palettes(values, {}, {});
            const PaletteArray array(bytes);
            require_same(array, values);
            for (std::uint32_t begin = 0; begin < count; begin += 997) {
                test::Values part(std::min<std::size_t>(300, count - begin));
                array.decode(begin, part);
                REQUIRE(std::ranges::equal(part, std::span(values).subspan(begin, part.size())));
            }
        }
}

TEST_CASE("blocks of the same values share a palette, and equal arrays have equal bytes") {
    test::Values values;
    for (std::uint32_t i = 0; i < 40000; ++i) // two palettes in turns
        values.push_back(i / 1000 % 2 == 0 ? i * 2654435761u >> 30 : 100 + (i * 2654435761u >> 30));
    const std::vector<std::uint8_t> bytes = encode_palettes(values, {}, {});
    const PaletteArray array(bytes);
    CHECK(array.parts().block_count == 40);
    CHECK(array.parts().palette_count == 2);
    CHECK(encode_palettes(values, {}, {}) == bytes);
    require_same(array, values);
}

TEST_CASE("the parts and the ends of an array are all its bytes") {
    const std::vector<std::uint8_t> bytes = encode_palettes(test::patchwork(30000, 1), {}, {});
    const PaletteArray::Parts parts = PaletteArray(bytes).parts();
    CHECK(parts.material_bytes + parts.directory_bytes + parts.palette_bytes + parts.index_bytes + 40 + 8 ==
          bytes.size());
}

static std::string complaint(std::vector<std::uint8_t> bytes) {
    try {
        const PaletteArray array(bytes);
    } catch (const InvalidInput& error) {
        return error.what();
    }
    return "";
}

TEST_CASE("bytes that are cut off or damaged are refused with the section's name") {
    const std::vector<std::uint8_t> bytes = encode_palettes(test::patchwork(3000, 2), {}, {});
    const PaletteArray::Parts parts = PaletteArray(bytes).parts();
    const auto cut = [&](std::uint64_t size) {
        return complaint({bytes.begin(), bytes.begin() + std::ptrdiff_t(size)});
    };
    std::uint64_t begin = 40;
    CHECK(cut(0).starts_with("palette array: section 'header' is cut off"));
    CHECK(cut(39).starts_with("palette array: section 'header' is cut off"));
    CHECK(cut(begin + 10).starts_with("palette array: section 'materials' is cut off"));
    CHECK(cut((begin += parts.material_bytes) + 10).starts_with("palette array: section 'directory' is cut off"));
    CHECK(cut((begin += parts.directory_bytes) + 10).starts_with("palette array: section 'palettes' is cut off"));
    CHECK(cut((begin += parts.palette_bytes) + 10).starts_with("palette array: section 'indices' is cut off"));
    CHECK(cut(bytes.size() - 1).starts_with("palette array: section 'end' is cut off"));
    std::vector<std::uint8_t> other = bytes;
    other[0] ^= 1;
    CHECK(complaint(other) == "palette array: section 'header' does not begin with its mark");
    std::vector<std::uint8_t> constant = encode_palettes(test::Values(100, 3), {}, {}); // 7 bits of entry, 4 of width
    constant[41] |= 0x80;
    CHECK(complaint(constant) ==
          "palette array: section 'directory' has a palette of block 0 that ends behind the last");
    other = bytes, other.push_back(0);
    CHECK(complaint(other) == "palette array: section 'end' is followed by 1 bytes");
}

TEST_CASE("whatever bytes are damaged, an array is refused or every entry can be read") {
    test::Random random(3);
    std::size_t refused_count = 0;
    for (int i = 0; i < 3000; ++i) {
        std::vector<std::uint8_t> bytes =
            encode_palettes(test::random_runs(random() % 600, 1 + random() % 300, random() % 100, random()), {}, {});
        for (std::uint32_t changes = 1 + random() % 3; changes > 0; --changes) {
            const std::size_t reach = random() % 2 == 0 ? 40 : bytes.size(); // the header half of the time
            bytes[random() % reach] = static_cast<std::uint8_t>(random());
        }
        if (!complaint(bytes).empty()) {
            ++refused_count;
            continue;
        }
        const PaletteArray array(bytes);
        REQUIRE(array.size() < 1u << 24);
        std::uint32_t sum = 0;
        for (std::uint32_t entry = 0; entry < array.size(); ++entry)
            sum += array.at(entry);
        REQUIRE((sum == 0 || array.size() > 0));
    }
    CHECK(refused_count > 1000);
}
} // namespace palette_array_test
