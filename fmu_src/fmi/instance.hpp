// One running FMU, whatever the FMI version: order of calls, variables, time, and stored states.
//
// A call that cannot be honoured throws and leaves the instance as it was; only a step that broke down
// half way leaves it in the phase `failed`, from which a stored state or a reset leads back.
//
// In model exchange the component has no continuous states: each sample period ends in a time event, at which
// it makes one step; whoever simulates must stop there. A component with inputs looks at them again whenever
// they are set in event mode, so that the order in which the FMUs are evaluated at one instant does not
// matter.
#pragma once

#include <algorithm>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <initializer_list>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "fmi/component.hpp"
#include "fmi/fmu.hpp"
#include "fmi/journal.hpp"
#include "fmi/start_values.hpp"

namespace truenorth::fmi {

// `stepping` belongs to co-simulation, `event` and `continuous` to model exchange.
enum class Phase : std::uint8_t {
    instantiated,
    initialising,
    stepping,
    failed,
    terminated,
    event,
    continuous
};

// What a reference means: one scalar (FMI 2), or the variable that begins with it, array or scalar (FMI 3).
enum class Reach : std::uint8_t { scalar, variable };

// A stored state. It belongs to the instance that made it.
class State {
  public:
    explicit State(std::string bytes) : bytes_(std::move(bytes)) {}
    [[nodiscard]] std::span<const char> bytes() const { return bytes_; }

  private:
    std::string bytes_;
};

class Instance {
  public:
    Instance(const Fmu& fmu, const Use& use, Journal::Sink sink, bool logging, StartValues start_values = {});

    void set_up_experiment(double start_time, std::optional<double> stop_time);
    void enter_initialisation();
    void exit_initialisation();
    void step(double time, double size);
    void terminate();
    void reset();

    // Model exchange.
    void enter_event();
    void enter_continuous();
    void set_time(double time);
    void update_discrete_states();
    // Whether the time event has come.
    [[nodiscard]] bool completed_integrator_step() const;
    [[nodiscard]] double next_event() const;
    // For what concerns continuous states and event indicators: there are none.
    void require_none(std::size_t count) const;

    // T is the variables' type here (double, int, bool), External the one of the FMI version; an int of 64
    // bits is an enumeration of FMI 3. All or nothing: values are set only when every one of them may be. The
    // reference after the last scalar is the time.
    template <class T, class External>
    void get(std::span<const unsigned> references, Reach reach, std::span<External> values);
    template <class T, class External>
    void set(std::span<const unsigned> references, Reach reach, std::span<const External> values);

    // States live until they are released, the instance at most. nullptr is a state that does not exist yet.
    [[nodiscard]] State* save(State* overwritten);
    [[nodiscard]] State* import_state(std::span<const char> bytes);
    void restore(const State* state);
    void release(const State* state);
    [[nodiscard]] std::span<const char> bytes(const State* state) const { return find(state)->bytes(); }

    // Time that the last successful step reached.
    [[nodiscard]] double time() const { return progress_.time; }
    [[nodiscard]] Journal& journal() { return journal_; }

  private:
    using Phases = std::initializer_list<Phase>;

    void require(Phases allowed) const {
        if (std::ranges::find(allowed, progress_.phase) == allowed.end()) {
            refuse_phase(allowed);
        }
    }
    [[noreturn]] void refuse_phase(Phases allowed) const;
    // A bit for each causality that variables have.
    using Causalities = unsigned;
    static constexpr Causalities bit(Causality causality) { return 1U << static_cast<unsigned>(causality); }
    // Of all the references. Throws Refusal unless they are of this type and have so many values.
    [[nodiscard]] Causalities require_values(std::span<const unsigned> references, Reach reach, Type type,
                                             std::size_t count) const;
    [[noreturn]] void refuse_values(std::span<const unsigned> references, Reach reach, Type type,
                                    std::size_t count) const;
    [[noreturn]] void refuse_to_set(std::span<const unsigned> references, Causalities refused) const;
    [[nodiscard]] static bool fits(const Cell& cell, Reach reach, Type type) {
        if (reach == Reach::variable) {
            return cell.variable.type == type && cell.variable.elements > 0;
        }
        return (cell.variable.type == Type::enumeration ? Type::integer : cell.variable.type) == type;
    }
    [[nodiscard]] static std::size_t extent(const Cell& cell, Reach reach) {
        return reach == Reach::scalar ? 1 : cell.variable.elements;
    }
    [[nodiscard]] bool running() const {
        return progress_.phase == Phase::stepping || progress_.phase == Phase::event;
    }
    void initialise();
    void advance(double time, double size);
    [[nodiscard]] State* find(const State* state) const;
    State* keep(std::string bytes);
    // A new component with the start values.
    void begin();
    void adopt(std::unique_ptr<Component> component);

    // How far it is.
    struct Progress {
        Phase phase = Phase::instantiated;
        double start_time = 0.0;
        double stop_time = std::numeric_limits<double>::infinity();  // infinity: not defined
        double time = 0.0;
        bool initialised = false;     // the outputs belong to the parameters and inputs that are set
        std::uint64_t samples = 0;    // time events so far
        bool inputs_changed = false;  // since the component has looked at them, in model exchange

        template <class Archive>
        void serialize(Archive& archive) {
            archive(phase, start_time, stop_time, time, initialised, samples, inputs_changed);
        }
    };
    void require_possible(const Progress& progress) const;

    Fmu fmu_;
    Use use_;
    Journal journal_;
    StartValues start_values_;
    std::unique_ptr<Component> component_;
    std::vector<Cell> cells_;  // of the component and, as the last one, the time
    std::vector<std::unique_ptr<State>> states_;
    Progress progress_;
};

inline Instance::Causalities Instance::require_values(std::span<const unsigned> references, Reach reach,
                                                      Type type, std::size_t count) const {
    Causalities found = 0;
    std::size_t needed = 0;
    for (const unsigned reference : references) {
        if (reference >= cells_.size() || !fits(cells_[reference], reach, type)) {
            refuse_values(references, reach, type, count);
        }
        found |= bit(cells_[reference].variable.causality);
        needed += extent(cells_[reference], reach);
    }
    if (count != needed) {
        refuse_values(references, reach, type, count);
    }
    return found;
}

// Scalars by themselves are what most calls are about.
template <class T>
void copy_cell(void* to, const void* from, std::size_t count) {
    if (count == 1) {
        std::memcpy(to, from, sizeof(T));
    } else {
        std::memcpy(to, from, count * sizeof(T));
    }
}

// From and to where `count` scalars lie.
template <class T, class External>
void read_cell(const void* cell, External* values, std::size_t count) {
    if constexpr (std::same_as<T, External>) {
        copy_cell<T>(values, cell, count);
    } else {
        const std::span<const T> from(static_cast<const T*>(cell), count);
        const std::span<External> to(values, count);
        for (std::size_t i = 0; i < count; ++i) {
            to[i] = static_cast<External>(from[i]);
        }
    }
}

template <class T, class External>
void write_cell(void* cell, const External* values, std::size_t count) {
    if constexpr (std::same_as<External, bool>) {  // a C program may have any byte there
        const std::span<const std::byte> from = std::as_bytes(std::span(values, count));
        const std::span<T> to(static_cast<T*>(cell), count);
        for (std::size_t i = 0; i < count; ++i) {
            to[i] = from[i] != std::byte{0};
        }
    } else if constexpr (std::same_as<T, External>) {
        copy_cell<T>(cell, values, count);
    } else {
        const std::span<const External> from(values, count);
        const std::span<T> to(static_cast<T*>(cell), count);
        for (std::size_t i = 0; i < count; ++i) {
            to[i] = static_cast<T>(from[i]);
        }
    }
}

template <class T, class External>
void Instance::get(std::span<const unsigned> references, Reach reach, std::span<External> values) {
    require({Phase::initialising, Phase::stepping, Phase::event, Phase::continuous, Phase::failed,
             Phase::terminated});
    const Causalities found = require_values(references, reach, type_of<T, External>, values.size());
    if (progress_.phase == Phase::initialising && (found & bit(Causality::output)) != 0) {
        initialise();
    }
    for (const unsigned reference : references) {
        const Cell& cell = cells_[reference];
        const std::size_t count = extent(cell, reach);
        read_cell<T>(cell.address, values.data(), count);
        values = values.subspan(count);
    }
}

template <class T, class External>
void Instance::set(std::span<const unsigned> references, Reach reach, std::span<const External> values) {
    require({Phase::instantiated, Phase::initialising, Phase::stepping, Phase::event});
    const Causalities found = require_values(references, reach, type_of<T, External>, values.size());
    const Causalities refused = bit(Causality::output) | (running() ? bit(Causality::parameter) : 0U);
    if ((found & refused) != 0) {
        refuse_to_set(references, refused);
    }
    const auto store = [&](std::span<const External> left) {
        for (const unsigned reference : references) {
            const Cell& cell = cells_[reference];
            const std::size_t count = extent(cell, reach);
            write_cell<T>(cell.address, left.data(), count);
            left = left.subspan(count);
        }
    };
    if (running() && (found & bit(Causality::tunable)) != 0) {
        const auto bytes_of = [&](unsigned reference) {
            const Cell& cell = cells_[reference];
            return std::span(static_cast<std::byte*>(cell.address), extent(cell, reach) * sizeof(T));
        };
        std::vector<std::byte> before;
        for (const unsigned reference : references) {
            const auto bytes = bytes_of(reference);
            before.insert(before.end(), bytes.begin(), bytes.end());
        }
        try {
            component_->retune([&] { store(values); });
        } catch (...) {
            auto next = before.cbegin();
            for (const unsigned reference : references) {
                for (std::byte& byte : bytes_of(reference)) {
                    byte = *next++;
                }
            }
            throw;
        }
    } else {
        store(values);
    }
    if (running()) {
        progress_.inputs_changed = progress_.phase == Phase::event;
    } else {
        progress_.initialised = false;
    }
}

}  // namespace truenorth::fmi
