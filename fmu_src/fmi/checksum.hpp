// Whether bytes are those that were written.
#pragma once

#include <cstdint>
#include <string_view>

namespace truenorth::fmi {

// FNV-1a, 64 bits: any single changed byte changes it. Bytes that come after others go on from their
// checksum.
[[nodiscard]] constexpr std::uint64_t checksum_of(std::string_view bytes,
                                                  std::uint64_t hash = 0xcbf29ce484222325U) {
    for (const char byte : bytes) {
        hash ^= static_cast<unsigned char>(byte);
        hash *= 0x100000001b3U;
    }
    return hash;
}

}  // namespace truenorth::fmi
