// A stored state as bytes that survive a file and another process: what it is, whose it is, whether it is
// whole.
#pragma once

#include <span>
#include <string>
#include <string_view>

#include "fmi/fmu.hpp"

namespace truenorth::fmi {

// Bytes of a state: a header around the payload.
[[nodiscard]] std::string pack(const Identity& owner, const Use& use, std::string_view payload);

// The payload, within `bytes`. Throws Refusal when these are not a whole state of the owner, for the same use
// and in this format.
[[nodiscard]] std::string_view unpack(const Identity& owner, const Use& use, std::span<const char> bytes);

}  // namespace truenorth::fmi
