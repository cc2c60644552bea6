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
    // Scalars of the array that begins with this one, in the rows that follow; 1: no array, or not its first.
    unsigned elements;
};

// How to reach a variable of type T in a component of the class C.
template <class C, class T>
struct Access {
    T (*get)(const C&);
    void (*set)(C&, T);  // nullptr: an output
};

// One row of a generated variable table; a variable's reference is the number of its row.
template <class C>
struct Row {
    Variable variable;
    std::variant<Access<C, double>, Access<C, int>, Access<C, bool>> access;
};

}  // namespace truenorth::fmi
