// A stored state as bytes that survive a file and another process: what it is, whose it is, whether it is
// whole.
#pragma once

#include <span>
#include <string>

#include "fmi/fmu.hpp"

namespace truenorth::fmi {

// Bytes of a state: a header around the payload.
[[nodiscard]] std::string pack(const Identity& owner, const std::string& payload);

// The payload. Throws Refusal when the bytes are not a whole state of the owner in this format.
[[nodiscard]] std::string unpack(const Identity& owner, std::span<const char> bytes);

}  // namespace truenorth::fmi
