// SPDX-License-Identifier: GPL-3.0-or-later
// A table that gives each distinct record one number, filled from several threads at once.
// Based on: open addressing with linear probes; look-ups in batches, each asked for in memory before it is read.
// Differs:  numbers say nothing about order (they depend on the threads): number_by_first_use() makes order of them. A
//           table that is full says so in place of growing under its users: what was to be inserted is inserted again.
// Bound:    16 bytes and a record per number; one miss of the cache per new record, two per known one.
#pragma once
#include "core/huge_pages.hpp"
#include "core/parallel.hpp"
#include <array>
#include <atomic>
#include <bit>
#include <cstdlib>
#include <cstring>
#include <hwy/cache_control.h>
#include <memory>
#include <span>
#include <type_traits>

namespace tyndall::voxel_dag {
/// A record as words: what is hashed and compared.
template <class Record>
[[nodiscard]] auto words_of(const Record& record) {
    static_assert(std::has_unique_object_representations_v<Record> && sizeof(Record) % sizeof(std::uint64_t) == 0);
    std::array<std::uint64_t, sizeof(Record) / sizeof(std::uint64_t)> words;
    std::memcpy(words.data(), &record, sizeof(record));
    return words;
}
/// Without a branch per word.
template <class Record>
[[nodiscard]] bool are_equal(const Record& a, const Record& b) {
    const auto a_words = words_of(a), b_words = words_of(b);
    std::uint64_t difference = 0;
    for (std::size_t i = 0; i < a_words.size(); ++i)
        difference |= a_words[i] ^ b_words[i];
    return difference == 0;
}

template <class Record>
[[nodiscard]] std::uint64_t hash_of(const Record& record) {
    // Odd, of digits that follow no rule: those of the golden ratio and of splitmix64.
    static constexpr std::array<std::uint64_t, 5> factors{0x9e3779b97f4a7c15ull, 0xbf58476d1ce4e5b9ull,
                                                          0x94d049bb133111ebull, 0xd6e8feb86659fd93ull,
                                                          0xff51afd7ed558ccdull};
    const auto words = words_of(record);
    static_assert(words.size() <= factors.size());
    std::uint64_t sum = 0;
    for (std::size_t i = 0; i < words.size(); ++i)
        sum += words[i] * factors[i];
    // A product carries upwards only: its high half is what depends on every bit.
    sum = (sum ^ sum >> 32) * factors[3];
    return sum ^ sum >> 29;
}

template <class Record>
class UniqueTable {
public:
    static constexpr std::size_t batch_size = 32; ///< Records that are looked up together.
    /// Numbers that one thread took in advance, so that threads seldom meet.
    struct Reserve {
        std::uint32_t next = 0, end = 0;
    };

    explicit UniqueTable(std::size_t expected_count) { allocate(expected_count); }

    /// Numbers of up to batch_size records, from 1 on. False where the table is full: call make_room(), and then this,
    /// again.
    [[nodiscard]] bool find_or_insert(std::span<const Record> records, std::uint32_t* numbers, Reserve& reserve) {
        std::array<std::uint64_t, batch_size> hashes;
        for (std::size_t i = 0; i < records.size(); ++i) {
            hashes[i] = hash_of(records[i]);
            hwy::Prefetch(&slots_[hashes[i] & (slot_count_ - 1)]);
        }
        for (std::size_t i = 0; i < records.size(); ++i) {
            const std::uint64_t slot = load(hashes[i] & (slot_count_ - 1));
            if (slot >> 32 == hashes[i] >> 32)
                hwy::Prefetch(&records_[slot & 0xffffffffu]);
        }
        for (std::size_t i = 0; i < records.size(); ++i)
            if (numbers[i] = find_or_insert(records[i], hashes[i], reserve); numbers[i] == 0)
                return false;
        return true;
    }

    /// Room for `count` records more. Not while others insert.
    void make_room(std::size_t count, const Progress& progress) {
        count += reserve_count; // whole reserves are taken
        if (past() + count <= record_capacity())
            return;
        const std::size_t old_count = past();
        const std::unique_ptr<Record[]> old = std::move(records_);
        const std::vector<bool> is_used = used_numbers();
        allocate(std::max(2 * old_count, old_count + count));
        parallel_for(old_count, progress, [&](std::size_t number) {
            if (!is_used[number])
                return;
            records_[number] = old[number];
            const std::uint64_t hash = hash_of(old[number]), wanted = (hash & ~std::uint64_t{0xffffffffu}) | number;
            for (std::size_t at = hash & (slot_count_ - 1);; at = (at + 1) & (slot_count_ - 1))
                if (std::uint64_t none = 0; std::atomic_ref(slots_[at]).compare_exchange_strong(none, wanted))
                    break;
        });
    }

    [[nodiscard]] const Record& operator[](std::uint32_t number) const { return records_[number]; }
    /// Numbers are below. A few of them may be in no use: what threads took and did not need.
    [[nodiscard]] std::size_t past() const { return std::min<std::size_t>(past_.load(), record_capacity()); }
    [[nodiscard]] bool is_full() const { return past_.load() >= record_capacity(); }
    [[nodiscard]] std::uint64_t memory_bytes() const { return memory_bytes(record_capacity()); }
    /// Of a table that expects so many.
    [[nodiscard]] static std::uint64_t memory_bytes(std::size_t expected_count) {
        return slots_for(expected_count) * (sizeof(std::uint64_t) + sizeof(Record) / 2);
    }

private:
    static constexpr std::uint32_t reserve_count = 64;
    struct Free {
        void operator()(std::uint64_t* memory) const { std::free(memory); } // of calloc()
    };

    // At most every second one is taken.
    static std::size_t slots_for(std::size_t count) {
        return std::bit_ceil(std::max<std::size_t>(2 * count, 32 * reserve_count));
    }
    [[nodiscard]] std::size_t record_capacity() const { return slot_count_ / 2; }
    [[nodiscard]] std::uint64_t load(std::size_t at) const {
        return std::atomic_ref(slots_[at]).load(std::memory_order_acquire);
    }

    void allocate(std::size_t expected_count) {
        slot_count_ = slots_for(expected_count);
        require(record_capacity() < std::uint64_t{1} << 32, "voxel DAG: ", expected_count,
                " distinct nodes in one level; 2^31 are possible");
        // What nobody writes to stays free of charge: neither array is touched here.
        slots_.reset(static_cast<std::uint64_t*>(std::calloc(slot_count_, sizeof(std::uint64_t))));
        if (!slots_)
            throw std::bad_alloc();
        prefer_huge_pages(slots_.get(), slot_count_ * sizeof(std::uint64_t));
        records_ = std::make_unique_for_overwrite<Record[]>(record_capacity());
        prefer_huge_pages(records_.get(), record_capacity() * sizeof(Record));
    }

    [[nodiscard]] std::vector<bool> used_numbers() const {
        std::vector<bool> is_used(past());
        for (std::size_t at = 0; at < slot_count_; ++at)
            if (const std::uint64_t slot = slots_[at]; slot != 0)
                is_used[slot & 0xffffffffu] = true;
        return is_used;
    }

    /// 0: full.
    std::uint32_t find_or_insert(const Record& record, std::uint64_t hash, Reserve& reserve) {
        bool is_written = false;
        for (std::size_t at = hash & (slot_count_ - 1);;) {
            std::uint64_t slot = load(at);
            if (slot == 0) {
                if (!is_written) {
                    if (reserve.next == reserve.end && !refill(reserve))
                        return 0;
                    records_[reserve.next] = record;
                    is_written = true;
                }
                const std::uint64_t wanted = (hash & ~std::uint64_t{0xffffffffu}) | reserve.next;
                if (std::atomic_ref(slots_[at]).compare_exchange_strong(slot, wanted, std::memory_order_acq_rel))
                    return reserve.next++;
            }
            // Here, too, where another thread was faster: it may have brought the same record.
            const auto number = static_cast<std::uint32_t>(slot);
            if (slot >> 32 == hash >> 32 && are_equal(records_[number], record))
                return number;
            at = (at + 1) & (slot_count_ - 1);
        }
    }

    bool refill(Reserve& reserve) {
        const std::uint64_t next = past_.fetch_add(reserve_count);
        if (next + reserve_count > record_capacity()) {
            past_.fetch_sub(reserve_count);
            return false;
        }
        reserve = {static_cast<std::uint32_t>(next), static_cast<std::uint32_t>(next + reserve_count)};
        if (next == 0)
            ++reserve.next; // number 0 says "none"
        return true;
    }

    std::size_t slot_count_ = 0;
    std::unique_ptr<std::uint64_t[], Free> slots_; ///< The hash's upper half, then the number; 0: free.
    std::unique_ptr<Record[]> records_;            ///< By number; as many as half of the slots.
    std::atomic<std::uint64_t> past_ = 0;
};
} // namespace tyndall::voxel_dag
