// A scalar of a component: its name, who may set it, and how to read and write it. No FMI version.
#pragma once

#include <cstdint>
#include <variant>

namespace truenorth::fmi {

enum class Causality : std::uint8_t { parameter, tunable, input, output };

// Enumerations are accessed as integers.
enum class Type : std::uint8_t { real, integer, boolean };

template <class T>
inline constexpr Type type_of = Type::real;
template <>
inline constexpr Type type_of<int> = Type::integer;
template <>
inline constexpr Type type_of<bool> = Type::boolean;

struct Variable {
    const char* name;
    Causality causality;
    Type type;
};

template <class Component, class T>
struct Access {
    T (*get)(const Component&);
    void (*set)(Component&, T);  // nullptr: an output
};

// One row of a generated variable table; a variable's reference is the number of its row.
template <class Component>
struct Row {
    Variable variable;
    std::variant<Access<Component, double>, Access<Component, int>, Access<Component, bool>> access;
};

}  // namespace truenorth::fmi
