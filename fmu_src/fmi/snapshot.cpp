// Layout: 8 bytes magic, 4 bytes version of the format, 8 bytes checksum of all that follows, then
// the owner's name, its guid and the payload. The version and the checksum are looked at before anything
// else, so that nothing is interpreted that was not written here.
#include "fmi/snapshot.hpp"

#include <array>
#include <bit>
#include <cereal/archives/binary.hpp>
#include <cereal/types/string.hpp>
#include <cstdint>
#include <sstream>
#include <string_view>

#include "fmi/checksum.hpp"
#include "fmi/refusal.hpp"

namespace truenorth::fmi {
namespace {

constexpr std::string_view magic = "TNstate\n";
constexpr std::uint32_t format_version = 1;

constexpr std::size_t version_offset = magic.size();
constexpr std::size_t checksum_offset = version_offset + sizeof(std::uint32_t);
constexpr std::size_t header_size = checksum_offset + sizeof(std::uint64_t);

template <class T>
using Bytes = std::array<char, sizeof(T)>;

template <class T>
void append(std::string& bytes, T number) {
    const auto raw = std::bit_cast<Bytes<T>>(number);
    bytes.append(raw.begin(), raw.end());
}

template <class T>
T number_at(std::size_t offset, std::string_view bytes) {
    Bytes<T> raw{};
    bytes.copy(raw.data(), raw.size(), offset);
    return std::bit_cast<T>(raw);
}

}  // namespace

std::string pack(const Identity& owner, const std::string& payload) {
    std::ostringstream body;
    cereal::BinaryOutputArchive{body}(std::string(owner.name), std::string(owner.guid), payload);
    const std::string content = body.str();
    std::string bytes(magic);
    bytes.reserve(header_size + content.size());
    append(bytes, format_version);
    append(bytes, checksum_of(content));
    return bytes + content;
}

std::string unpack(const Identity& owner, std::span<const char> bytes) {
    const std::string_view all(bytes.data(), bytes.size());
    if (!all.starts_with(magic)) {
        throw Refusal("these bytes are not the state of a TrueNorth FMU");
    }
    if (all.size() < header_size) {
        throw Refusal("the stored state is truncated");
    }
    const auto version = number_at<std::uint32_t>(version_offset, all);
    if (version != format_version) {
        throw Refusal("the stored state has format version " + std::to_string(version) +
                      "; this FMU reads version " + std::to_string(format_version));
    }
    const auto expected = number_at<std::uint64_t>(checksum_offset, all);
    const std::string_view content = all.substr(header_size);
    if (checksum_of(content) != expected) {
        throw Refusal("the stored state is truncated or corrupt");
    }

    std::string name;
    std::string guid;
    std::string payload;
    std::istringstream body{std::string(content)};
    cereal::BinaryInputArchive{body}(name, guid, payload);
    if (name != owner.name) {
        throw Refusal("the stored state is one of " + name + "; this is " + owner.name);
    }
    if (guid != owner.guid) {
        throw Refusal("the stored state is one of another build of " + name + " (" + guid + "); this is " +
                      owner.guid);
    }
    return payload;
}

}  // namespace truenorth::fmi
