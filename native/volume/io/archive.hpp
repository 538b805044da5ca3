// SPDX-License-Identifier: GPL-3.0-or-later
// OpenVDB's reader and writer over streams that throw when a file ends early, when a disk is full, and when the work is
// cancelled. Only for the files in this folder.
#pragma once
#include "core/partial_file.hpp"
#include "core/progress.hpp"
#include <array>
#include <bit>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <openvdb/io/Archive.h>
#include <openvdb/io/GridDescriptor.h>
#include <openvdb/openvdb.h>
#include <system_error>

namespace tyndall::volume_io {
/// Polls at every read and write: a grid has several per leaf.
class PolledFile : public std::filebuf {
public:
    explicit PolledFile(const Progress& progress) : progress_(progress) {}

protected:
    std::streamsize xsgetn(char* target, std::streamsize count) override {
        progress_.poll();
        return std::filebuf::xsgetn(target, count);
    }
    std::streamsize xsputn(const char* source, std::streamsize count) override {
        progress_.poll();
        return std::filebuf::xsputn(source, count);
    }

private:
    const Progress& progress_;
};

/// What to say of a stream that failed, whose own text is "basic_ios::clear", and what to do about any failure.
struct Advice {
    const char *stream_failure, *remedy;
};

/// Text of a file that is meant for people: what is not UTF-8, as in a damaged file, is shown as "?".
inline std::string as_utf8(std::string text) {
    constexpr std::array<std::uint32_t, 5> first_code_of_length{0, 0, 0x80, 0x800, 0x10000};
    for (std::size_t begin = 0; begin < text.size();) {
        const auto byte_at = [&](std::size_t index) { return static_cast<unsigned char>(text[index]); };
        const auto length = static_cast<std::size_t>(std::countl_one(byte_at(begin)));
        if (length == 0) { // ASCII
            ++begin;
            continue;
        }
        bool is_valid = 2 <= length && length <= 4 && begin + length <= text.size();
        std::uint32_t code = byte_at(begin) & (0xffu >> (length + 1));
        for (std::size_t index = begin + 1; is_valid && index < begin + length; ++index) {
            is_valid = (byte_at(index) & 0xc0) == 0x80;
            code = code << 6 | (byte_at(index) & 0x3fu);
        }
        const bool is_surrogate = 0xd800 <= code && code < 0xe000;
        if (is_valid && !is_surrogate && first_code_of_length[length] <= code && code <= 0x10ffff)
            begin += length;
        else
            text[begin++] = '?';
    }
    return text;
}

/// Runs work; what the libraries throw becomes an IoError that names the path. `part` is "grid "x": " or empty.
template <typename Work>
auto with_named_errors(const std::filesystem::path& path, const std::string& part, const Advice& advice,
                       const Work& work) {
    try {
        return work();
    } catch (const Error&) {
        throw; // says what it has to say
    } catch (const std::bad_alloc&) {
        refuse_file(path, part + "there is not enough memory for it, or it is damaged");
    } catch (const std::ios_base::failure&) {
        refuse_file(path, part + advice.stream_failure + "; " + advice.remedy);
    } catch (const std::exception& error) {
        refuse_file(path, part + as_utf8(error.what()) + "; " + advice.remedy);
    }
}

/// An open file: what its header says, and its grids one by one.
class InputArchive : public openvdb::io::Archive {
public:
    struct Entry {
        openvdb::io::GridDescriptor descriptor;
        openvdb::GridBase::Ptr
            grid; ///< Without voxels until it is read; nullptr: of a type that OpenVDB does not know.
        bool is_read = false;
        /// "density", and for the second of this name "density[1]".
        [[nodiscard]] std::string name() const {
            using Descriptor = openvdb::io::GridDescriptor;
            const std::string& unique_name = descriptor.uniqueName();
            const bool is_first = unique_name == Descriptor::addSuffix(descriptor.gridName(), 0);
            return as_utf8(is_first ? descriptor.gridName() : Descriptor::nameAsString(unique_name));
        }
    };

    InputArchive(const std::filesystem::path& path, const Progress& progress) : file_(progress), stream_(&file_) {
        if (std::filesystem::is_directory(path)) // opens, and fails at the first byte without a reason
            refuse_file(path, std::strerror(EISDIR));
        if (file_.open(path, std::ios::in | std::ios::binary) == nullptr)
            refuse_file(path, std::strerror(errno));
        stream_.exceptions(std::ios::badbit | std::ios::failbit | std::ios::eofbit);
        openvdb::io::setStreamMetadataPtr(stream_, stream_metadata_, /*transfer=*/false);
        readHeader(stream_);
        setFormatVersion(stream_);
        setLibraryVersion(stream_);
        setDataCompression(stream_);
        metadata_.readMeta(stream_);
        const std::int32_t grid_count = readGridCount(stream_);
        for (std::int32_t grid = 0; grid < grid_count; ++grid)
            read_entry();
    }

    [[nodiscard]] const openvdb::MetaMap& metadata() const { return metadata_; }
    [[nodiscard]] std::vector<Entry>& entries() { return entries_; }

    /// Metadata and transform; also the voxels if the file does not say how many are active.
    void read_header(Entry& entry) {
        if (entry.is_read)
            return;
        if (fileVersion() >= openvdb::OPENVDB_FILE_VERSION_GRID_INSTANCING) {
            entry.descriptor.seekToGrid(stream_);
            readGridCompression(stream_);
            entry.grid->readMeta(stream_);
            entry.grid->readTransform(stream_);
            if ((*entry.grid)[openvdb::GridBase::META_FILE_VOXEL_COUNT])
                return;
        }
        read_grid(entry);
    }

    void read_grid(Entry& entry) {
        if (entry.is_read)
            return;
        entry.is_read = true; // at once: in a damaged file two grids may each be the other's instance
        entry.descriptor.seekToGrid(stream_);
        readGrid(entry.grid, entry.descriptor, stream_);
        if (entry.descriptor.isInstance()) // it shares the tree of another one
            for (Entry& parent : entries_)
                if (parent.descriptor.uniqueName() == entry.descriptor.instanceParentName() && &parent != &entry) {
                    read_grid(parent);
                    entry.grid->setTree(parent.grid->baseTreePtr());
                }
    }

    /// Frees the voxels. They can be read again if need be, for another grid with the same tree.
    void release(Entry& entry) {
        if (!inputHasGridOffsets())
            return;
        entry.grid->newTree();
        entry.is_read = false;
    }

private:
    void read_entry() {
        Entry& entry = entries_.emplace_back();
        try {
            entry.grid = entry.descriptor.read(stream_);
        } catch (const openvdb::LookupError&) {
            // A type of another program. Its name and type have been read, what follows are three places in the file.
            std::int64_t grid_position, block_position, end_position;
            for (std::int64_t* position : {&grid_position, &block_position, &end_position})
                stream_.read(reinterpret_cast<char*>(position), sizeof *position);
            entry.descriptor.setEndPos(end_position);
        }
        if (inputHasGridOffsets()) {
            entry.descriptor.seekToEnd(stream_);
        } else { // written by a program to a pipe: the grids stand one behind the other
            if (!entry.grid)
                throw openvdb::TypeError("a grid of unknown type " + entry.descriptor.gridType() + " hides the rest");
            readGrid(entry.grid, entry.descriptor, stream_);
            entry.is_read = true;
        }
    }

    PolledFile file_;
    std::istream stream_;
    openvdb::SharedPtr<openvdb::io::StreamMetadata> stream_metadata_{new openvdb::io::StreamMetadata};
    openvdb::MetaMap metadata_;
    std::vector<Entry> entries_;
};

/// Writes all at once, to a file that is whole when write() returns.
class OutputArchive : public openvdb::io::Archive {
public:
    void write(const std::string& path, const openvdb::GridCPtrVec& grids, const openvdb::MetaMap& metadata,
               const Progress& progress) const {
        PolledFile file(progress);
        if (file.open(path, std::ios::out | std::ios::binary | std::ios::trunc) == nullptr)
            throw std::system_error(errno, std::generic_category());
        std::ostream stream(&file);
        stream.exceptions(std::ios::badbit | std::ios::failbit | std::ios::eofbit);
        Archive::write(stream, grids, /*seekable=*/true, metadata);
        if (file.close() == nullptr) // a full disk may show no earlier
            throw std::system_error(errno, std::generic_category());
    }
};
} // namespace tyndall::volume_io
