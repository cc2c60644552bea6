// Texts for people: numbers that read back exactly, parts joined.
#pragma once

#include <array>
#include <charconv>
#include <cmath>
#include <cstdint>
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

// A figure as a person reads it: four digits after the point at most.
[[nodiscard]] inline double rounded(double value) { return std::round(value * 1e4) / 1e4; }

// What is said of events that were not told one by one.
[[nodiscard]] inline std::string and_others(std::int64_t omitted) {
    return omitted > 0 ? text(" (and ", omitted, " more before)") : std::string();
}

}  // namespace truenorth
