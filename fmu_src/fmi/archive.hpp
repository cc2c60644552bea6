// The archives of a stored state: numbers as they lie in memory, one after the other. What is read is checked
// against what is there: a damaged length asks for no memory, and a bool is 0 or 1.
#pragma once

#include <cereal/cereal.hpp>
#include <cstddef>
#include <cstring>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>

#include "fmi/refusal.hpp"

namespace truenorth::fmi {

class StateWriter : public cereal::OutputArchive<StateWriter, cereal::AllowEmptyClassElision> {
  public:
    explicit StateWriter(std::string& bytes) : OutputArchive(this), bytes_(&bytes) {}

    void write(const void* data, std::size_t size) { bytes_->append(static_cast<const char*>(data), size); }

  private:
    std::string* bytes_;
};

class StateReader : public cereal::InputArchive<StateReader, cereal::AllowEmptyClassElision> {
  public:
    // The bytes must outlive the reader.
    explicit StateReader(std::string_view bytes) : InputArchive(this), left_(bytes) {}

    // Throws Refusal when there are not so many bytes left.
    std::string_view take(std::size_t size) {
        if (size > left_.size()) {
            throw Refusal("the stored state is truncated or damaged: it lacks " +
                          std::to_string(size - left_.size()) + " bytes");
        }
        const std::string_view taken = left_.substr(0, size);
        left_.remove_prefix(size);
        return taken;
    }

    void read(void* data, std::size_t size) { std::memcpy(data, take(size).data(), size); }

    [[nodiscard]] std::size_t left() const { return left_.size(); }

    // Throws Refusal when something is left.
    void finish() const {
        if (!left_.empty()) {
            throw Refusal("the stored state is damaged: " + std::to_string(left_.size()) +
                          " bytes follow its end");
        }
    }

  private:
    std::string_view left_;
};

// ------------------------------------------------------------------ found by cereal, hence its names

template <class Number>
    requires std::is_arithmetic_v<Number>
void save(StateWriter& archive, const Number& number) {
    archive.write(&number, sizeof number);
}

template <class Number>
    requires std::is_arithmetic_v<Number>
void load(StateReader& archive, Number& number) {
    archive(cereal::binary_data(&number, sizeof number));
}

template <class Data>
void save(StateWriter& archive, const cereal::BinaryData<Data>& data) {
    archive.write(data.data, data.size);
}

template <class Data>
void load(StateReader& archive, cereal::BinaryData<Data>& data) {
    const std::string_view bytes = archive.take(data.size);
    if constexpr (std::is_same_v<std::remove_pointer_t<std::remove_reference_t<Data>>, bool>) {
        if (bytes.find_first_not_of(std::string_view("\0\1", 2)) != std::string_view::npos) {
            throw Refusal("the stored state is damaged: a Boolean is neither true nor false");
        }
    }
    std::memcpy(data.data, bytes.data(), bytes.size());
}

template <class Size>
void save(StateWriter& archive, const cereal::SizeTag<Size>& tag) {
    archive(tag.size);
}

// Each element of what follows takes a byte at least.
template <class Size>
void load(StateReader& archive, cereal::SizeTag<Size>& tag) {
    archive(tag.size);
    if (tag.size > archive.left()) {
        throw Refusal("the stored state is damaged: of " + std::to_string(tag.size) +
                      " elements there can be " + std::to_string(archive.left()) + " at most");
    }
}

}  // namespace truenorth::fmi

CEREAL_SETUP_ARCHIVE_TRAITS(truenorth::fmi::StateReader, truenorth::fmi::StateWriter)
