// A scalar of a component: its name, who may set it, and where it lies. No FMI version.
#pragma once

#include <concepts>
#include <cstdint>
#include <type_traits>

namespace truenorth::fmi {

enum class Causality : std::uint8_t { parameter, tunable, input, output };

// An enumeration is an int like an integer; FMI 2 reads and sets both with the same functions, FMI 3 does
// not.
enum class Type : std::uint8_t { real, integer, enumeration, boolean };

// What values of the type External are when they are kept as a T.
template <class T, class External = T>
inline constexpr Type type_of = Type::real;
template <class External>
inline constexpr Type type_of<int, External> = sizeof(External) > sizeof(int) ? Type::enumeration
                                                                              : Type::integer;
template <class External>
inline constexpr Type type_of<bool, External> = Type::boolean;

struct Variable {
    const char* name;
    Causality causality;
    Type type;
    // Scalars of the array that begins with this one, which follow it in the table and in memory; 1: no
    // array; 0: one of an array, but not its first.
    unsigned elements;
};

// A variable of one component, and where that has it.
struct Cell {
    Variable variable;
    void* address;
};

// One row of a generated variable table; a variable's reference is the number of its row.
template <class C>
struct Row {
    Variable variable;
    void* (*address)(C&);
};

// Where a member lies that is read and written as a T.
template <class T, class Member>
void* address_as(Member& member) {
    if constexpr (std::is_enum_v<Member>) {
        static_assert(std::same_as<std::underlying_type_t<Member>, T>);
    } else {
        static_assert(std::same_as<Member, T>);
    }
    return &member;
}

}  // namespace truenorth::fmi
