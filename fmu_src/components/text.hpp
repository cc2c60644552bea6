// Texts for people: numbers that read back exactly, parts joined.
#pragma once

#include <array>
#include <charconv>
#include <string>
#include <type_traits>

namespace truenorth {

// The shortest text that reads back to the same number; any other part as it is.
template <class Part>
[[nodiscard]] std::string text(Part part) {
    if constexpr (std::is_arithmetic_v<Part>) {
        std::array<char, 32> digits{};
        auto* const end = std::to_chars(digits.begin(), digits.end(), part).ptr;
        return {digits.begin(), end};
    } else {
        return std::string(part);
    }
}

template <class First, class... Rest>
    requires(sizeof...(Rest) > 0)
[[nodiscard]] std::string text(First first, Rest... rest) {
    return (text(first) + ... + text(rest));
}

}  // namespace truenorth
