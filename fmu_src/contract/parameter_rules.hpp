// Rules that a parameter's declaration can state. Each throws InvalidParameter with a sentence such as
// "imu.rate = -1: must be greater than 0".
#pragma once

#include <cmath>
#include <initializer_list>
#include <string>
#include <string_view>
#include <utility>

#include "contract/invalid_parameter.hpp"
#include "contract/text.hpp"

namespace truenorth::rules {

template <class Number>
[[noreturn]] void refuse(std::string_view name, Number value, const std::string& rule) {
    throw InvalidParameter(std::string(name) + " = " + text(value) + ": must be " + rule);
}

inline void finite(std::string_view name, double value) {
    if (!std::isfinite(value)) {
        refuse(name, value, "a finite number");
    }
}

template <class Number>
void at_least(std::string_view name, Number value, Number limit) {
    if (value < limit) {
        refuse(name, value, "at least " + text(limit));
    }
}

template <class Number>
void greater_than(std::string_view name, Number value, Number limit) {
    if (value <= limit) {
        refuse(name, value, "greater than " + text(limit));
    }
}

template <class Number>
void at_most(std::string_view name, Number value, Number limit) {
    if (value > limit) {
        refuse(name, value, "at most " + text(limit));
    }
}

// For what must be greater than 0: its square must be as well, and have an inverse.
inline void invertible(std::string_view name, double value) { at_least(name, value, 1e-100); }

template <class Enumeration>
void one_of(std::string_view name, Enumeration value, std::initializer_list<std::string_view> items) {
    const auto number = static_cast<int>(value);
    if (number >= 1 && std::cmp_less_equal(number, items.size())) {
        return;
    }
    std::string list;
    int count = 0;
    for (const std::string_view item : items) {
        ++count;
        list += (count == 1 ? "" : ", ") + std::string(item) + " (" + text(count) + ")";
    }
    refuse(name, number, "one of " + list);
}

}  // namespace truenorth::rules
