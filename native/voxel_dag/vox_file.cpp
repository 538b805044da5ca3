// SPDX-License-Identifier: GPL-3.0-or-later
#include "voxel_dag/vox_file.hpp"
#include "core/errors.hpp"
#include "core/partial_file.hpp"
#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstring>
#include <fstream>
#include <string>
#include <string_view>
#include <system_error>

namespace tyndall::voxel_dag::vox {
namespace {
constexpr std::uint32_t oldest_version = 150;
constexpr std::size_t voxels_between_polls = std::size_t{1} << 20;
using Entries = std::map<std::string, std::string, std::less<>>; ///< The format's DICT.

/// A chunk's content, read from front to back. Whatever is wrong is said of the chunk.
class Chunk {
public:
    Chunk(std::string_view name, std::size_t place, std::span<const std::uint8_t> content)
        : name_(name), place_(place), rest_(content) {}
    [[nodiscard]] std::string_view name() const { return name_; }
    [[nodiscard]] std::size_t left() const { return rest_.size(); }
    template <typename... Parts>
    void check(bool condition, const Parts&... parts) const {
        require(condition, "chunk ", name_, " at byte ", place_, ": ", parts...);
    }
    [[nodiscard]] std::span<const std::uint8_t> take(std::size_t byte_count, std::string_view what) {
        check(byte_count <= rest_.size(), what, " is cut off: ", byte_count, " bytes are due, ", rest_.size(),
              " are left");
        const auto part = rest_.first(byte_count);
        rest_ = rest_.subspan(byte_count);
        return part;
    }
    [[nodiscard]] std::int32_t number(std::string_view what) {
        std::int32_t value;
        std::memcpy(&value, take(sizeof value, what).data(), sizeof value);
        return value;
    }
    /// How many parts follow, of so many bytes each at least: a forged number takes no memory.
    [[nodiscard]] std::size_t count(std::size_t least_bytes, std::string_view what) {
        const std::int32_t value = number(what);
        check(value >= 0 && static_cast<std::size_t>(value) <= rest_.size() / least_bytes, what, " are ", value,
              ", more than its ", rest_.size(), " bytes hold");
        return static_cast<std::size_t>(value);
    }
    [[nodiscard]] Entries entries() {
        Entries entries;
        for (std::size_t left = count(8, "its entries"); left > 0; --left) {
            std::string key = text();
            entries.insert_or_assign(std::move(key), text());
        }
        return entries;
    }

private:
    std::string text() {
        const auto bytes = take(count(1, "the letters of a text"), "a text");
        return {bytes.begin(), bytes.end()};
    }
    std::string_view name_;
    std::size_t place_;
    std::span<const std::uint8_t> rest_;
};

std::string_view value_of(const Entries& entries, std::string_view key) {
    const auto found = entries.find(key);
    return found == entries.end() ? std::string_view() : found->second;
}

template <typename Number>
Number parsed(const Chunk& chunk, std::string_view& text, std::string_view what) {
    text.remove_prefix(std::min(text.find_first_not_of(' '), text.size()));
    Number value{};
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    chunk.check(error == std::errc() && (end == text.data() + text.size() || *end == ' '), what, " is \"",
                text.substr(0, 40), "\", no number");
    text.remove_prefix(static_cast<std::size_t>(end - text.data()));
    return value;
}

/// A matrix of which each row and each column has one 1 or -1.
void check_rotation(const Chunk& chunk, std::uint8_t rotation) {
    const std::uint32_t first = rotation & 3u, second = rotation >> 2 & 3u;
    chunk.check(first < 3 && second < 3 && first != second && rotation < 0x80, "its rotation ",
                static_cast<std::uint32_t>(rotation), " is none of the cube's");
}

Node transform_of(Chunk& chunk) {
    Node node{.kind = NodeKind::Transform, .translation = {}, .children = {}};
    node.is_hidden = value_of(chunk.entries(), "_hidden") == "1";
    node.children = {chunk.number("its child")};
    static_cast<void>(chunk.number("what is reserved"));
    node.layer = chunk.number("its layer");
    chunk.check(chunk.count(4, "its frames") > 0, "it has no frame");
    const Entries frame = chunk.entries();
    if (std::string_view text = value_of(frame, "_r"); !text.empty()) {
        node.rotation = parsed<std::uint8_t>(chunk, text, "its rotation");
        check_rotation(chunk, node.rotation);
    }
    if (std::string_view text = value_of(frame, "_t"); !text.empty())
        for (std::int32_t& along : node.translation)
            along = parsed<std::int32_t>(chunk, text, "its translation");
    return node;
}

Node group_of(Chunk& chunk) {
    Node node{.kind = NodeKind::Group, .translation = {}, .children = {}};
    node.is_hidden = value_of(chunk.entries(), "_hidden") == "1";
    for (std::size_t left = chunk.count(4, "its children"); left > 0; --left)
        node.children.push_back(chunk.number("a child"));
    return node;
}

Node shape_of(Chunk& chunk) {
    Node node{.kind = NodeKind::Shape, .translation = {}, .children = {}};
    node.is_hidden = value_of(chunk.entries(), "_hidden") == "1";
    chunk.check(chunk.count(8, "its models") > 0, "it has no model");
    node.children = {chunk.number("its model")};
    return node;
}

std::uint8_t byte_of(const Chunk& chunk, std::string_view text, std::string_view what) {
    const auto value = parsed<float>(chunk, text, what);
    chunk.check(std::isfinite(value), what, " is not finite");
    return static_cast<std::uint8_t>(std::lround(std::clamp(value, 0.0f, 1.0f) * 255.0f));
}

/// MagicaVoxel writes the roughness of diffuse materials, too, and renders without it.
Material material_of(const Chunk& chunk, const Entries& entries) {
    Material material;
    const std::string_view type = value_of(entries, "_type");
    const auto find = [&](std::string_view key) { return value_of(entries, key); };
    if (!type.empty() && type != "_diffuse")
        if (const std::string_view text = find("_rough"); !text.empty())
            material.roughness = byte_of(chunk, text, "_rough");
    // Of 0.98 and before, whose one weight is that of the type.
    const std::string_view weight = find("_weight");
    if (type == "_metal")
        if (const std::string_view text = find("_metal").empty() ? weight : find("_metal"); !text.empty())
            material.metallic = byte_of(chunk, text, "_metal");
    if (type == "_emit")
        if (const std::string_view text = find("_emit").empty() ? weight : find("_emit"); !text.empty())
            material.emission = byte_of(chunk, text, "_emit");
    return material;
}

class Parser {
public:
    Parser(std::span<const std::uint8_t> bytes, const Progress& progress) : bytes_(bytes), progress_(progress) {}

    File parsed_file() {
        require(bytes_.size() >= 8 && std::memcmp(bytes_.data(), "VOX ", 4) == 0, "it is no .vox file");
        const std::uint32_t version = number_at(4);
        require(version >= oldest_version, "it is of version ", version, "; those from ", oldest_version,
                " on can be read: save it with a newer MagicaVoxel");
        file_.palette = default_palette();
        std::size_t at = 8;
        const Chunk main = chunk_at(at, bytes_.size());
        main.check(main.name() == "MAIN", "the file's first chunk is not MAIN");
        while (at < bytes_.size()) {
            progress_.poll();
            Chunk chunk = chunk_at(at, bytes_.size());
            take(chunk);
        }
        require(!has_sides_, "the last chunk SIZE has no XYZI");
        require(!file_.models.empty(), "it has no model");
        return std::move(file_);
    }

private:
    std::uint32_t number_at(std::size_t at) const {
        std::uint32_t value;
        std::memcpy(&value, bytes_.data() + at, sizeof value);
        return value;
    }
    /// Its children follow as if they were its neighbours; MAIN alone has any.
    Chunk chunk_at(std::size_t& at, std::size_t end) const {
        constexpr std::size_t header_bytes = 12;
        require(end - at >= header_bytes, "chunk at byte ", at, ": its header is cut off");
        const std::string_view name(reinterpret_cast<const char*>(bytes_.data()) + at, 4);
        require(std::ranges::all_of(name, [](char letter) { return ' ' <= letter && letter <= '~'; }),
                "what begins at byte ", at, " is no chunk: the one before it has a wrong size");
        const std::uint64_t own_bytes = number_at(at + 4), child_bytes = number_at(at + 8);
        const std::size_t place = at;
        at += header_bytes;
        require(own_bytes + child_bytes <= end - at, "chunk ", name, " at byte ", place, ": ", own_bytes + child_bytes,
                " bytes are due, ", end - at, " are left");
        const Chunk chunk(name, place, bytes_.subspan(at, own_bytes));
        at += own_bytes;
        return chunk;
    }

    void take(Chunk& chunk) {
        const std::string_view name = chunk.name();
        if (name == "SIZE")
            take_sides(chunk);
        else if (name == "XYZI")
            take_voxels(chunk);
        else if (name == "RGBA")
            take_palette(chunk);
        else if (name == "nTRN")
            take_node(chunk, transform_of);
        else if (name == "nGRP")
            take_node(chunk, group_of);
        else if (name == "nSHP")
            take_node(chunk, shape_of);
        else if (name == "LAYR") {
            const std::int32_t layer = chunk.number("its number");
            file_.is_hidden[layer] = value_of(chunk.entries(), "_hidden") == "1";
        } else if (name == "MATL") {
            const std::int32_t index = chunk.number("its index");
            const Entries entries = chunk.entries();
            if (0 < index && index < 256) // MagicaVoxel writes 256, which no voxel has
                file_.materials[static_cast<std::size_t>(index)] = material_of(chunk, entries);
        } else if (name == "IMAP")
            static_cast<void>(chunk.take(256, "the order of colours"));
    }
    void take_sides(Chunk& chunk) {
        chunk.check(!has_sides_, "the SIZE before it has no XYZI");
        for (std::uint32_t& side : sides_) {
            const std::int32_t value = chunk.number("a side");
            chunk.check(0 < value && value <= static_cast<std::int32_t>(most_side), "a side of ", value,
                        " voxels, outside [1, ", most_side, "]");
            side = static_cast<std::uint32_t>(value);
        }
        has_sides_ = true;
    }
    void take_voxels(Chunk& chunk) {
        chunk.check(has_sides_, "no SIZE comes before it");
        has_sides_ = false;
        const std::size_t count = chunk.count(sizeof(ModelVoxel), "its voxels");
        static_assert(sizeof(ModelVoxel) == 4);
        Model& model = file_.models.emplace_back(Model{.sides = sides_, .voxels = std::vector<ModelVoxel>(count)});
        const auto voxels = chunk.take(count * sizeof(ModelVoxel), "its voxels");
        if (count > 0)
            std::memcpy(model.voxels.data(), voxels.data(), voxels.size());
        for (std::size_t i = 0; i < count; ++i) {
            if (i % voxels_between_polls == 0)
                progress_.poll();
            const auto [x, y, z, color] = model.voxels[i];
            chunk.check(x < sides_[0] && y < sides_[1] && z < sides_[2], "voxel ", i, " lies outside of its model, ",
                        sides_[0], " x ", sides_[1], " x ", sides_[2]);
            chunk.check(color != 0, "voxel ", i, " has the colour 0, which stands for none");
        }
    }
    void take_palette(Chunk& chunk) {
        for (std::size_t i = 0; i < 256; ++i) {
            const auto color = chunk.take(4, "a colour");
            if (i < 255) // index i + 1 of voxels
                file_.palette[i + 1] =
                    color[0] | static_cast<std::uint32_t>(color[1]) << 8 | static_cast<std::uint32_t>(color[2]) << 16;
        }
    }
    template <typename Take>
    void take_node(Chunk& chunk, const Take& node_of) {
        const std::int32_t number = chunk.number("its number");
        chunk.check(file_.nodes.try_emplace(number, node_of(chunk)).second, "node ", number, " comes twice");
    }

    std::span<const std::uint8_t> bytes_;
    const Progress& progress_;
    File file_;
    std::array<std::uint32_t, 3> sides_{};
    bool has_sides_ = false; ///< Those of a model that is yet to come.
};
} // namespace

std::array<std::uint32_t, 256> default_palette() {
    std::array<std::uint32_t, 256> palette{};
    std::size_t index = 1;
    const auto add = [&](std::uint32_t r, std::uint32_t g, std::uint32_t b) {
        palette[index++] = r | g << 8 | b << 16;
    };
    // Six steps of each channel without black, blue falling fastest; then ramps of red, green, blue and grey.
    for (std::uint32_t step = 0; step < 215; ++step)
        add(51 * (5 - step / 36), 51 * (5 - step / 6 % 6), 51 * (5 - step % 6));
    for (std::uint32_t ramp = 0; ramp < 4; ++ramp)
        for (const std::uint32_t level : {0xeeu, 0xddu, 0xbbu, 0xaau, 0x88u, 0x77u, 0x55u, 0x44u, 0x22u, 0x11u})
            add(ramp == 0 || ramp == 3 ? level : 0, ramp == 1 || ramp == 3 ? level : 0, ramp >= 2 ? level : 0);
    return palette;
}

File parse(std::span<const std::uint8_t> bytes, const Progress& progress) {
    return Parser(bytes, progress).parsed_file();
}

File read(const std::filesystem::path& path, const Progress& progress) {
    std::error_code error;
    const std::uint64_t byte_count = std::filesystem::file_size(path, error);
    std::ifstream file(path, std::ios::binary);
    if (error || !file)
        refuse_file(path, error ? error.message() : std::generic_category().message(errno));
    std::vector<std::uint8_t> bytes(byte_count);
    if (!file.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(byte_count)))
        refuse_file(path, "reading it failed");
    try {
        return parse(bytes, progress);
    } catch (const InvalidInput& damage) {
        refuse_file(path, damage.what());
    }
}
} // namespace tyndall::voxel_dag::vox
