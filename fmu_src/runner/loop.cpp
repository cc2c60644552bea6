#include "runner/loop.hpp"

#include <cstring>

// All memory is of another language, which hands over addresses.
// NOLINTBEGIN(cppcoreguidelines-pro-bounds-pointer-arithmetic)
namespace truenorth::runner {

namespace {

// Gather, by the size of what is gathered, which the compiler then knows.
template <class Bits>
void gather(const Operation& operation) {
    for (std::size_t i = 0; i < operation.count; ++i) {
        std::memcpy(operation.values + i * sizeof(Bits),
                    operation.signals + operation.references[i] * sizeof(Bits), sizeof(Bits));
    }
}

void add(const Operation& operation) {
    for (std::size_t i = 0; i < operation.count; ++i) {
        double sum = 0.0;
        double summand = 0.0;
        std::byte* const place = operation.values + operation.references[i] * sizeof sum;
        std::memcpy(&sum, place, sizeof sum);
        std::memcpy(&summand, operation.signals + i * sizeof summand, sizeof summand);
        sum += summand;
        std::memcpy(place, &sum, sizeof sum);
    }
}

// A component keeps its inputs, most of which change seldom: those of receivers and aids. What it has before
// the first step is not known.
int renew(const Operation& operation, bool first) {
    const std::size_t bytes = operation.count * operation.size;
    if (!first && std::memcmp(operation.values, operation.last, bytes) == 0) {
        return 0;
    }
    std::memcpy(operation.last, operation.values, bytes);
    return operation.access(operation.component, operation.references, operation.count, operation.values);
}

int carry_out(const Operation& operation, double time, double step, bool first) {
    switch (operation.kind) {
        case Kind::step:
            return operation.step(operation.component, time, step, 1);
        case Kind::access:
            return operation.access(operation.component, operation.references, operation.count,
                                    operation.values);
        case Kind::renew:
            return renew(operation, first);
        case Kind::gather:
            if (operation.size == sizeof(std::uint64_t)) {
                gather<std::uint64_t>(operation);
            } else {
                gather<std::uint32_t>(operation);
            }
            return 0;
        case Kind::add:
            add(operation);
            return 0;
        case Kind::look:
            break;
    }
    return 0;
}

// Whether the counter of fixes, the only signal of the operation, is another than before.
bool look(const Operation& operation, Loop& loop) {
    std::int32_t count = 0;
    std::memcpy(&count, operation.signals, sizeof count);
    const bool came = count != loop.fix_count;
    loop.fix_count = count;
    loop.fixes += came ? 1 : 0;
    return came;
}

}  // namespace

std::ptrdiff_t run(Loop& loop, std::size_t until) {
    for (; loop.done < until; ++loop.done) {
        const double time = loop.times[loop.done];
        const double step = loop.times[loop.done + 1] - time;
        const bool row = (loop.done + 1) % loop.steps_per_row == 0;
        bool fix = false;
        for (std::size_t i = 0; i < loop.count; ++i) {
            Operation& operation = loop.operations[i];
            if ((operation.when == When::at_row && !row) || (operation.when == When::at_fix && !fix)) {
                continue;
            }
            if (operation.kind == Kind::look) {
                fix = look(operation, loop);
            } else if (carry_out(operation, time, step, loop.done == 0) >= kDiscard) {
                return static_cast<std::ptrdiff_t>(i);
            }
            operation.values += operation.values_stride;
            operation.signals += operation.signals_stride;
        }
    }
    return -1;
}

}  // namespace truenorth::runner
// NOLINTEND(cppcoreguidelines-pro-bounds-pointer-arithmetic)
